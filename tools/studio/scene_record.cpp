#include "tools/studio/scene_record.h"

#include <nlohmann/json.hpp>

#include "libcommon/core/error.h"
#include "simulation/scene/scene_files.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

bool does_the_same(const Json& a, const Json& b) {
  const auto target = [](const Json& e) { return e.contains("emitter") ? e["emitter"].value("name", "") : e.value("target", ""); };
  const auto what = [](const Json& e) {
    std::string names;
    for (const auto& [key, value] : e.items()) names += key + " ";
    return names;
  };
  return a["iteration"] == b["iteration"] && a["op"] == b["op"] && target(a) == target(b) && what(a) == what(b);
}

}  // namespace

SceneRecord::SceneRecord(const SceneFile& scene)
    : folder_(fs::canonical(scene.file).parent_path()), root_(std::make_shared<Json>(load_json(scene.file))), events_(std::make_shared<Json>(Json::array())) {}

std::size_t SceneRecord::num_events() const { return events_->size(); }

void SceneRecord::add_emitter(const Json& emitter_of_file) { (*root_)["emitters"].push_back(emitter_of_file); }
void SceneRecord::set_resolution(int resolution) { (*root_)["atlas"]["resolution"] = resolution; }
void SceneRecord::set_seed(std::uint64_t seed) { (*root_)["seed"] = seed; }

void SceneRecord::add_event(const Json& event_of_file) {
  if (events_->size() > num_fixed_ && does_the_same(events_->back(), event_of_file)) {
    events_->back() = event_of_file;
  } else {
    events_->push_back(event_of_file);
  }
}

std::size_t SceneRecord::mark() { return num_fixed_ = events_->size(); }

void SceneRecord::forget_after(std::size_t mark) {
  while (events_->size() > mark) events_->erase(events_->size() - 1);
  num_fixed_ = events_->size();
}

void SceneRecord::set_look(const std::string& material, const Json& members) { (*root_)["appearance"][material].update(members); }

Json SceneRecord::file_for(const fs::path& folder, std::int64_t iterations) const {
  Json root = *root_;
  for_each_scene_path(root, [&, to = fs::weakly_canonical(folder)](Json& path) { move_scene_path(path, folder_, to); });
  if (iterations > 0) root["run"]["iterations"] = iterations;
  if (events_->empty()) return root;
  Json events = *events_;
  if (root.contains("events")) {
    for (const Json& event : root["events"]) events.push_back(event);
  }
  root["events"] = std::move(events);
  return root;
}

}  // namespace patinate
