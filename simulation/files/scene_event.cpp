#include "simulation/files/scene_event.h"

#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "patinate/core/error.h"
#include "simulation/files/scene_json.h"

namespace patinate::simulation {

namespace {

/// Names that events may speak of, without meshes and pictures: a brush sends many.
Scene names_in(const Scene& scene) {
  Scene names;
  names.materials = scene.materials;
  names.emitters = scene.emitters;
  names.rules = scene.rules;
  for (const SceneObject& object : scene.objects) {
    SceneObject& named = names.objects.emplace_back();
    named.name = object.name;
    for (const Layer& layer : object.layers) named.layers.emplace_back().name = layer.name;
  }
  for (const SceneMap& map : scene.maps) names.maps.emplace_back().name = map.name;
  names.time_per_iteration = scene.time_per_iteration;
  return names;
}

}  // namespace

SceneEvent parse_event(const Json& event_of_file, const Scene& scene, double mm_per_unit) {
  const Json list = Json::array({event_of_file});
  SceneContext context;
  context.materials = scene.materials;
  context.mm_per_unit = mm_per_unit;
  context.time_per_iteration = scene.time_per_iteration;
  context.weather = scene.weather.is_given;
  context.read_picture = [](const JsonReader& json, int) -> ImageF { json.fail("a color [r, g, b]"); };
  try {
    Scene with_event = names_in(scene);
    read_events(JsonReader("event", list, ""), context, with_event);
    std::vector<SceneEvent>& events = with_event.events;
    if (!with_event.series.empty()) throw InvalidInput("/every: an event happens now; leave it out");
    if (events.size() != 1)
      throw InvalidInput("stands for " + std::to_string(events.size()) + " events; send one at a time");
    return std::move(events.front());
  } catch (const InputError& e) {
    constexpr std::string_view kPlace = "event: /0";  // there is no file, and one event
    const std::string_view what = e.what();
    throw InvalidInput("event: " +
                       std::string(what.substr(0, kPlace.size()) == kPlace ? what.substr(kPlace.size()) : what));
  }
}

}  // namespace patinate::simulation
