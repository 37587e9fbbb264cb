#include "datasets_synthetic/plate_io.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets_synthetic/project_io.h"
#include "libcommon/geometry/light_io.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/json.h"

namespace patinate::datasets {

namespace fs = std::filesystem;

namespace {

void write_plate_frame(const GlossyPlate& plate, int frame, const fs::path& folder, const RunControl& control) {
  const PlateOptions& o = plate.options();
  save_photograph(folder / photo_file(frame), plate_photo(plate, frame, control), o.noise, o.seed, frame);
  ImageF albedo(o.size, o.size, 3), patina(o.size, o.size), specular(o.size, o.size, 2);
  for (int y = 0; y < o.size; ++y) {
    for (int x = 0; x < o.size; ++x) {
      const PlateLook look = plate.look(x, y, frame);
      for (int c = 0; c < 3; ++c) albedo.at(x, y, c) = static_cast<float>(look.albedo[c]);
      patina.at(x, y) = static_cast<float>(look.patina);
      const double polish = (1.0 - look.patina) * look.polish_f0.mean(), other = look.patina * look.kPatinaF0;
      specular.at(x, y, 0) = static_cast<float>(polish + other);
      const double sum = polish + other;
      specular.at(x, y, 1) = static_cast<float>(
          sum > 0.0 ? (polish * look.polish_roughness + other * look.kPatinaRoughness) / sum : look.polish_roughness);
    }
  }
  save_truth_map(folder / truth_file("albedo", frame), albedo);
  save_truth_map(folder / truth_file("patina", frame), patina);
  save_truth_map(folder / truth_file("specular", frame), specular);
}

Json plate_capture_json(const GlossyPlate& plate) {
  const PlateOptions& o = plate.options();
  Json json = fixed_capture("glossy plate", "h");
  json["frames"] = {{"pattern", "frames/*.png"}, {"interval", o.interval_h}, {"start", 0}};
  json["texel_size_mm"] = o.side_mm / o.size;
  json["unit"] = "mm";
  json["plate"] = {{"camera", vector_json(plate.camera())}};
  std::vector<Light> lights;
  for (int i = 0; i < (o.moving ? o.num_frames : 1); ++i) lights.push_back(plate.lamp(i));
  json["lights"] = json_of(lights);
  return json;
}

Json plate_truth_json(const PlateOptions& o) {
  Json json = truth_header("plate", option_values(o));
  json["frames"] = truth_frames(o.num_frames, o.interval_h, {"albedo", "patina", "specular"});
  return json;
}

}  // namespace

JobPlan plan_plate(const PlateOptions& options, const fs::path& output) {
  const auto plate = std::make_shared<const GlossyPlate>(options);
  JobInputs inputs("synth plate", 1);
  inputs.add_options(option_values(options));
  JobPlan plan = plan_capture(
      inputs, output, [plate](const RunControl&) { return plate_capture_json(*plate); },
      [plate](const RunControl&) { return plate_truth_json(plate->options()); });
  add_frames(plan, options.num_frames, {"albedo", "patina", "specular"},
             [plate](int i, const fs::path& folder, const RunControl& control) {
               write_plate_frame(*plate, i, folder, control);
             });
  return plan;
}

}  // namespace patinate::datasets
