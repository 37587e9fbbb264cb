#include "simulation/files/scene_json.h"

#include <algorithm>
#include <cmath>
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

Vec3 read_direction(const JsonReader& json) {
  const std::vector<double> numbers = json.numbers(3);
  const Vec3 v(numbers[0], numbers[1], numbers[2]);
  if (!(v.norm() > 0.0 && std::isfinite(v.norm()))) json.fail("a direction, not [0, 0, 0] and not beyond all numbers");
  return v.normalized();
}

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

void check_signals(const JsonReader& json, const Rule& rule, const SceneContext& context, const Scene& scene) {
  for (const std::string& name : signals_of(rule, scene.materials, map_names(scene), layer_names(scene))) {
    const std::optional<WeatherSignal> signal = weather_signal_of(name);
    if (signal && !context.weather[static_cast<std::size_t>(*signal)]) {
      throw IoError(json.file(), json.pointer() + ": rule '" + rule.name + "' asks for `" + name +
                                     "`, of which the scene's weather says nothing");
    }
  }
}

}  // namespace patinate::simulation
