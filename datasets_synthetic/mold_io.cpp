#include "datasets_synthetic/mold_io.h"

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets_synthetic/mold_light.h"
#include "datasets_synthetic/project_io.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/json.h"
#include "patinate/datasets/crackle.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/point_cloud_io.h"

namespace patinate::datasets {

namespace fs = std::filesystem;

namespace {

/// The mold is made when the first item needs it.
struct SharedMold {
  explicit SharedMold(const MoldOptions& o)
      : options(o), rig(mold_rig(o)), mold([o](const RunControl& control) { return Mold(o, control); }) {}
  const MoldOptions options;
  const MoldRig rig;
  MadeOnce<Mold> mold;
};

fs::path step_folder(int step) { return "step" + digits(step, 2); }
std::string photo_extension(const MoldOptions& o) { return o.noise > 0.0 ? ".png" : ".exr"; }
fs::path mold_photo_file(const MoldOptions& o, int step, int light) {
  return step_folder(step) / ("light" + std::to_string(light) + photo_extension(o));
}
fs::path dark_file(const MoldOptions& o, int step) { return step_folder(step) / ("dark" + photo_extension(o)); }
fs::path in_light_file(int step, int light) {
  return fs::path("truth/in_light") / (digits(step, 2) + "_" + std::to_string(light) + ".png");
}

void save_photo(const fs::path& file, const MoldOptions& o, const ImageF& linear, int picture) {
  if (o.noise > 0.0) {
    write_codes(file, photograph(linear, o.noise, o.seed, picture));
  } else {
    write_exr(file, linear, {"R", "G", "B"}, ExrDepth::Float);
  }
}

void run_step(SharedMold& shared, int step, const fs::path& folder, const RunControl& control) {
  const Mold& mold = shared.mold.get(control);
  const MoldOptions& o = shared.options;
  fs::create_directories(folder / step_folder(step));
  fs::create_directories(folder / "truth/in_light");
  write_point_cloud(folder / step_folder(step) / "scan.ply", mold_scan(mold, shared.rig, step, control.part(0.0, 0.2)));
  const Mesh surface = mold_surface(mold, shared.rig, step, control.part(0.2, 0.3));
  const MoldPhotos photos = mold_photos(mold, shared.rig, step, surface, control.part(0.3, 1.0));
  const int num_pictures = o.num_lights + 1;
  for (int i = 0; i < o.num_lights; ++i) {
    save_photo(folder / mold_photo_file(o, step, i), o, photos.lit[i], step * num_pictures + i);
    write_codes(folder / in_light_file(step, i), photos.in_light[i]);
  }
  if (o.ambient > 0.0) save_photo(folder / dark_file(o, step), o, photos.dark, step * num_pictures + o.num_lights);
}

/// Maps that the truth has of every step.
std::vector<std::string> truth_maps(const MoldOptions& o) {
  std::vector<std::string> maps{"albedo", "specular"};
  if (o.metal) maps.insert(maps.end(), {"reflectance", "metalness"});
  if (o.relief_mm > 0.0) maps.insert(maps.end(), {"relief", "normals"});
  return maps;
}

std::vector<fs::path> truth_files(const MoldOptions& o) {
  std::vector<fs::path> files{"truth/position.exr", "truth/normal.exr", "truth/accessibility.exr", "truth/mask.png",
                              "truth/lacquered.png"};
  for (int step = 0; step < o.num_steps; ++step) {
    for (const std::string& map : truth_maps(o)) files.push_back(truth_file(map, step));
  }
  return files;
}

/// A step's maps, by truth_maps(). The reference step lies as the object's own frame does.
class StepTruth {
 public:
  StepTruth(const Mold& mold, int step)
      : mold_(mold), time_d_(step * mold.options().interval_d), maps_(truth_maps(mold.options())) {
    const auto channels = [](const std::string& map) {
      return map == "specular" ? 2 : map == "metalness" || map == "relief" ? 1 : 3;
    };
    for (const std::string& map : maps_)
      images_.emplace_back(mold.options().width, mold.options().height, channels(map));
  }
  /// @param u, v  The place in the object's frame.
  void put(int x, int y, double u, double v) {
    const MoldLook look = mold_.look(u, v, time_d_);
    for (std::size_t i = 0; i < maps_.size(); ++i) {
      const std::array<double, 3> values = values_of(maps_[i], look, u, v);
      for (int c = 0; c < images_[i].channels(); ++c) images_[i].at(x, y, c) = static_cast<float>(values[c]);
    }
  }
  void save(const fs::path& folder, int step) const {
    for (std::size_t i = 0; i < maps_.size(); ++i) {
      const fs::path file = folder / truth_file(maps_[i], step);
      if (maps_[i] == "normals") {
        fs::create_directories(file.parent_path());
        write_exr(file, images_[i], {"X", "Y", "Z"}, ExrDepth::Float);
      } else {
        save_truth_map(file, images_[i]);
      }
    }
  }

 private:
  [[nodiscard]] std::array<double, 3> values_of(const std::string& map, const MoldLook& look, double u,
                                                double v) const {
    const auto of = [](const Vec3& vector) { return std::array<double, 3>{vector.x(), vector.y(), vector.z()}; };
    if (map == "albedo") return of(look.albedo);
    if (map == "specular") return {look.specular, look.roughness, 0.0};
    if (map == "reflectance") return of(look.reflectance);
    if (map == "metalness") return {look.metalness, 0.0, 0.0};
    if (map == "relief") return {mold_.relief(u, v, time_d_), 0.0, 0.0};
    return of(mold_.normal(u, v, time_d_));
  }

  const Mold& mold_;
  double time_d_;
  std::vector<std::string> maps_;
  std::vector<ImageF> images_;
};

void run_truth(SharedMold& shared, const fs::path& folder, const RunControl& control) {
  const Mold& mold = shared.mold.get(control);
  const MoldOptions& o = shared.options;
  const MoldView view =
      mold_view(shared.rig, mold_surface(mold, shared.rig, 0, control.part(0.0, 0.3)), control.part(0.3, 0.6));
  fs::create_directories(folder / "truth");
  write_exr(folder / "truth/position.exr", view.position_mm, {"X", "Y", "Z"}, ExrDepth::Float);
  write_exr(folder / "truth/normal.exr", view.normal, {"X", "Y", "Z"}, ExrDepth::Float);
  write_codes(folder / "truth/mask.png", view.mask);
  ImageF curvature(o.width, o.height);
  ImageU8 lacquered(o.width, o.height);
  for (int step = 0; step < o.num_steps; ++step) {
    StepTruth truth(mold, step);
    for (int y = 0; y < o.height; ++y) {
      for (int x = 0; x < o.width; ++x) {
        if (view.mask.at(x, y) == 0) continue;
        const double u = static_cast<double>(view.object_mm.at(x, y, 0)),
                     v = static_cast<double>(view.object_mm.at(x, y, 1));
        truth.put(x, y, u, v);
        curvature.at(x, y) = static_cast<float>(mold.curvature(u, v));
        lacquered.at(x, y) = mold.is_lacquered(u, v) ? 255 : 0;
      }
    }
    truth.save(folder, step);
    control.report(0.6 + 0.4 * (step + 1) / o.num_steps);
  }
  save_truth_map(folder / "truth/accessibility.exr", curvature);
  write_codes(folder / "truth/lacquered.png", lacquered);
}

/// Transform from a step's scanner frame into the first one's.
RigidTransform reference_from_scan(const MoldRig& rig, int step) {
  return rig.scanner_from_object.front() * rig.scanner_from_object[step].inverse();
}

Json mold_capture_json(const MoldOptions& o, const MoldRig& rig) {
  Json json{{"format", "patinate.capture"},
            {"version", 1},
            {"name", "copper mold"},
            {"kind", "relit"},
            {"unit", "mm"},
            {"time_unit", "d"},
            {"response", "srgb"}};
  json["camera"] = camera_json(rig.camera);
  json["lights"] = Json::array();
  for (const Light& light : rig.lights)
    json["lights"].push_back({{"position", vector_json(light.position)}, {"intensity", vector_json(light.intensity)}});
  Json polygon = Json::array();
  for (const Vec2& corner : card_polygon(rig)) polygon.push_back({corner.x(), corner.y()});
  json["reference_patch"] = {{"polygon", polygon}, {"albedo", vector_json(kMoldCardAlbedo * Vec3::Ones())}};
  json["reference"] = 0;
  json["steps"] = Json::array();
  for (int step = 0; step < o.num_steps; ++step) {
    Json entry{{"time", step * o.interval_d},
               {"scan", (step_folder(step) / "scan.ply").generic_string()},
               {"photos", Json::array()}};
    for (int i = 0; i < o.num_lights; ++i) entry["photos"].push_back(mold_photo_file(o, step, i).generic_string());
    if (o.ambient > 0.0) entry["ambient"] = dark_file(o, step).generic_string();
    if (o.transforms) entry["transform"] = matrix_json(reference_from_scan(rig, step).matrix());
    json["steps"].push_back(std::move(entry));
  }
  return json;
}

Json mold_truth_json(const MoldOptions& o, const MoldRig& rig) {
  Json json = truth_header("mold", option_values(o));
  json["accessibility"] = {{"file", "accessibility.exr"}, {"unit", "1/mm"}, {"width_mm", o.radius_mm / 40.0}};
  json["steps"] = Json::array();
  for (int step = 0; step < o.num_steps; ++step) {
    Json entry{{"time", step * o.interval_d},
               {"reference_from_scan", matrix_json(reference_from_scan(rig, step).matrix())},
               {"gain", vector_json(rig.gains[step])}};
    for (const std::string& map : truth_maps(o))
      entry[map] = truth_file(map, step).lexically_relative("truth").generic_string();
    json["steps"].push_back(std::move(entry));
  }
  return json;
}

}  // namespace

JobPlan plan_mold(const MoldOptions& options, const fs::path& output) {
  const MoldOptions checked = checked_mold(options);
  JobInputs inputs("synth mold", 1);
  inputs.add_options(option_values(checked));
  const auto shared = std::make_shared<SharedMold>(checked);
  JobPlan plan = plan_capture(
      inputs, output, [shared](const RunControl&) { return mold_capture_json(shared->options, shared->rig); },
      [shared](const RunControl&) { return mold_truth_json(shared->options, shared->rig); });
  plan.parallel_items = false;
  for (int step = 0; step < checked.num_steps; ++step) {
    JobItem item{.name = "step-" + digits(step), .outputs = {step_folder(step) / "scan.ply"}, .run = {}};
    for (int i = 0; i < checked.num_lights; ++i) {
      item.outputs.push_back(mold_photo_file(checked, step, i));
      item.outputs.push_back(in_light_file(step, i));
    }
    if (checked.ambient > 0.0) item.outputs.push_back(dark_file(checked, step));
    item.run = [shared, step](const fs::path& folder, const RunControl& control) {
      run_step(*shared, step, folder, control);
    };
    plan.items.push_back(std::move(item));
  }
  plan.items.push_back(
      {.name = "truth",
       .outputs = truth_files(checked),
       .run = [shared](const fs::path& folder, const RunControl& control) { run_truth(*shared, folder, control); }});
  return plan;
}

}  // namespace patinate::datasets
