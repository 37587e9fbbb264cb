#include "datasets_synthetic/dust_io.h"

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets_synthetic/project_io.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"

namespace patinate::datasets {

namespace fs = std::filesystem;

namespace {

std::string control_name(const DustOptions& o) {
  return std::string(kDustFollowsNames.at(static_cast<std::size_t>(o.follows)));
}

void write_dust_frame(const DustyObject& object, int frame, const fs::path& folder, const RunControl& control) {
  const DustOptions& o = object.options();
  const double time = frame * o.interval_d;
  save_photograph(folder / photo_file(frame), dust_photo(object, time, control), o.noise, o.seed, frame);
  ImageF albedo(o.width, o.height, 3), cover(o.width, o.height), specular(o.width, o.height, 2);
  for (int y = 0; y < o.height; ++y) {
    for (int x = 0; x < o.width; ++x) {
      const std::optional<DustPlace> place = object.place(Vec2(x, y));
      if (!place) continue;
      const DustLook look = object.look(*place, time);
      for (int c = 0; c < 3; ++c) albedo.at(x, y, c) = static_cast<float>(look.albedo[c]);
      cover.at(x, y) = static_cast<float>(look.cover);
      specular.at(x, y, 0) = static_cast<float>(look.specular);
      specular.at(x, y, 1) = static_cast<float>(look.roughness);
    }
  }
  save_truth_map(folder / truth_file("albedo", frame), albedo);
  save_truth_map(folder / truth_file("cover", frame), cover);
  save_truth_map(folder / truth_file("specular", frame), specular);
}

void write_dust_maps(const DustyObject& object, const fs::path& folder, const RunControl& control) {
  const DustView view = dust_view(object, control);
  fs::create_directories(folder / "truth");
  write_obj(folder / "mesh.obj", object.mesh());
  write_codes(folder / "mask.png", view.mask);
  const ImageF& followed = object.options().follows == DustFollows::Facing ? view.facing : view.exposure;
  save_truth_map(folder / (control_name(object.options()) + ".exr"), followed);
  write_exr(folder / "truth/position.exr", view.position_mm, {"X", "Y", "Z"}, ExrDepth::Float);
  write_exr(folder / "truth/normal.exr", view.normal, {"X", "Y", "Z"}, ExrDepth::Float);
  save_truth_map(folder / "truth/facing.exr", view.facing);
  save_truth_map(folder / "truth/exposure.exr", view.exposure);
  save_truth_map(folder / "truth/light.exr", view.light);
}

Json dust_capture_json(const DustyObject& object) {
  const DustOptions& o = object.options();
  Json json = fixed_capture("dusty urn", "d");
  json["frames"] = {{"pattern", "frames/*.png"}, {"interval", o.interval_d}, {"start", 0}};
  json["mask"] = "mask.png";
  json["unit"] = "mm";
  json["scan"] = {{"mesh", "mesh.obj"}, {"camera", camera_json(object.camera())}};
  json["controls"] = Json::array({{{"name", control_name(o)},
                                   {"file", control_name(o) + ".exr"},
                                   {"unit", o.follows == DustFollows::Facing ? "cosine" : "share"}}});
  return json;
}

Json dust_truth_json(const DustOptions& o) {
  Json json = truth_header("dust", option_values(o));
  json["dust_albedo"] = vector_json(kDustAlbedo);
  json["frames"] = truth_frames(o.num_frames, o.interval_d, {"albedo", "cover", "specular"});
  return json;
}

}  // namespace

JobPlan plan_dust(const DustOptions& options, const fs::path& output) {
  check_ranges(options);
  JobInputs inputs("synth dust", 1);
  inputs.add_options(option_values(options));
  const auto object = std::make_shared<MadeOnce<DustyObject>>(
      [options](const RunControl& control) { return DustyObject(options, control); });
  JobPlan plan = plan_capture(
      inputs, output, [object](const RunControl& control) { return dust_capture_json(object->get(control)); },
      [options](const RunControl&) { return dust_truth_json(options); });
  add_frames(plan, options.num_frames, {"albedo", "cover", "specular"},
             [object](int i, const fs::path& folder, const RunControl& control) {
               write_dust_frame(object->get(control), i, folder, control);
             });
  plan.items.push_back({.name = "truth",
                        .outputs = {"mesh.obj", "mask.png", control_name(options) + ".exr", "truth/position.exr",
                                    "truth/normal.exr", "truth/facing.exr", "truth/exposure.exr", "truth/light.exr"},
                        .run = [object](const fs::path& folder, const RunControl& control) {
                          write_dust_maps(object->get(control), folder, control);
                        }});
  return plan;
}

}  // namespace patinate::datasets
