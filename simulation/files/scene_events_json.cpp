// The "events" of a scene file.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/files/scene_json.h"
#include "simulation/files/scene_lengths.h"
#include "simulation/rules/rule_io.h"
#include "simulation/rules/scene_maps.h"

namespace patinate::simulation {

namespace {

constexpr std::int64_t kLongestStroke = 1'000'000;
constexpr std::size_t kMaxPoints = 100'000;
constexpr double kMostIterations = 1e12;  ///< Bound of an untrusted file.

std::vector<std::string> names_of(const auto& items) {
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

void check_target(const JsonReader& json, const std::string& name, const std::vector<std::string>& names,
                  const std::string& kind) {
  if (std::find(names.begin(), names.end(), name) == names.end())
    json.fail("the name of " + kind + did_you_mean(name, names));
}

/// A member that names an emitter.
std::string read_emitter_name(JsonReader& json, const Scene& scene) {
  std::string name = json.member("target").string();
  check_target(json.member("target"), name, names_of(scene.emitters), "an emitter");
  return name;
}

/// Name of an object.
std::string read_object_name(JsonReader& json, const Scene& scene) {
  std::string name = json.member("target").string();
  check_target(json.member("target"), name, names_of(scene.objects), "an object");
  return name;
}

/// A brush's way: on at the first point, one point every `every` iterations and even steps between them, off after the
/// last.
void read_stroke(JsonReader json, const SceneContext& context, const Scene& scene, std::vector<SceneEvent>& events) {
  const std::int64_t begin = json.member("iteration").integer(at_least(0));
  (void)json.member("op");
  const std::string brush = read_emitter_name(json, scene);
  const std::int64_t every = json.has("every") ? json.member("every").integer(between(1, 1e6)) : 1;
  std::vector<Vec3> points;
  for (const JsonReader& point : json.member("points").elements(kMaxPoints))
    points.push_back(read_position(point, context.mm_per_unit));
  if (points.empty()) json.member("points").fail("at least one position");
  if (static_cast<std::int64_t>(points.size()) * every > kLongestStroke)
    json.fail("at most " + std::to_string(kLongestStroke) + " iterations");
  json.finish();
  events.push_back({begin, SwitchEvent{.emitter = brush, .is_on = true}});
  const std::int64_t steps = static_cast<std::int64_t>(points.size() - 1) * every;
  for (std::int64_t i = 0; i <= steps; ++i) {
    const auto k = static_cast<std::size_t>(i / every);
    const double share = static_cast<double>(i % every) / static_cast<double>(every);
    const Vec3 place = share == 0.0 ? points[k] : Vec3((1.0 - share) * points[k] + share * points[k + 1]);
    events.push_back({begin + i, MoveEvent{.target = brush, .position_mm = place}});
  }
  events.push_back({begin + steps + every, SwitchEvent{.emitter = brush, .is_on = false}});
}

/// Places of a brush that paints alone: [x, y, z], one step, or [x, y, z, steps].
std::vector<BrushStop> read_stops(const JsonReader& json, double mm_per_unit) {
  std::vector<BrushStop> stops;
  std::int64_t num_steps = 0;
  for (const JsonReader& point : json.elements(kMaxPoints)) {
    const std::vector<JsonReader> parts = point.elements(4);
    if (parts.size() < 3) point.fail("[x, y, z], or [x, y, z, steps]");
    const Vec3 place(parts[0].number(), parts[1].number(), parts[2].number());
    BrushStop stop{.position_mm = checked_position(point, place * mm_per_unit)};
    if (parts.size() > 3) stop.steps = parts[3].integer(between(1, 1e6));
    num_steps += stop.steps;
    stops.push_back(stop);
  }
  if (stops.empty()) json.fail("at least one position");
  if (num_steps > kLongestStroke) json.fail("at most " + std::to_string(kLongestStroke) + " steps together");
  return stops;
}

SceneAction read_move(JsonReader& json, const SceneContext& context, const Scene& scene) {
  MoveEvent event{.target = json.member("target").string()};
  std::vector<std::string> movable = names_of(scene.objects);
  const std::vector<std::string> emitters = names_of(scene.emitters);
  movable.insert(movable.end(), emitters.begin(), emitters.end());
  check_target(json.member("target"), event.target, movable, "an object or emitter");
  event.position_mm = read_position(json.member("position"), context.mm_per_unit);
  return event;
}

Vec3 read_angles(const JsonReader& json) {
  const std::vector<double> v = json.numbers(3);
  return {v[0], v[1], v[2]};
}

SceneAction read_turn(JsonReader& json, const SceneContext&, const Scene& scene) {
  return TurnEvent{.object = read_object_name(json, scene), .rotate_deg = read_angles(json.member("rotate"))};
}

SceneAction read_scale(JsonReader& json, const SceneContext&, const Scene& scene) {
  return ScaleEvent{.object = read_object_name(json, scene), .scale = json.member("scale").number(above(0))};
}

SceneAction read_changed_emitter(JsonReader& json, const SceneContext& context, const Scene& scene) {
  EmitterEvent event{.emitter = read_emitter(json.member("emitter"), context)};
  check_target(json.member("emitter").member("name"), event.emitter.name, names_of(scene.emitters),
               "an emitter of the scene (with gammatons 1 and \"on\": false it can wait for its time)");
  for (const Emitter& e : scene.emitters) {
    if (e.name == event.emitter.name && e.gammatons != event.emitter.gammatons) {
      json.member("emitter").fail("the same number of gammatons as before (" + std::to_string(e.gammatons) +
                                  "): the streams of the others would shift");
    }
  }
  return event;
}

SceneAction read_ratio(JsonReader& json, const SceneContext&, const Scene&) {
  return RatioEvent{.ratio = json.member("ratio").number(between(0, 1))};
}

SceneAction read_rate(JsonReader& json, const SceneContext& context, const Scene&) {
  RateEvent event{.material = json.member("target").string()};
  (void)material_index(json.member("target"), event.material, context.materials);
  event.rate = json.member("rate").number(between(0, 1));
  return event;
}

SceneAction read_changed_behavior(JsonReader& json, const SceneContext&, const Scene&) {
  return BehaviorEvent{.behavior = read_behavior(json.member("behavior"))};
}

SceneAction read_switch(JsonReader& json, const SceneContext&, const Scene& scene) {
  return SwitchEvent{.emitter = read_emitter_name(json, scene), .is_on = json.member("on").boolean()};
}

SceneAction read_changed_rule(JsonReader& json, const SceneContext& context, const Scene& scene) {
  RuleEvent event{.rule = json.member("target").string(), .change = {}};
  event.change =
      read_rule_change(json, event.rule, context.materials, scene.rules, map_names(scene), layer_names(scene));
  return event;
}

SceneAction read_paint(JsonReader& json, const SceneContext& context, const Scene& scene) {
  return PaintEvent{.emitter = read_emitter_name(json, scene),
                    .stops = read_stops(json.member("points"), context.mm_per_unit)};
}

/// Names of "op". Each has its reader at the same place, but for a stroke: it stands for several events.
constexpr std::array<std::string_view, 11> kOpNames{"move",     "turn",   "scale", "emitter", "ratio", "rate",
                                                    "behavior", "switch", "rule",  "paint",   "stroke"};
constexpr int kStroke = 10;
using ReadAction = SceneAction (*)(JsonReader& json, const SceneContext& context, const Scene& scene);
constexpr std::array<ReadAction, 10> kReadActions{
    read_move,   read_turn,         read_scale, read_changed_emitter, read_ratio, read_rate, read_changed_behavior,
    read_switch, read_changed_rule, read_paint};

/// When an event happens, in iterations.
struct EventTimes {
  double first = 0.0;
  std::optional<double> every;
  std::optional<double> length;  ///< Then it is undone.
  std::int64_t count = std::numeric_limits<std::int64_t>::max();

  [[nodiscard]] static std::int64_t iteration_at(double time) {
    return static_cast<std::int64_t>(std::floor(time + 0.5));
  }
};

/// A time of a scene in iterations.
double read_iterations(const JsonReader& json, const SceneContext& context) {
  const double time = read_time_value(json, context.time_unit);
  if (!(context.time_per_iteration > 0.0))
    json.fail("no time: the scene's iterations take none (\"time\": {\"per_iteration\": 0.1})");
  if (time / context.time_per_iteration > kMostIterations)
    json.fail("a time of at most " + short_number_text(kMostIterations) + " iterations");
  return time / context.time_per_iteration;
}

/// "iteration" or "at", and "every", "for", "until".
EventTimes read_event_times(JsonReader& json, const SceneContext& context, bool may_end) {
  EventTimes times;
  const bool has_at = json.has("at"), has_every = json.has("every");
  if (has_at && json.has("iteration")) json.fail("\"iteration\" or \"at\", not both");
  if (has_at) {
    times.first = read_iterations(json.member("at"), context);
  } else if (!has_every || json.has("iteration")) {
    times.first = static_cast<double>(json.member("iteration").integer(at_least(0)));
  }
  if (has_every) {
    times.every = read_iterations(json.member("every"), context);
    if (!(*times.every >= 1.0)) json.member("every").fail("at least the time of one iteration");
  }
  if (json.has("for")) {
    const JsonReader length = json.member("for");
    if (!may_end) length.fail("no such member: only a switch ends by itself; give another event for the end");
    times.length = read_iterations(length, context);
    if (!(*times.length >= 1.0)) length.fail("at least the time of one iteration");
    if (times.every && !(*times.length < *times.every)) length.fail("less than \"every\"");
  }
  if (json.has("until")) {
    const double end = read_iterations(json.member("until"), context);
    if (!times.every) json.member("until").fail("an event with \"every\"");
    if (!(end > times.first)) json.member("until").fail("a time after the first");
    times.count = static_cast<std::int64_t>(std::ceil((end - times.first) / *times.every));
  }
  return times;
}

/// An event with all of its repetitions. @returns what it is.
SceneAction read_event(JsonReader json, const SceneContext& context, Scene& scene, std::int64_t& first) {
  const auto op = static_cast<std::size_t>(json.member("op").choice(kOpNames));
  const EventTimes times = read_event_times(json, context, kReadActions[op] == read_switch);
  SceneAction what = kReadActions[op](json, context, scene);
  json.finish();
  first = EventTimes::iteration_at(times.first);
  std::optional<SceneAction> undo;
  if (times.length) {
    SwitchEvent back = std::get<SwitchEvent>(what);
    back.is_on = !back.is_on;
    undo = back;
  }
  if (times.every) {
    if (undo) {
      scene.series.push_back(
          {.first = times.first + *times.length, .every = *times.every, .count = times.count, .what = *undo});
    }
    scene.series.push_back({.first = times.first, .every = *times.every, .count = times.count, .what = what});
  } else {
    scene.events.push_back({first, what});
    if (undo) scene.events.push_back({EventTimes::iteration_at(times.first + *times.length), *undo});
  }
  return what;
}

/// A rule event and where it stands.
struct PlacedChange {
  JsonReader place;
  std::int64_t iteration;
  RuleEvent event;
};

/// A rule that an event changes is one of the scene's, or an event at that time or before has begun it.
void check_changed_rules(const std::vector<PlacedChange>& changes, const Scene& scene) {
  std::vector<std::string> names = names_of(scene.rules);
  for (const PlacedChange& c : changes) {
    if (c.event.change.begins) names.push_back(c.event.rule);
  }
  for (const PlacedChange& c : changes) {
    const std::string& rule = c.event.rule;
    const bool is_there =
        std::any_of(scene.rules.begin(), scene.rules.end(), [&](const Rule& r) { return r.name == rule; }) ||
        std::any_of(changes.begin(), changes.end(), [&](const PlacedChange& other) {
          return other.event.change.begins && other.event.rule == rule && other.iteration <= c.iteration;
        });
    if (!is_there)
      JsonReader(c.place).member("target").fail(
          "the name of a rule of the scene, a built-in one, or a new one with \"driver\" and \"products\" or "
          "\"reactants\"" +
          did_you_mean(rule, names));
  }
}

}  // namespace

void read_events(const JsonReader& json, const SceneContext& context, Scene& scene) {
  std::vector<PlacedChange> rule_changes;
  for (const JsonReader& element : json.elements(1'000'000)) {
    if (JsonReader(element).member("op").choice(kOpNames) == kStroke) {
      read_stroke(element, context, scene, scene.events);
      continue;
    }
    std::int64_t first = 0;
    const SceneAction what = read_event(element, context, scene, first);
    if (const auto* change = std::get_if<RuleEvent>(&what)) rule_changes.push_back({element, first, *change});
  }
  check_changed_rules(rule_changes, scene);
  for (const PlacedChange& c : rule_changes) {
    if (c.event.change.begins) check_signals(c.place, *c.event.change.begins, context, scene);
    Rule changed{.name = c.event.rule, .driver = c.event.change.driver.value_or("0")};
    changed.where = c.event.change.where.value_or("");
    check_signals(c.place, changed, context, scene);
  }
  std::stable_sort(scene.events.begin(), scene.events.end(),
                   [](const SceneEvent& a, const SceneEvent& b) { return a.iteration < b.iteration; });
}

}  // namespace patinate::simulation
