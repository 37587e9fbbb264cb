#include "simulation/files/scene_json.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/files/scene_lengths.h"
#include "simulation/files/weather_json.h"
#include "simulation/rules/rule_io.h"
#include "simulation/rules/rules.h"
#include "simulation/rules/scene_maps.h"

namespace patinate::simulation {

namespace {

Vec3 read_vector(const JsonReader& json) {
  const std::vector<double> v = json.numbers(3);
  return {v[0], v[1], v[2]};
}

Vec3 read_direction(const JsonReader& json) {
  const Vec3 v = read_vector(json);
  if (!(v.norm() > 0.0 && std::isfinite(v.norm()))) json.fail("a direction, not [0, 0, 0] and not beyond all numbers");
  return v.normalized();
}

constexpr std::int64_t kLongestStroke = 1'000'000;
constexpr std::size_t kMostPoints = 100'000;
constexpr double kMostIterations = 1e12;

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

/// The same of an object.
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
  for (const JsonReader& point : json.member("points").elements(kMostPoints))
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
  for (const JsonReader& point : json.elements(kMostPoints)) {
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

SceneAction read_turn(JsonReader& json, const SceneContext&, const Scene& scene) {
  return TurnEvent{.object = read_object_name(json, scene), .rotate_deg = read_vector(json.member("rotate"))};
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
  event.change = read_rule_change(json, event.rule, context.materials, scene.rules, map_names(scene));
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

int material_index(const JsonReader& json, const std::string& name, const std::vector<std::string>& materials) {
  const auto found = std::find(materials.begin(), materials.end(), name);
  if (found != materials.end()) return static_cast<int>(found - materials.begin());
  std::string list;
  for (const std::string& m : materials) list += (list.empty() ? "" : ", ") + m;
  json.fail("one of the scene's materials (" + list + ")" + did_you_mean(name, materials));
}

MaterialValues read_material_values(JsonReader json, const std::vector<std::string>& materials, const Range& range) {
  MaterialValues values{};
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (json.has(materials[i])) values[i] = json.member(materials[i]).number(range);
  }
  json.finish();
  return values;
}

namespace {

/// A signal that gammatons can follow.
WeatherSignal read_followed(const JsonReader& json, const SceneContext& context) {
  const auto signal = static_cast<WeatherSignal>(json.choice(kWeatherSignalNames));
  if (signal == WeatherSignal::Temperature) json.fail("rain, humidity, sunshine or wind");
  if (!context.weather[static_cast<std::size_t>(signal)])
    json.fail("what the scene's weather tells of; it says nothing of the " + json.string());
  return signal;
}

}  // namespace

Emitter read_emitter(JsonReader json, const SceneContext& context) {
  Emitter e;
  e.name = json.member("name").string();
  e.shape = static_cast<EmitterShape>(json.member("shape").choice(kEmitterShapeNames));
  if (e.shape != EmitterShape::Sky)
    e.position_mm = read_position(json.member("position"), context.mm_per_unit);
  else if (json.has("position"))
    json.member("position").fail("nothing: a sky has no position");
  if (json.has("direction")) e.direction = read_direction(json.member("direction"));
  if (json.has("size")) {
    const JsonReader size = json.member("size");
    if (size.is_number())
      e.size_mm = {size.number(up_to_farthest(context.mm_per_unit)) * context.mm_per_unit, 0.0};
    else {
      const std::vector<double> two = size.numbers(2, up_to_farthest(context.mm_per_unit));
      e.size_mm = {two[0] * context.mm_per_unit, two[1] * context.mm_per_unit};
    }
  }
  if (json.has("spread_deg")) e.spread_deg = json.member("spread_deg").number(between(0, 180));
  if (json.has("speed"))
    e.speed_mm_s = json.member("speed").number(above_0_up_to_farthest(context.mm_per_unit)) * context.mm_per_unit;
  if (json.has("distance"))
    e.distance_mm = json.member("distance").number(above_0_up_to_farthest(context.mm_per_unit)) * context.mm_per_unit;
  if (json.has("gammatons")) e.gammatons = json.member("gammatons").integer(between(1, 1e7));
  if (json.has("carries")) e.carries = read_material_values(json.member("carries"), context.materials, between(0, 16));
  if (json.has("on")) e.is_on = json.member("on").boolean();
  if (json.has("follows")) e.follows = read_followed(json.member("follows"), context);
  if (json.has("full_at")) {
    e.full_at = json.member("full_at").number(above(0));
    if (!e.follows) json.member("full_at").fail("\"follows\" beside it: what of the weather the emitter follows");
  }
  json.finish();
  return e;
}

Behavior read_behavior(JsonReader json) {
  Behavior b;
  if (json.has("slider")) {
    const double absorb = json.has("absorb") ? json.member("absorb").number(between(0, 1)) : Behavior{}.absorb;
    b = behavior_of_slider(json.member("slider").number(between(0, 1)), absorb);
  } else {
    const auto set = [&](const char* name, double& value) {
      if (json.has(name)) value = json.member(name).number(between(0, 1));
    };
    set("bounce", b.bounce);
    set("float", b.floating);
    b.absorb = 1.0 - b.bounce - b.floating;
    set("absorb", b.absorb);
    set("deceleration_bounce", b.deceleration_bounce);
    set("deceleration_float", b.deceleration_float);
    if (!(std::abs(b.bounce + b.floating + b.absorb - 1.0) < 1e-6)) json.fail("bounce, float and absorb that sum to 1");
    b.absorb = std::max(0.0, 1.0 - b.bounce - b.floating);
  }
  json.finish();
  return b;
}

TracingOptions read_tracing(JsonReader json, const SceneContext& context, TracingOptions t) {
  const auto length = [&](const char* name, double& mm, const Range& range) {
    if (json.has(name)) mm = json.member(name).number(range) * context.mm_per_unit;
  };
  const auto number = [&](const char* name, double& value, const Range& range) {
    if (json.has(name)) value = json.member(name).number(range);
  };
  const double share = t.epsilon_mm / t.reach_mm;
  length("reach", t.reach_mm, above(0));
  t.epsilon_mm = share * t.reach_mm;
  length("epsilon", t.epsilon_mm, above(0));
  double pull_mm = t.pull * t.reach_mm;
  length("pull", pull_mm, at_least(0));
  t.pull = pull_mm / t.reach_mm;
  number("lobe_exponent_bounce", t.lobe_exponent_bounce, between(0, 1e6));
  number("lobe_exponent_float", t.lobe_exponent_float, between(0, 1e6));
  if (json.has("max_segments")) t.max_segments = static_cast<int>(json.member("max_segments").integer(between(1, 64)));
  if (json.has("tangential_slowdown")) t.tangential_slowdown = json.member("tangential_slowdown").boolean();
  length("rest_speed", t.rest_speed_mm_s, at_least(0));
  number("rest_slope_deg", t.rest_slope_deg, between(0, 90));
  if (json.has("bounce_normal"))
    t.bounce_normal = static_cast<BounceNormal>(json.member("bounce_normal").choice(kBounceNormalNames));
  number("wet_attraction", t.wet_attraction, between(0, 1));
  number("rivulet_mm", t.rivulet_mm, above(0));
  if (json.has("wet_material")) {
    t.wet_material = json.member("wet_material").string();
    (void)material_index(json.member("wet_material"), t.wet_material, context.materials);
  }
  json.finish();
  return t;
}

ExchangeOptions read_exchange(JsonReader json, const SceneContext& context, ExchangeOptions e) {
  if (json.has("ratio")) e.ratio = json.member("ratio").number(between(0, 1));
  if (json.has("rates")) e.rates = read_material_values(json.member("rates"), context.materials, between(0, 1));
  if (json.has("splat")) {
    if (json.has("splat_mm")) json.member("splat_mm").fail("no splat in texels beside it");
    e.splat_texels = static_cast<int>(json.member("splat").integer(between(1, 5)));
    e.splat_mm = 0.0;
  }
  if (json.has("splat_mm")) e.splat_mm = json.member("splat_mm").number(above(0));
  if (json.has("deposit")) e.deposit = json.member("deposit").boolean();
  json.finish();
  return e;
}

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

void check_signals(const JsonReader& json, const Rule& rule, const SceneContext& context, const Scene& scene) {
  for (const std::string& name : signals_of(rule, scene.materials, map_names(scene))) {
    const std::optional<WeatherSignal> signal = weather_signal_of(name);
    if (signal && !context.weather[static_cast<std::size_t>(*signal)]) {
      throw IoError(json.file(), json.pointer() + ": rule '" + rule.name + "' asks for `" + name +
                                     "`, of which the scene's weather says nothing");
    }
  }
}

}  // namespace patinate::simulation
