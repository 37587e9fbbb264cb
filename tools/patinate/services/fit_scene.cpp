#include "tools/patinate/services/fit_scene.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/job/aged_frames.h"
#include "simulation/job/simulation_job.h"
#include "tools/patinate/command_line/usage_error.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// What decides about the result beside the physics, or is no number that a simulation follows.
const std::set<std::string> kFixed{"/version", "/seed", "/atlas/resolution"};

std::string unescaped(std::string token) {
  for (const auto& [from, to] : {std::pair{"~1", "/"}, std::pair{"~0", "~"}}) {
    for (std::size_t at = token.find(from); at != std::string::npos; at = token.find(from, at + 1))
      token.replace(at, 2, to);
  }
  return token;
}

std::string escaped(const std::string& token) {
  std::string out;
  for (char c : token) out += c == '~' ? std::string("~0") : c == '/' ? std::string("~1") : std::string(1, c);
  return out;
}

/// What a pointer points to; nullptr when that is nothing.
Json* found_at(Json& root, const std::string& pointer) {
  Json* at = &root;
  std::size_t begin = 1;
  while (begin <= pointer.size()) {
    const std::size_t end = std::min(pointer.find('/', begin), pointer.size());
    const std::string token = unescaped(pointer.substr(begin, end - begin));
    if (at->is_object() && at->contains(token)) {
      at = &(*at)[token];
    } else if (at->is_array() && !token.empty() && token.size() < 8 &&
               token.find_first_not_of("0123456789") == std::string::npos && std::stoul(token) < at->size()) {
      at = &(*at)[std::stoul(token)];
    } else {
      return nullptr;
    }
    begin = end + 1;
  }
  return at;
}

void collect_numbers(const Json& json, const std::string& pointer, std::vector<std::string>& out) {
  if (json.is_number() && !kFixed.contains(pointer)) out.push_back(pointer);
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) collect_numbers(value, pointer + "/" + escaped(key), out);
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) collect_numbers(json[i], pointer + "/" + std::to_string(i), out);
  }
}

/// Pointers that begin most like the wrong one.
std::string nearest(const std::string& pointer, const std::vector<std::string>& all) {
  if (const std::string one = did_you_mean(pointer, all); !one.empty()) return one;
  const auto common = [&](const std::string& other) {
    return static_cast<std::size_t>(std::mismatch(pointer.begin(), pointer.end(), other.begin(), other.end()).first -
                                    pointer.begin());
  };
  std::vector<std::string> sorted = all;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const std::string& a, const std::string& b) { return common(a) > common(b); });
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(4, sorted.size()); ++i)
    text += (text.empty() ? "" : ", ") + sorted[i];
  return text.empty() ? "" : "; numbers of the scene that are named most alike: " + text;
}

bool is_path(const Json& json) {
  return json.is_string() &&
         (json.get<std::string>().ends_with(".json") || json.get<std::string>().find('/') != std::string::npos);
}

/// f(path) for every path that a scene holds.
template <class F>
void for_each_path(Json& root, F&& f) {
  const auto visit = [&](Json& object, const char* key) {
    if (object.is_object() && object.contains(key) && object[key].is_string()) f(object[key]);
  };
  for (const char* list : {"presets", "appearance"}) {
    if (!root.contains(list)) continue;
    for (auto& member : root[list].items()) visit(member.value(), "color");
  }
  for (Json& object : root["objects"]) {
    visit(object, "mesh");
    if (!object.contains("maps")) continue;
    for (const char* map : {"color", "height", "normal", "specular"}) visit(object["maps"], map);
  }
  if (!root.contains("rules")) return;
  for (Json& rule : root["rules"]) {
    if (is_path(rule)) f(rule);
    visit(rule, "file");
  }
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
}

void FitScene::add_parameter(const analysis::FitRange& range) {
  Json& root = *root_;
  const std::string& pointer = range.name;
  const auto fail = [&](const std::string& problem) {
    if (range.place.empty()) throw UsageError("--vary: " + pointer + ": " + problem);
    throw IoError(range.place, pointer + " " + problem);
  };
  for (const analysis::FitParameter& p : parameters_) {
    if (p.range.name == pointer) fail("is given twice");
  }
  if (kFixed.contains(pointer)) fail("cannot be varied: it is no property of the surface or its weather");
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
    collect_numbers(root, "", all);
    fail("is not in " + file_.string() + nearest(pointer, all));
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

double FitScene::aging_seconds() const { return simulation::iterations_seconds(base_->scene, base_->iterations); }

analysis::AgeWith FitScene::age() const {
  return [scene = *this](const std::vector<double>& values, std::uint64_t seed_shift,
                         const RunControl& control) -> analysis::ComposeWith {
    simulation::SceneFile file = scene.read(scene.with(values));
    file.scene.seed += seed_shift;
    const auto aged = std::make_shared<simulation::AgedFrames>(file, simulation::SimulationOptions{}, control);
    return [scene, aged](const std::vector<double>& appearance_values, const RunControl& appearance_control) {
      analysis::AgedSurface frames{.name = scene.base_->name,
                                   .time_unit = scene.base_->time_unit,
                                   .texel_size_mm = aged->texel_size_mm(),
                                   .times = aged->times(),
                                   .colors = {},
                                   .mask = aged->coverage(),
                                   .controls = {}};
      frames.colors = aged->compose(scene.read(scene.with(appearance_values)).scene.appearance, appearance_control);
      for (const simulation::ParameterControl& c : aged->controls()) {
        analysis::SurfaceControl& control_map = frames.controls.emplace_back();
        control_map.parameter = ControlFacts{.name = c.name, .low = c.low, .high = c.high, .unit = c.unit};
        control_map.values = c.values;
      }
      return frames;
    };
  };
}

void FitScene::add_inputs(JobInputs& inputs) const {
  inputs.add_content("scene", file_.filename().string(), ContentHash().add(given_).hex());
  for (const auto& [role, path] : base_->inputs) inputs.add_file(role, path, folder_of(file_));
}

void FitScene::write(const fs::path& folder, const fs::path& output, const std::vector<double>& values) const {
  Json json = with(values);
  const fs::path target = fs::weakly_canonical(fs::absolute(output));
  for_each_path(json, [&](Json& path) {
    path = fs::relative(fs::weakly_canonical(fs::absolute(file_.parent_path() / path.get<std::string>())), target)
               .string();
  });
  save_json(folder / "scene.json", json);
}

}  // namespace patinate::cli
