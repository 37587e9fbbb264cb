#include "datasets_synthetic/crackle_io.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "datasets_synthetic/project_io.h"
#include "libcommon/image/filters.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::datasets {

namespace {

void save_truth(const std::filesystem::path& folder, const CrackleDataset& d, const std::string& key) {
  save_truth_map(folder / "truth/thickness.exr", d.thickness_mm, key);
  save_truth_map(folder / "truth/opening.exr", d.opening_s, key);
  ImageF cells(d.cells.width(), d.cells.height());
  for (std::size_t i = 0; i < cells.values().size(); ++i) cells.values()[i] = static_cast<float>(d.cells.values()[i]);
  save_truth_map(folder / "truth/cells.exr", cells, key);
}

Json crackle_capture_json(const CrackleOptions& o) {
  Json json = fixed_capture("crackle", "s");
  json["frames"] = {{"pattern", "frames/*.png"}, {"interval", o.interval_s}, {"start", 0}};
  json["transmission"] = {{"photo", "backlight.png"}, {"blank", "backlight_blank.png"}, {"align", "none"}};
  json["texel_size_mm"] = o.texel_size_mm;
  return json;
}

Json crackle_truth_json(const CrackleDataset& d) {
  Json json = truth_header("crackle", option_values(d.options));
  json["thickness"] = {{"file", "thickness.exr"}, {"unit", "mm"}};
  json["opening"] = {{"file", "opening.exr"}, {"unit", "s"}, {"never", -1}};
  json["cells"] = {{"file", "cells.exr"}, {"count", d.num_cells}};
  std::int64_t num_dead_ends = 0;
  for (const Crack& crack : d.cracks) num_dead_ends += crack.is_dead_end ? 1 : 0;
  json["cracks"] = {{"count", d.cracks.size()}, {"dead_ends", num_dead_ends}};
  return json;
}

/// The image that says where paint is thick, at the plate's size.
ImageF read_thickness_map(const CrackleOptions& o) {
  if (o.thickness_map.empty()) return {};
  ImageF map = resize_bilinear(read_gray(o.thickness_map), o.width, o.height);
  for (float& value : map.values()) {
    if (!(value >= 0.0f && value <= 1.0f)) throw IoError(o.thickness_map, "holds values outside of 0 to 1");
  }
  return map;
}

}  // namespace

JobPlan plan_crackle(const CrackleOptions& options, const std::filesystem::path& output) {
  check_crackle(options);
  JobInputs inputs("synth crackle", 1);
  auto values = option_values(options);
  std::erase_if(values, [](const auto& v) { return v.first == "thickness_map"; });  // By content, never by path.
  inputs.add_options(values);
  if (!options.thickness_map.empty()) inputs.add_file("thickness", options.thickness_map);
  CrackleOptions named = options;  // For truth.json.
  named.thickness_map = std::filesystem::path(options.thickness_map).filename().string();
  const auto plate = std::make_shared<MadeOnce<CrackleDataset>>(
      [named, thickness = read_thickness_map(options)](const RunControl& control) {
        return crackle(named, control, thickness);
      });
  JobPlan plan = plan_capture(
      inputs, output, [options](const RunControl&) { return crackle_capture_json(options); },
      [plate](const RunControl& control) { return crackle_truth_json(plate->get(control)); });
  add_frames(plan, options.num_frames, {}, [=](int i, const std::filesystem::path& folder, const RunControl& control) {
    const CrackleDataset& d = plate->get(control);
    save_photograph(folder / photo_file(i), reflected(d, i * options.interval_s, control), options.noise, options.seed,
                    i);
  });
  plan.items.push_back(
      {"backlight", {"backlight.png", "backlight_blank.png"}, [=](const auto& folder, const RunControl& control) {
         const CrackleDataset& d = plate->get(control);
         save_photograph(folder / "backlight.png", transmitted(d), options.noise, options.seed, options.num_frames);
         save_photograph(folder / "backlight_blank.png", d.backlight, options.noise, options.seed,
                         options.num_frames + 1);
       }});
  plan.items.push_back({"truth",
                        {"truth/thickness.exr", "truth/opening.exr", "truth/cells.exr"},
                        [=, key = plan.key](const auto& folder, const RunControl& control) {
                          save_truth(folder, plate->get(control), key);
                        }});
  return plan;
}

}  // namespace patinate::datasets
