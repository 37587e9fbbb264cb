#include "datasets_synthetic/crackle_io.h"

#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "libcommon/image/filters.h"
#include "libcommon/job/cost_model.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::datasets {

namespace {

// The plate, made when the first item needs it and shared by all.
class SharedPlate {
 public:
  SharedPlate(const CrackleOptions& options, ImageF thickness) : options_(options), thickness_(std::move(thickness)) {
    options_.thickness_map = std::filesystem::path(options_.thickness_map).filename().string();  // For truth.json.
  }
  const CrackleDataset& get(const RunControl& control) {
    const std::lock_guard lock(mutex_);
    if (!dataset_) {
      RunControl quiet = control;
      quiet.on_progress = nullptr;
      dataset_ = std::make_unique<CrackleDataset>(crackle(options_, quiet, thickness_));
    }
    return *dataset_;
  }

 private:
  CrackleOptions options_;
  ImageF thickness_;  ///< Empty: drawn from the seed.
  std::mutex mutex_;
  std::unique_ptr<CrackleDataset> dataset_;
};

std::string four_digits(int index) {
  const std::string digits = std::to_string(index);
  return std::string(digits.size() < 4 ? 4 - digits.size() : 0, '0') + digits;
}

void save_photograph(const std::filesystem::path& file, const CrackleOptions& o, const ImageF& linear, int picture) {
  std::filesystem::create_directories(file.parent_path());
  write_codes(file, photograph(linear, o.noise, o.seed, picture));
}

void save_truth(const std::filesystem::path& folder, const CrackleDataset& d, const std::string& key) {
  std::filesystem::create_directories(folder / "truth");
  write_exr(folder / "truth/thickness.exr", d.thickness_mm, {"Y"}, ExrDepth::Float, key);
  write_exr(folder / "truth/opening.exr", d.opening_s, {"Y"}, ExrDepth::Float, key);
  ImageF cells(d.cells.width(), d.cells.height());
  for (std::size_t i = 0; i < cells.values().size(); ++i) cells.values()[i] = static_cast<float>(d.cells.values()[i]);
  write_exr(folder / "truth/cells.exr", cells, {"Y"}, ExrDepth::Float, key);
}

Json capture_json(const CrackleOptions& o) {
  Json json;
  json["format"] = "patinate.capture";
  json["version"] = 1;
  json["name"] = "crackle";
  json["kind"] = "fixed";
  json["time_unit"] = "s";
  json["response"] = "srgb";
  json["frames"] = {{"pattern", "frames/*.png"}, {"interval", o.interval_s}, {"start", 0}};
  json["transmission"] = {{"photo", "backlight.png"}, {"blank", "backlight_blank.png"}, {"align", "none"}};
  json["texel_size_mm"] = o.texel_size_mm;
  return json;
}

Json truth_json(const CrackleDataset& d, const std::string& key) {
  Json json;
  json["format"] = "patinate.synthetic";
  json["version"] = 1;
  json["kind"] = "crackle";
  for (const auto& [name, value] : option_values(d.options)) json["options"][name] = value;
  json["thickness"] = {{"file", "thickness.exr"}, {"unit", "mm"}};
  json["opening"] = {{"file", "opening.exr"}, {"unit", "s"}, {"never", -1}};
  json["cells"] = {{"file", "cells.exr"}, {"count", d.num_cells}};
  std::int64_t num_dead_ends = 0;
  for (const Crack& crack : d.cracks) num_dead_ends += crack.is_dead_end ? 1 : 0;
  json["cracks"] = {{"count", d.cracks.size()}, {"dead_ends", num_dead_ends}};
  json["key"] = key;
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

/// Of any item, each of which makes the plate first: measured on 192 x 192 and 384 x 384 pixels.
constexpr CostModel kPlateCost{0.03, 4.4e-6, 32.0, 170.0};

}  // namespace

JobPlan plan_crackle(const CrackleOptions& options, const std::filesystem::path& output) {
  check_crackle(options);
  JobInputs inputs("synth crackle", 1);
  auto values = option_values(options);
  std::erase_if(values, [](const auto& v) { return v.first == "thickness_map"; });  // By content, never by path.
  inputs.add_options(values);
  if (!options.thickness_map.empty()) inputs.add_file("thickness", options.thickness_map);
  JobPlan plan = inputs.plan(output, "truth/truth.json");
  const JobCost cost = kPlateCost.of(static_cast<double>(options.width) * options.height);
  const auto plate = std::make_shared<SharedPlate>(options, read_thickness_map(options));
  for (int i = 0; i < options.num_frames; ++i) {
    const std::filesystem::path file = std::filesystem::path("frames") / (four_digits(i) + ".png");
    plan.items.push_back({"frame-" + four_digits(i), {file}, [=](const auto& folder, const RunControl& control) {
                            const CrackleDataset& d = plate->get(control);
                            save_photograph(folder / file, options, reflected(d, i * options.interval_s, control), i);
                          }});
  }
  plan.items.push_back(
      {"backlight", {"backlight.png", "backlight_blank.png"}, [=](const auto& folder, const RunControl& control) {
         const CrackleDataset& d = plate->get(control);
         save_photograph(folder / "backlight.png", options, transmitted(d), options.num_frames);
         save_photograph(folder / "backlight_blank.png", options, d.backlight, options.num_frames + 1);
       }});
  plan.items.push_back({"truth",
                        {"truth/thickness.exr", "truth/opening.exr", "truth/cells.exr"},
                        [=, key = plan.key](const auto& folder, const RunControl& control) {
                          save_truth(folder, plate->get(control), key);
                        }});
  for (JobItem& item : plan.items) item.cost = cost;
  plan.join_cost = cost;
  plan.join = [=, key = plan.key](const auto& folder, const RunControl& control) {
    save_json(folder / "capture.json", capture_json(options));
    save_json(folder / "truth/truth.json", truth_json(plate->get(control), key));
  };
  return plan;
}

}  // namespace patinate::datasets
