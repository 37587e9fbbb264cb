#include "datasets_synthetic/drying_io.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets_synthetic/project_io.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/json.h"

namespace patinate::datasets {

namespace fs = std::filesystem;

namespace {

void write_drying_frame(const DryingPatch& patch, int frame, const fs::path& folder, const RunControl& control) {
  const DryingOptions& o = patch.options();
  const double time = frame * o.interval_min;
  save_photograph(folder / photo_file(frame), drying_photo(patch, time, control), o.noise, o.seed, frame);
  ImageF albedo(o.width, o.height, 3), wetness(o.width, o.height), specular(o.width, o.height, 2);
  for (int y = 0; y < o.height; ++y) {
    for (int x = 0; x < o.width; ++x) {
      const DryingLook look = patch.look(x, y, time);
      for (int c = 0; c < 3; ++c) albedo.at(x, y, c) = static_cast<float>(look.albedo[c]);
      wetness.at(x, y) = static_cast<float>(look.wetness);
      specular.at(x, y, 0) = static_cast<float>(look.specular);
      specular.at(x, y, 1) = static_cast<float>(look.roughness);
    }
  }
  save_truth_map(folder / truth_file("albedo", frame), albedo);
  save_truth_map(folder / truth_file("wetness", frame), wetness);
  save_truth_map(folder / truth_file("specular", frame), specular);
}

void write_drying_maps(const DryingPatch& patch, const fs::path& folder) {
  const DryingOptions& o = patch.options();
  ImageF onset(o.width, o.height), film(o.width, o.height);
  for (int y = 0; y < o.height; ++y) {
    for (int x = 0; x < o.width; ++x) {
      onset.at(x, y) = static_cast<float>(patch.onset_min(x, y));
      film.at(x, y) = static_cast<float>(patch.film_mm(x, y));
    }
  }
  save_truth_map(folder / "truth/onset.exr", onset);
  save_truth_map(folder / "truth/film.exr", film);
}

Json drying_capture_json(const DryingOptions& o) {
  Json json = fixed_capture("drying patch", "min");
  json["frames"] = {{"pattern", "frames/*.png"}, {"interval", o.interval_min}, {"start", 0}};
  json["texel_size_mm"] = o.texel_size_mm;
  return json;
}

Json drying_truth_json(const DryingOptions& o) {
  Json json = truth_header("drying", option_values(o));
  json["onset"] = {{"file", "onset.exr"}, {"unit", "min"}, {"outside", -1}};
  json["film"] = {{"file", "film.exr"}, {"unit", "mm"}};
  json["frames"] = truth_frames(o.num_frames, o.interval_min, {"albedo", "wetness", "specular"});
  return json;
}

}  // namespace

JobPlan plan_drying(const DryingOptions& options, const fs::path& output) {
  const auto patch = std::make_shared<const DryingPatch>(options);
  JobInputs inputs("synth drying", 1);
  inputs.add_options(option_values(options));
  JobPlan plan = plan_capture(
      inputs, output, [options](const RunControl&) { return drying_capture_json(options); },
      [options](const RunControl&) { return drying_truth_json(options); });
  add_frames(plan, options.num_frames, {"albedo", "wetness", "specular"},
             [patch](int i, const fs::path& folder, const RunControl& control) {
               write_drying_frame(*patch, i, folder, control);
             });
  plan.items.push_back(
      {.name = "truth",
       .outputs = {"truth/onset.exr", "truth/film.exr"},
       .run = [patch](const fs::path& folder, const RunControl&) { write_drying_maps(*patch, folder); }});
  return plan;
}

}  // namespace patinate::datasets
