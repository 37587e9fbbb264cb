#include "simulation/files/scene_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "simulation/rules/rule_io.h"

namespace patinate::simulation {

namespace {

Vec3 read_vector(const JsonReader& json) {
  const std::vector<double> v = json.numbers(3);
  return {v[0], v[1], v[2]};
}

Vec3 read_direction(const JsonReader& json) {
  const Vec3 v = read_vector(json);
  if (!(v.norm() > 0.0)) json.fail("a direction, not [0, 0, 0]");
  return v.normalized();
}

/// In the order of SceneEvent::Op; a stroke stands for several events.
constexpr std::array<std::string_view, 11> kOpNames{"move",     "turn",   "scale", "emitter", "ratio", "rate",
                                                    "behavior", "switch", "rule",  "paint",   "stroke"};
constexpr int kStroke = 10;
constexpr std::int64_t kLongestStroke = 1'000'000;
constexpr std::size_t kMostPoints = 100'000;

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

/// A brush's way: on at the first point, one point every `every` iterations and even steps between them, off after the
/// last.
void read_stroke(JsonReader json, const SceneContext& context, const Scene& scene, std::vector<SceneEvent>& events) {
  SceneEvent event;
  event.iteration = json.member("iteration").integer(at_least(0));
  (void)json.member("op");
  event.target = json.member("target").string();
  check_target(json.member("target"), event.target, names_of(scene.emitters), "an emitter");
  const std::int64_t every = json.has("every") ? json.member("every").integer(between(1, 1e6)) : 1;
  std::vector<Vec3> points;
  for (const JsonReader& point : json.member("points").elements(kMostPoints))
    points.push_back(read_vector(point) * context.mm_per_unit);
  if (points.empty()) json.member("points").fail("at least one position");
  if (static_cast<std::int64_t>(points.size()) * every > kLongestStroke)
    json.fail("at most " + std::to_string(kLongestStroke) + " iterations");
  json.finish();
  event.op = SceneEvent::Op::Switch;
  event.value = Vec3(1, 0, 0);
  events.push_back(event);
  event.op = SceneEvent::Op::Move;
  const std::int64_t begin = event.iteration, steps = static_cast<std::int64_t>(points.size() - 1) * every;
  for (std::int64_t i = 0; i <= steps; ++i) {
    const auto k = static_cast<std::size_t>(i / every);
    const double share = static_cast<double>(i % every) / static_cast<double>(every);
    event.iteration = begin + i;
    event.value = share == 0.0 ? points[k] : Vec3((1.0 - share) * points[k] + share * points[k + 1]);
    events.push_back(event);
  }
  event.op = SceneEvent::Op::Switch;
  event.iteration = begin + steps + every;
  event.value = Vec3::Zero();
  events.push_back(event);
}

/// Places of a brush that paints alone: [x, y, z], one step, or [x, y, z, steps].
std::vector<BrushStop> read_stops(const JsonReader& json, double mm_per_unit) {
  std::vector<BrushStop> stops;
  std::int64_t num_steps = 0;
  for (const JsonReader& point : json.elements(kMostPoints)) {
    const std::vector<JsonReader> parts = point.elements(4);
    if (parts.size() < 3) point.fail("[x, y, z], or [x, y, z, steps]");
    BrushStop stop{.position_mm = Vec3(parts[0].number(), parts[1].number(), parts[2].number()) * mm_per_unit};
    if (parts.size() > 3) stop.steps = parts[3].integer(between(1, 1e6));
    num_steps += stop.steps;
    stops.push_back(stop);
  }
  if (stops.empty()) json.fail("at least one position");
  if (num_steps > kLongestStroke) json.fail("at most " + std::to_string(kLongestStroke) + " steps together");
  return stops;
}

SceneEvent read_event(JsonReader json, const SceneContext& context, const Scene& scene) {
  using Op = SceneEvent::Op;
  SceneEvent event;
  event.iteration = json.member("iteration").integer(at_least(0));
  event.op = static_cast<Op>(json.member("op").choice(kOpNames));
  std::vector<std::string> movable = names_of(scene.objects);
  const std::vector<std::string> emitters = names_of(scene.emitters);
  if (event.op == Op::Move) movable.insert(movable.end(), emitters.begin(), emitters.end());
  switch (event.op) {
    case Op::Move:
      event.target = json.member("target").string();
      check_target(json.member("target"), event.target, movable, "an object or emitter");
      event.value = read_vector(json.member("position")) * context.mm_per_unit;
      break;
    case Op::Turn:
      event.target = json.member("target").string();
      check_target(json.member("target"), event.target, movable, "an object");
      event.value = read_vector(json.member("rotate"));
      break;
    case Op::Scale:
      event.target = json.member("target").string();
      check_target(json.member("target"), event.target, movable, "an object");
      event.value[0] = json.member("scale").number(above(0));
      break;
    case Op::Emitter:
      event.emitter = read_emitter(json.member("emitter"), context);
      event.target = event.emitter->name;
      check_target(json.member("emitter").member("name"), event.target, emitters,
                   "an emitter of the scene (with gammatons 1 and \"on\": false it can wait for its time)");
      for (const Emitter& e : scene.emitters) {
        if (e.name == event.target && e.gammatons != event.emitter->gammatons) {
          json.member("emitter").fail("the same number of gammatons as before (" + std::to_string(e.gammatons) +
                                      "): the streams of the others would shift");
        }
      }
      break;
    case Op::Switch:
      event.target = json.member("target").string();
      check_target(json.member("target"), event.target, emitters, "an emitter");
      event.value[0] = json.member("on").boolean() ? 1.0 : 0.0;
      break;
    case Op::Ratio:
      event.value[0] = json.member("ratio").number(between(0, 1));
      break;
    case Op::Rate:
      event.target = json.member("target").string();
      (void)material_index(json.member("target"), event.target, context.materials);
      event.value[0] = json.member("rate").number(between(0, 1));
      break;
    case Op::Behavior:
      event.behavior = read_behavior(json.member("behavior"));
      break;
    case Op::Paint:
      event.target = json.member("target").string();
      check_target(json.member("target"), event.target, emitters, "an emitter");
      event.stops = read_stops(json.member("points"), context.mm_per_unit);
      break;
    case Op::Rule:
      event.target = json.member("target").string();
      event.rule = read_rule_change(json, event.target, context.materials, scene.rules);
      break;
  }
  json.finish();
  return event;
}

/// A rule that an event changes is one of the scene's, or an event at that time or before has begun it.
void check_changed_rules(const std::vector<std::pair<JsonReader, SceneEvent>>& changes, const Scene& scene) {
  std::vector<std::string> names = names_of(scene.rules);
  for (const auto& [place, event] : changes) {
    if (event.rule->begins) names.push_back(event.target);
  }
  for (const auto& [place, change] : changes) {
    const auto& event = change;
    const bool is_there = std::any_of(scene.rules.begin(), scene.rules.end(),
                                      [&](const Rule& rule) { return rule.name == event.target; }) ||
                          std::any_of(changes.begin(), changes.end(), [&](const auto& other) {
                            return other.second.rule->begins && other.second.target == event.target &&
                                   other.second.iteration <= event.iteration;
                          });
    if (!is_there)
      JsonReader(place).member("target").fail(
          "the name of a rule of the scene, a built-in one, or a new one with \"driver\" and \"products\" or "
          "\"reactants\"" +
          did_you_mean(event.target, names));
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

Emitter read_emitter(JsonReader json, const SceneContext& context) {
  Emitter e;
  e.name = json.member("name").string();
  e.shape = static_cast<EmitterShape>(json.member("shape").choice(kEmitterShapeNames));
  if (e.shape != EmitterShape::Sky)
    e.position_mm = read_vector(json.member("position")) * context.mm_per_unit;
  else if (json.has("position"))
    json.member("position").fail("nothing: a sky has no position");
  if (json.has("direction")) e.direction = read_direction(json.member("direction"));
  if (json.has("size")) {
    const JsonReader size = json.member("size");
    if (size.is_number())
      e.size_mm = {size.number(at_least(0)) * context.mm_per_unit, 0.0};
    else {
      const std::vector<double> two = size.numbers(2, at_least(0));
      e.size_mm = {two[0] * context.mm_per_unit, two[1] * context.mm_per_unit};
    }
  }
  if (json.has("spread_deg")) e.spread_deg = json.member("spread_deg").number(between(0, 180));
  if (json.has("speed")) e.speed_mm_s = json.member("speed").number(above(0)) * context.mm_per_unit;
  if (json.has("distance")) e.distance_mm = json.member("distance").number(above(0)) * context.mm_per_unit;
  if (json.has("gammatons")) e.gammatons = json.member("gammatons").integer(between(1, 1e7));
  if (json.has("carries")) e.carries = read_material_values(json.member("carries"), context.materials, between(0, 16));
  if (json.has("on")) e.is_on = json.member("on").boolean();
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

TracingOptions read_tracing(JsonReader json, double mm_per_unit, TracingOptions t) {
  const auto length = [&](const char* name, double& mm, const Range& range) {
    if (json.has(name)) mm = json.member(name).number(range) * mm_per_unit;
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
  json.finish();
  return t;
}

ExchangeOptions read_exchange(JsonReader json, const SceneContext& context) {
  ExchangeOptions e;
  if (json.has("ratio")) e.ratio = json.member("ratio").number(between(0, 1));
  if (json.has("rates")) e.rates = read_material_values(json.member("rates"), context.materials, between(0, 1));
  if (json.has("splat")) e.splat_texels = static_cast<int>(json.member("splat").integer(between(1, 5)));
  json.finish();
  return e;
}

std::vector<SceneEvent> read_events(const JsonReader& json, const SceneContext& context, const Scene& scene) {
  std::vector<SceneEvent> events;
  std::vector<std::pair<JsonReader, SceneEvent>> rule_changes;
  for (const JsonReader& element : json.elements(1'000'000)) {
    if (JsonReader(element).member("op").choice(kOpNames) == kStroke) {
      read_stroke(element, context, scene, events);
      continue;
    }
    events.push_back(read_event(element, context, scene));
    if (events.back().op == SceneEvent::Op::Rule) rule_changes.emplace_back(element, events.back());
  }
  check_changed_rules(rule_changes, scene);
  std::stable_sort(events.begin(), events.end(),
                   [](const SceneEvent& a, const SceneEvent& b) { return a.iteration < b.iteration; });
  return events;
}

}  // namespace patinate::simulation
