#include "tools/studio/scene_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/files/scene_files.h"
#include "simulation/files/scene_json.h"
#include "simulation/rules/rule_io.h"
#include "tools/studio/scene_text.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxPoints = 1000;  ///< Most points of one event: files allow 100,000.
constexpr std::int64_t kMaxRecordedSteps =
    900;  ///< At one place; so no event has more than the million that files allow.

bool is_paint(const Json& event) { return event.value("op", "") == "paint"; }

bool does_the_same(const Json& a, const Json& b) {
  const auto target = [](const Json& e) {
    return e.contains("emitter") ? e["emitter"].value("name", "") : e.value("target", "");
  };
  const auto what = [](const Json& e) {
    std::string names;
    for (const auto& [key, value] : e.items()) names += key + " ";
    return names;
  };
  return a["iteration"] == b["iteration"] && a["op"] == b["op"] && target(a) == target(b) && what(a) == what(b);
}

/// The element of a list of objects or emitters with this name; null = none.
Json* named(Json& list, const std::string& name) {
  for (Json& element : list) {
    if (element.is_object() && element.value("name", "") == name) return &element;
  }
  return nullptr;
}

/// Members that an event gives anew.
void take_members(const Json& event, std::initializer_list<const char*> names, Json& to) {
  for (const char* name : names) {
    if (event.contains(name)) to[name] = event.at(name);
  }
}

/// @param rules  Names of the scene's rules, in their order.
void settle_rule(Json& root, const Json& event, const std::vector<std::string>& rules) {
  const std::string target = event.value("target", "");
  Json& list = root["rules"];
  if (!list.is_array()) list = Json::array();
  const auto at = static_cast<std::size_t>(std::find(rules.begin(), rules.end(), target) - rules.begin());
  if (at >= list.size()) list.push_back({{"name", target}});
  Json& rule = at < list.size() ? list[at] : list.back();
  if (rule.is_string()) rule = {{simulation::is_rule_path(rule.get<std::string>()) ? "file" : "name", rule}};
  take_members(event, {"driver", "rate", "products", "reactants", "where", "layer"}, rule);
}

/// Makes what an event sets the beginning of the scene.
void settle(Json& root, const Json& event, const std::vector<std::string>& rules) {
  const std::string op = event.value("op", ""), target = event.value("target", "");
  if (op == "ratio") root["exchange"]["ratio"] = event.at("ratio");
  if (op == "rate") root["exchange"]["rates"][target] = event.at("rate");
  if (op == "behavior") root["behavior"] = event.at("behavior");
  if (op == "rule") settle_rule(root, event, rules);
  if (op == "emitter") {
    if (Json* emitter = named(root["emitters"], event.at("emitter").value("name", "")))
      emitter->update(event.at("emitter"));
  }
  if (Json* emitter = named(root["emitters"], target)) take_members(event, {"position", "on"}, *emitter);
  if (Json* object = named(root["objects"], target)) {
    take_members(event, {"rotate", "scale"}, *object);
    if (event.contains("position")) (*object)["translate"] = event.at("position");
  }
}

}  // namespace

SceneRecord::SceneRecord(const simulation::SceneFile& scene, Json root)
    : folder_(fs::canonical(scene.file).parent_path()),
      root_(std::make_shared<Json>(std::move(root))),
      appearance_(std::make_shared<Json>(Json::object())) {}

std::size_t SceneRecord::num_events() const { return events_.size(); }

void SceneRecord::add_emitter(const Json& emitter_of_file) { (*root_)["emitters"].push_back(emitter_of_file); }
void SceneRecord::set_resolution(int resolution) { (*root_)["atlas"]["resolution"] = resolution; }
void SceneRecord::set_seed(std::uint64_t seed) { (*root_)["seed"] = seed; }

void SceneRecord::add_event(const Json& event_of_file) {
  ++version_;
  if (events_.size() > num_fixed_ && does_the_same(*events_.back(), event_of_file)) {
    *events_.back() = event_of_file;
  } else {
    events_.push_back(std::make_shared<Json>(event_of_file));
  }
}

void SceneRecord::add_paint(const std::string& emitter, std::int64_t iteration,
                            const std::array<double, 3>& point_of_file) {
  ++version_;
  const Json* last = events_.size() > num_fixed_ ? events_.back().get() : nullptr;
  if (!last || !is_paint(*last) || (*last)["iteration"] != iteration || (*last)["target"] != emitter ||
      (*last)["points"].size() >= kMaxPoints) {
    events_.push_back(std::make_shared<Json>(
        Json{{"iteration", iteration}, {"op", "paint"}, {"target", emitter}, {"points", Json::array()}}));
  }
  Json& points = (*events_.back())["points"];
  if (!points.empty()) {
    Json& before = points.back();
    const bool is_same =
        before[0] == point_of_file[0] && before[1] == point_of_file[1] && before[2] == point_of_file[2];
    if (is_same && before.size() == 3) return before.push_back(2);
    if (is_same && before[3].get<std::int64_t>() < kMaxRecordedSteps) {
      before[3] = before[3].get<std::int64_t>() + 1;
      return;
    }
  }
  points.push_back(point_of_file);
}

SceneRecord::Events SceneRecord::events() {
  num_fixed_ = events_.size();
  return events_;
}

void SceneRecord::set_events(Events events) {
  ++version_;
  events_ = std::move(events);
  num_fixed_ = events_.size();
}

void SceneRecord::append(const std::shared_ptr<Json>& event) {
  ++version_;
  events_.push_back(event);
  num_fixed_ = events_.size();
}

SceneRecord::Appearance SceneRecord::appearance_state() const {
  const bool is_in_file = root_->contains("appearance");
  return {is_in_file ? std::make_shared<const Json>(root_->at("appearance")) : nullptr,
          std::make_shared<const Json>(*appearance_)};
}

void SceneRecord::set_appearance_state(const Appearance& state) {
  ++version_;
  if (state.of_file) {
    (*root_)["appearance"] = *state.of_file;
  } else {
    root_->erase("appearance");
  }
  *appearance_ = *state.set;
}

void SceneRecord::set_appearance(const std::string& material, const Json& members) {
  ++version_;
  (*root_)["appearance"][material].update(members);
  (*appearance_)[material].update(members);
}

Json SceneRecord::events_json() const {
  Json events = Json::array();
  for (const auto& event : events_) events.push_back(*event);
  return events;
}

Json SceneRecord::file_for(const fs::path& folder, std::int64_t iterations) const {
  Json root = *root_;
  simulation::for_each_scene_path(
      root, [&, to = fs::weakly_canonical(folder)](Json& path) { simulation::move_scene_path(path, folder_, to); });
  const bool is_painted =
      std::any_of(events_.begin(), events_.end(), [](const auto& event) { return is_paint(*event); });
  if (iterations > 0 || is_painted) root["run"]["iterations"] = iterations;
  if (events_.empty()) return root;
  Json events = Json::array();
  for (const auto& event : events_) events.push_back(*event);
  if (root.contains("events")) {
    for (const Json& event : root["events"]) events.push_back(event);
  }
  root["events"] = std::move(events);
  return root;
}

Json SceneRecord::settled(const simulation::Scene& scene) const {
  Json root = *root_;
  std::vector<std::string> rules;
  for (const simulation::Rule& rule : scene.rules) rules.push_back(rule.name);
  for (const auto& event : events_) settle(root, *event, rules);
  return root;
}

const simulation::Scene& with_brush(simulation::SceneFile& file, SceneRecord& record) {
  simulation::Scene& scene = file.scene;
  if (std::any_of(scene.emitters.begin(), scene.emitters.end(),
                  [](const simulation::Emitter& e) { return e.shape == simulation::EmitterShape::Surface; }))
    return scene;
  simulation::Emitter brush;
  const auto is_taken = [&](const std::string& name) {
    return std::any_of(scene.emitters.begin(), scene.emitters.end(),
                       [&](const simulation::Emitter& e) { return e.name == name; }) ||
           std::any_of(scene.objects.begin(), scene.objects.end(),
                       [&](const simulation::SceneObject& o) { return o.name == name; });
  };
  brush.name = "brush";
  while (is_taken(brush.name)) brush.name += "+";
  double size = 0.0;
  for (const simulation::SceneObject& object : scene.objects)
    size = std::max(size, object.scale * bounding_box(object.mesh).diagonal());
  brush.shape = simulation::EmitterShape::Surface;
  brush.position_mm = scene.objects.front().translate_mm;
  brush.size_mm = {rounded(size / 20.0, 3), 0.0};
  brush.distance_mm = rounded(size / 50.0, 3);
  brush.speed_mm_s = rounded(size, 3);
  brush.spread_deg = 10.0;
  brush.gammatons = 1000;
  brush.carries[0] = 1.0;
  brush.is_on = false;
  const Json json = emitter_of_file(brush, scene.materials, file.mm_per_unit);
  record.add_emitter(json);
  const Json list = Json::array({json});
  simulation::SceneContext context;
  context.materials = scene.materials;
  context.mm_per_unit = file.mm_per_unit;
  scene.emitters.push_back(simulation::read_emitter(JsonReader("brush", list).elements().front(), context));
  return scene;
}

}  // namespace patinate::studio
