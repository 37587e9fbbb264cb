#include "app/fit/fit_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "app/fit/scene_pointer.h"
#include "app/request/usage_error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/files/scene_files.h"
#include "simulation/job/aged_frames.h"
#include "simulation/job/simulation_job.h"

namespace patinate::app {

namespace fs = std::filesystem;

namespace {

/// Members that decide about the result beside the physics, or are no number that a simulation follows.
const std::vector<std::string> kFixed{"/version", "/seed", "/atlas/resolution"};

bool is_path(const Json& json) {
  return json.is_string() &&
         (json.get<std::string>().ends_with(".json") || json.get<std::string>().find('/') != std::string::npos);
}

}  // namespace

FitScene::FitScene(const fs::path& file, const std::vector<analysis::FitRange>& ranges,
                   const std::vector<std::string>& controls, const RunControl& control)
    : file_(file), root_(std::make_shared<Json>(load_json(file))) {
  given_ = root_->dump();
  base_ = std::make_shared<const simulation::SceneFile>(simulation::read_scene(file_, *root_, *assets_, control));
  const std::vector<std::string> known = simulation::parameter_map_names(base_->scene.materials);
  controls_ = base_->controls;
  for (const std::string& name : controls) {
    if (std::find(known.begin(), known.end(), name) != known.end() &&
        std::find(controls_.begin(), controls_.end(), name) == controls_.end())
      controls_.push_back(name);
  }
  for (const analysis::FitRange& range : ranges) add_parameter(range);
  for (analysis::FitParameter& p : parameters_) {
    p.words = words_of(*root_, p.range.name);
    p.unit = unit_of(*root_, p.range.name);
  }
  std::map<std::string, int> count;  // Two emitters may have one name.
  for (const analysis::FitParameter& p : parameters_) ++count[p.words];
  for (analysis::FitParameter& p : parameters_) {
    if (count[p.words] > 1) p.words = p.range.name;
  }
}

void FitScene::add_parameter(const analysis::FitRange& range) {
  Json& root = *root_;
  const std::string& pointer = range.name;
  const auto fail = [&](const std::string& problem) {
    if (range.place.empty()) throw UsageError((range.is_own ? "--own: " : "--vary: ") + pointer + ": " + problem);
    throw IoError(range.place, pointer + " " + problem);
  };
  for (const analysis::FitParameter& p : parameters_) {
    if (p.range.name == pointer) fail("is given twice");
  }
  if (std::find(kFixed.begin(), kFixed.end(), pointer) != kFixed.end())
    fail("cannot be varied: it is no property of the surface or its weather");
  // A rule that only has a name has a rate all the same; scene files of version 1 call it alpha.
  const char* const rate = root.value("version", 2) == 1 ? "alpha" : "rate";
  if (Json* rules = found_at(root, "/rules"); rules != nullptr && rules->is_array()) {
    for (std::size_t i = 0; i < rules->size(); ++i) {
      Json& rule = (*rules)[i];
      if (pointer != "/rules/" + std::to_string(i) + "/" + rate || (rule.is_object() && rule.contains(rate))) continue;
      Json whole = rule.is_string() ? Json{{is_path(rule) ? "file" : "name", rule}} : rule;
      whole[rate] = base_->scene.rules[i].rate;
      rule = std::move(whole);
    }
  }
  Json* value = found_at(root, pointer);
  if (value == nullptr) {
    std::vector<std::string> all;
    collect_numbers(root, "", kFixed, all);
    fail("is not in " + file_.string() + nearest_pointers(pointer, all));
  }
  if (!value->is_number()) fail("is " + value->dump().substr(0, 40) + " in " + file_.string() + "; expected a number");
  analysis::FitParameter parameter{.range = range,
                                   .start = value->get<double>(),
                                   .is_whole = false,
                                   .is_appearance = pointer.starts_with("/appearance/")};
  const Json before = *value;
  for (const double end : {range.low, range.high}) {
    *value = end;
    (void)read(root);  // Says what is wrong with it, and where.
  }
  const double between = std::floor(range.low) + 0.5;
  if (before.is_number_integer() && between > range.low && between < range.high) {
    *value = between;
    try {
      (void)read(root);
    } catch (const IoError&) {
      parameter.is_whole = true;
    }
  }
  *value = before;
  parameters_.push_back(std::move(parameter));
}

Json FitScene::with(const std::vector<double>& values) const {
  Json json = *root_;
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    Json& at = *found_at(json, parameters_[i].range.name);
    if (parameters_[i].is_whole)
      at = static_cast<std::int64_t>(values[i]);
    else
      at = values[i];
  }
  return json;
}

simulation::SceneFile FitScene::read(const Json& json) const {
  simulation::SceneFile file = simulation::read_scene(file_, json, *assets_);
  file.controls = controls_;
  return file;
}

analysis::SurfaceOutline FitScene::outline() const {
  analysis::SurfaceOutline outline{.name = base_->name,
                                   .width = base_->scene.resolution,
                                   .height = base_->scene.resolution,
                                   .time_unit = base_->time_unit,
                                   .times = {},
                                   .control_names = controls_,
                                   .texel_size_mm = simulation::Simulation(base_->scene).texel_size_mm()};
  for (std::int64_t i = 0; i < base_->iterations; i += base_->history_every)
    outline.times.push_back(base_->frame_time(i));
  outline.times.push_back(base_->frame_time(base_->iterations));
  return outline;
}

analysis::AgeWith FitScene::age() const {
  return [scene = *this](const std::vector<double>& values, std::uint64_t seed_shift,
                         const RunControl& control) -> analysis::ComposeWith {
    simulation::SceneFile file = scene.read(scene.with(values));
    file.scene.seed += seed_shift + scene.seed_shift_;
    const auto aged = std::make_shared<simulation::AgedFrames>(file, simulation::SimulationOptions{}, control);
    return [scene, aged](const std::vector<double>& appearance_values, const RunControl& appearance_control) {
      return scene.surface_of(*aged, scene.read(scene.with(appearance_values)).scene.appearance, appearance_control);
    };
  };
}

analysis::AgedSurface FitScene::surface_of(simulation::AgedFrames& aged,
                                           const std::vector<simulation::MaterialAppearance>& appearance,
                                           const RunControl& control) const {
  analysis::AgedSurface frames{.name = base_->name,
                               .time_unit = base_->time_unit,
                               .texel_size_mm = aged.texel_size_mm(),
                               .times = aged.times(),
                               .colors = {},
                               .mask = aged.coverage(),
                               .controls = {}};
  frames.colors = aged.compose(appearance, control);
  for (const simulation::ParameterControl& c : aged.controls()) {
    analysis::SurfaceControl& control_map = frames.controls.emplace_back();
    control_map.parameter = ControlFacts{.name = c.name, .low = c.low, .high = c.high, .unit = c.unit};
    control_map.values = c.values;
  }
  return frames;
}

analysis::AgedSurface FitScene::aged(const Json& json, const RunControl& control,
                                     const std::function<void(simulation::Scene& scene)>& change) const {
  simulation::SceneFile file = read(json);
  change(file.scene);
  simulation::AgedFrames frames(file, simulation::SimulationOptions{}, control.part(0.0, 0.9));
  return surface_of(frames, file.scene.appearance, control.part(0.9, 1.0));
}

void FitScene::move_paths(Json& json, const fs::path& output) const {
  const fs::path from = fs::weakly_canonical(fs::absolute(file_).parent_path()),
                 to = fs::weakly_canonical(fs::absolute(output));
  simulation::for_each_scene_path(json, [&](Json& path) { simulation::move_scene_path(path, from, to); });
}

void FitScene::add_inputs(JobInputs& inputs) const {
  inputs.add_content("scene", file_.filename().string(), ContentHash().add(given_).hex());
  for (const auto& [role, path] : base_->inputs) inputs.add_file(role, path, folder_of(file_));
}

FitScene FitScene::with_seed_shift(std::uint64_t shift) const {
  FitScene scene = *this;
  scene.seed_shift_ = shift;
  return scene;
}

void FitScene::write(const fs::path& folder, const std::string& file, const fs::path& output,
                     const std::vector<double>& values) const {
  Json json = with(values);
  if (seed_shift_ > 0) json["seed"] = base_->scene.seed + seed_shift_;
  move_paths(json, output);
  save_json(folder / (file + ".json"), json);
}

}  // namespace patinate::app
