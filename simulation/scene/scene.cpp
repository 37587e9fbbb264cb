#include "patinate/simulation/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::simulation {

namespace {

constexpr double kFarthest =
    1e9;  // mm: a thousand kilometers; beyond, floats and products of lengths lose their meaning

void check(bool is_right, const std::string& what, double found, const std::string& range) {
  if (!is_right) throw InvalidInput(what + " is " + number_text(found) + "; use " + range);
}

void check_range(const std::string& what, double value, double low, double high) {
  check(value >= low && value <= high, what, value, "[" + number_text(low) + ", " + number_text(high) + "]");
}

void check_positive(const std::string& what, double value) {
  check(value > 0.0 && std::isfinite(value), what, value, "more than 0");
}

void check_finite(const std::string& what, const Vec3& value) {
  if (!value.allFinite()) throw InvalidInput(what + " is not finite");
}

template <class Items>
void check_names(const Items& items, const std::string& kind) {
  std::set<std::string> names;
  for (const auto& item : items) {
    if (item.name.empty()) throw InvalidInput("an " + kind + " has no name");
    if (!names.insert(item.name).second)
      throw InvalidInput("two " + kind + "s are called '" + item.name + "'; names are unique");
  }
}

void check_materials(const Scene& scene) {
  const std::size_t n = scene.materials.size();
  if (n < 1 || n > kMaxMaterials) {
    throw InvalidInput("the scene has " + std::to_string(n) + " materials; use 1 to " + std::to_string(kMaxMaterials));
  }
  if (std::set<std::string>(scene.materials.begin(), scene.materials.end()).size() != n)
    throw InvalidInput("two materials have one name");
  if (scene.appearance.size() != n) throw InvalidInput("there is not one appearance for each material");
  for (std::size_t i = 0; i < n; ++i) {
    const MaterialAppearance& look = scene.appearance[i];
    const std::string of = " of material '" + scene.materials[i] + "'";
    check_range("the strength" + of, look.strength, 0.0, 1000.0);
    check_range("the variation" + of, look.variation, 0.0, 1.0);
    check_range("the specular change" + of, look.specular, -1.0, 1.0);
    check_range("the specular variation" + of, look.specular_variation, 0.0, 1.0);
    check_range("the height" + of, look.height_mm, -1e6, 1e6);
    check_range("the height variation" + of, look.height_variation, 0.0, 1.0);
    check_range("the grain" + of, look.grain_mm, 0.0, 1e9);
  }
}

void check_emitter(const Emitter& emitter, const Scene& scene) {
  const std::string of = " of emitter '" + emitter.name + "'";
  for (const double x : emitter.position_mm) check_range("the position (mm)" + of, x, -kFarthest, kFarthest);
  check_finite("the direction" + of, emitter.direction);
  check(std::abs(emitter.direction.norm() - 1.0) < 1e-6, "the length of the direction" + of, emitter.direction.norm(),
        "a direction that is not 0");
  for (const double size : emitter.size_mm) check_range("the size" + of, size, 0.0, 1e9);
  check_range("the spread" + of, emitter.spread_deg, 0.0, 180.0);
  check_range("the speed (mm/s)" + of, emitter.speed_mm_s, 1e-9, kFarthest);
  check_range("the distance (mm)" + of, emitter.distance_mm, 1e-9, kFarthest);
  check_range("the number of gammatons" + of, static_cast<double>(emitter.gammatons), 1, 1e7);
  check_range("full_at" + of, emitter.full_at, 0.0, 1e9);
  if (emitter.follows) {
    const auto signal = static_cast<std::size_t>(*emitter.follows);
    if (*emitter.follows == WeatherSignal::Temperature)
      throw InvalidInput("what follows the temperature" + of + ": use rain, humidity, sunshine or wind");
    if (!scene.weather.is_given[signal])
      throw InvalidInput("the emitter '" + emitter.name + "' follows the " + std::string(kWeatherSignalNames[signal]) +
                         ", of which the scene's weather says nothing");
  }
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    check_range("what it carries of '" + scene.materials[i] + "'," + of, emitter.carries[i], 0.0, 16.0);
  }
}

void check_objects(const Scene& scene) {
  if (scene.objects.empty()) throw InvalidInput("the scene has no objects");
  check_names(scene.objects, "object");
  for (const SceneObject& object : scene.objects) {
    const std::string of = " of object '" + object.name + "'";
    check_range("the scale" + of, object.scale, 1e-9, 1e9);
    if (object.texels_per_mm) check_range("the texels a mm" + of, *object.texels_per_mm, 1e-9, 1e9);
    check_range("the crease" + of, object.crease_deg, 0.0, 180.0);
    // From the coordinates of a map or of the earth to the origin.
    for (const double x : object.translate_mm) check_range("the place (mm)" + of, x, -100 * kFarthest, 100 * kFarthest);
    for (const double x : object.rotate_deg) check_range("the rotation" + of, x, -1e6, 1e6);
    check_range("the specular value" + of, object.preset.specular, 0.0, 1.0);
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
      check_range("the amount of '" + scene.materials[i] + "'" + of, object.preset.amounts[i], 0.0, kMostAmount);
    }
  }
}

/// Names that a layer takes from materials and maps, since drivers mean it by them.
constexpr std::array<std::string_view, 6> kNamesOfLayers{"thickness", "depth", "adhesion", "edge", "stress", "crack"};

void check_tension(const std::string& what, const CrackTension& tension) {
  constexpr double kRounding = 1e-6;
  check_range("the ratio of " + what, tension.ratio, 0.1, 10.0);
  if (tension.along)
    check_range("the length of the direction of " + what, tension.along->norm(), 1.0 - kRounding, 1.0 + kRounding);
}

void check_layers(const Scene& scene) {
  for (const SceneObject& object : scene.objects) {
    const std::string of = " of object '" + object.name + "'";
    if (object.layers.size() > kMaxLayers)
      throw InvalidInput("the number of layers" + of + " is " + std::to_string(object.layers.size()) +
                         "; use at most " + std::to_string(kMaxLayers) + ", the substrate included");
    std::set<std::string> names;
    for (const Layer& layer : object.layers) {
      if (!is_map_name(layer.name))
        throw InvalidInput("a layer" + of + " is called '" + layer.name +
                           "'; use letters, digits and _, no digit first");
      if (!names.insert(layer.name).second)
        throw InvalidInput("two layers" + of + " are called '" + layer.name + "'; names are unique");
      for (const double amount : layer.look.amounts)
        check_range("an amount of layer '" + layer.name + "'" + of, amount, 0.0, kMostAmount);
      if (!layer.cracks) continue;
      check_range("the relief of layer '" + layer.name + "'" + of, layer.cracks->relief, 0.1, 1000.0);
      check_range("the shrinkage of layer '" + layer.name + "'" + of, layer.cracks->shrinkage, 0.0, 0.5);
      if (layer.cracks->tension)
        check_tension("the tension of layer '" + layer.name + "'" + of, *layer.cracks->tension);
    }
  }
  if (!has_layers(scene)) return;
  for (const std::string_view name : kNamesOfLayers) {
    const bool is_map =
        std::any_of(scene.maps.begin(), scene.maps.end(), [&](const auto& m) { return m.name == name; });
    if (is_map || std::find(scene.materials.begin(), scene.materials.end(), name) != scene.materials.end())
      throw InvalidInput("a " + std::string(is_map ? "map" : "material") + " is called '" + std::string(name) +
                         "', which in drivers of a scene with layers is theirs");
  }
}

void check_shares(const Rule& rule) {
  const std::string of = " of rule '" + rule.name + "'";
  for (const LayerShares* shares : {&rule.layer_products, &rule.layer_reactants}) {
    for (const double share : shares->at_interface) check_range("what lies at an interface" + of, share, 0.0, 1e3);
    check_range("the thickness" + of, shares->thickness_um, 0.0, 1e3);
    check_range("the adhesion" + of, shares->adhesion, 0.0, 1e3);
    check_range("the stress" + of, shares->stress, 0.0, 1e3);
  }
  if (rule.layer_products.thickness_um > 0.0 || rule.layer_products.adhesion > 0.0)
    throw InvalidInput("products" + of + ": a layer's thickness and adhesion only fall; name them in reactants");
}

void check_maps(const Scene& scene) {
  check_names(scene.maps, "map");
  const std::vector<std::string>& kinds = scene_map_kinds();
  for (const SceneMap& map : scene.maps) {
    if (!is_map_name(map.name))
      throw InvalidInput("a map is called '" + map.name + "'; use letters, digits and _, no digit first");
    if (std::find(scene.materials.begin(), scene.materials.end(), map.name) != scene.materials.end())
      throw InvalidInput("a map is called '" + map.name + "' as a material is, which would hide it");
    if (std::find(kinds.begin(), kinds.end(), map.kind) == kinds.end())
      throw InvalidInput("map '" + map.name + "' is of no kind that there is: '" + map.kind + "'");
    check_ranges(map.noise);
  }
}

void check_behavior(const Behavior& b) {
  for (const double p : {b.bounce, b.floating, b.absorb}) check_range("a probability of the behavior", p, 0.0, 1.0);
  check(std::abs(b.bounce + b.floating + b.absorb - 1.0) < 1e-9, "bounce + float + absorb",
        b.bounce + b.floating + b.absorb, "1");
  check_range("deceleration_bounce", b.deceleration_bounce, 0.0, 1.0);
  check_range("deceleration_float", b.deceleration_float, 0.0, 1.0);
}

void check_tracing(const TracingOptions& t) {
  check_positive("epsilon", t.epsilon_mm);
  check_positive("reach", t.reach_mm);
  check_range("pull", t.pull, 0.0, 1e6);
  check_range("lobe_exponent_bounce", t.lobe_exponent_bounce, 0.0, 1e6);
  check_range("lobe_exponent_float", t.lobe_exponent_float, 0.0, 1e6);
  check_range("max_segments", t.max_segments, 1, 64);
  check_range("rest_speed", t.rest_speed_mm_s, 0.0, 1e9);
  check_range("rest_slope", t.rest_slope_deg, 0.0, 90.0);
  check_range("wet_attraction", t.wet_attraction, 0.0, 1.0);
  if (t.wet_attraction > 0.0) check_positive("rivulet_mm", t.rivulet_mm);
}

}  // namespace

Behavior behavior_of_slider(double s, double absorb) {
  check_range("the slider", s, 0.0, 1.0);
  check_range("absorb", absorb, 0.0, 1.0);
  const double alive = 1.0 - absorb;
  const double floats = std::clamp(3.0 * s - 1.0, 0.0, 1.0);
  // A tenth of the speed stays, so that a bounce leaves the surface while floating takes over. The source gives no
  // value.
  constexpr double kMaxBounceLoss = 0.9;
  return {.bounce = alive - alive * floats,
          .floating = alive * floats,
          .absorb = absorb,
          .deceleration_bounce = kMaxBounceLoss * std::clamp(3.0 * s, 0.0, 1.0),
          .deceleration_float = std::clamp(3.0 * s - 2.0, 0.0, 1.0)};
}

bool EventSeries::is_due(std::int64_t iteration) const {
  // The division may be off by one step; what counts is where each step lies.
  const auto guess = static_cast<std::int64_t>(std::floor((static_cast<double>(iteration) - first) / every));
  for (std::int64_t k = std::max<std::int64_t>(0, guess - 1); k <= guess + 1 && k < count; ++k) {
    if (std::floor(first + static_cast<double>(k) * every + 0.5) == static_cast<double>(iteration)) return true;
  }
  return false;
}

void check_scene(const Scene& scene) {
  check_materials(scene);
  check_objects(scene);
  check_layers(scene);
  if (scene.emitters.empty()) throw InvalidInput("the scene has no emitters: nothing would happen");
  check_names(scene.emitters, "emitter");
  for (const Emitter& emitter : scene.emitters) check_emitter(emitter, scene);
  check_maps(scene);
  check_weather(scene.weather);
  check_behavior(scene.behavior);
  check_tracing(scene.tracing);
  check_range("the exchange ratio", scene.exchange.ratio, 0.0, 1.0);
  check_range("contact", scene.exchange.contact, 0.0, 1e6);
  for (const double rate : scene.exchange.rates) check_range("an exchange rate", rate, 0.0, 1.0);
  if (scene.exchange.splat_texels != 1 && scene.exchange.splat_texels != 3 && scene.exchange.splat_texels != 5) {
    throw InvalidInput("splat is " + std::to_string(scene.exchange.splat_texels) + "; use 1, 3 or 5 texels");
  }
  check_range("splat_mm", scene.exchange.splat_mm, 0.0, 1e6);
  for (const Rule& rule : scene.rules) {
    check_range("rate of rule '" + rule.name + "'", rule.rate, 0.0, 1e6);
    for (const double share : rule.products) check_range("products of rule '" + rule.name + "'", share, 0.0, 1e3);
    for (const double share : rule.reactants) check_range("reactants of rule '" + rule.name + "'", share, 0.0, 1e3);
    check_shares(rule);
    if ((rule.layer_products.stress > 0.0 || rule.layer_reactants.stress > 0.0) && !has_cracks(scene))
      throw InvalidInput("rule '" + rule.name + "' changes the stress of a layer, and no layer has \"cracks\"");
  }
  for (const EventSeries& series : scene.series) {
    check_range("the beginning of a series of events", series.first, 0.0, 1e12);
    check_range("the step of a series of events", series.every, 1.0, 1e12);
  }
  check_finite("gravity", scene.gravity_mm_s2);
  check_range("the atlas's resolution", scene.resolution, 16, 16384);
  check_range("per_iteration", scene.time_per_iteration, 0.0, 1e9);
  if (!scene.weather.empty() && !(scene.time_per_iteration > 0.0))
    throw InvalidInput(
        "the scene has weather, and its iterations take no time; give them one (\"time\": {\"per_iteration\": 0.1})");
}

bool LayerShares::has_any() const {
  return thickness_um > 0.0 || adhesion > 0.0 || stress > 0.0 ||
         std::any_of(at_interface.begin(), at_interface.end(), [](double share) { return share > 0.0; });
}

std::vector<std::string> layer_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneObject& object : scene.objects) {
    for (std::size_t l = 1; l < object.layers.size(); ++l) {
      if (std::find(names.begin(), names.end(), object.layers[l].name) == names.end())
        names.push_back(object.layers[l].name);
    }
  }
  return names;
}

bool has_layers(const Scene& scene) { return !layer_names(scene).empty(); }

bool has_cracks(const Scene& scene) {
  return std::any_of(scene.objects.begin(), scene.objects.end(), [](const SceneObject& object) {
    return std::any_of(object.layers.begin(), object.layers.end(), [](const Layer& l) { return l.cracks.has_value(); });
  });
}

std::vector<std::string> parameter_map_names(const std::vector<std::string>& materials) {
  std::vector<std::string> names{"hits", "last_hit", "residence"};
  for (const std::string& m : materials) {
    names.push_back(m + ".deposited");
    names.push_back(m + ".final");
  }
  return names;
}

}  // namespace patinate::simulation
