#include "tools/studio/scene_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "patinate/core/error.h"
#include "simulation/files/scene_json.h"
#include "simulation/rules/rule_io.h"

namespace patinate::studio {

namespace {

Json array_of(const Vec3& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json amounts_json(const simulation::MaterialValues& values, const std::vector<std::string>& materials) {
  Json json = Json::object();
  for (std::size_t i = 0; i < materials.size(); ++i) json[materials[i]] = values[i];
  return json;
}

/// Divides lengths: a number, or numbers in an array.
void to_unit(Json& object, const char* key, double mm_per_unit) {
  if (!object.contains(key)) return;
  Json& value = object[key];
  if (value.is_number()) value = value.get<double>() / mm_per_unit;
  if (!value.is_array()) return;
  for (Json& element : value) {
    if (element.is_number()) element = element.get<double>() / mm_per_unit;
  }
}

void emitter_to_unit(Json& emitter, double mm_per_unit) {
  for (const char* key : {"position", "size", "speed", "distance"}) to_unit(emitter, key, mm_per_unit);
}

Json emitter_json(const simulation::Emitter& e, const std::vector<std::string>& materials) {
  Json json{{"name", e.name}, {"shape", simulation::kEmitterShapeNames[static_cast<std::size_t>(e.shape)]}};
  if (e.shape != simulation::EmitterShape::Sky) json["position"] = array_of(e.position_mm);
  json["direction"] = array_of(e.direction);
  json["size"] = e.size_mm;
  json["spread_deg"] = e.spread_deg;
  json["speed"] = e.speed_mm_s;
  json["distance"] = e.distance_mm;
  json["gammatons"] = e.gammatons;
  json["carries"] = amounts_json(e.carries, materials);
  json["on"] = e.is_on;
  if (e.follows) json["follows"] = simulation::kWeatherSignalNames[static_cast<std::size_t>(*e.follows)];
  if (e.full_at > 0.0) json["full_at"] = e.full_at;
  return json;
}

/// In one line, with a blank behind every comma and colon.
std::string line_text(const Json& json) {
  if (!json.is_structured()) return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string text;
  for (const auto& [key, value] : json.items()) {
    text += (text.empty() ? "" : ", ") + (json.is_object() ? line_text(Json(key)) + ": " : "") + line_text(value);
  }
  return json.is_object() ? "{" + text + "}" : "[" + text + "]";
}

/// @param num_before  Characters of the line so far, behind the indent.
void write_readable(const Json& json, const std::string& indent, std::size_t num_before, std::string& text) {
  constexpr std::size_t kLineLength = 110;
  const std::string line = line_text(json);
  const bool is_top = indent.empty(), fits = indent.size() + num_before + line.size() <= kLineLength;
  if (!json.is_structured() || json.empty() || (fits && !is_top)) {
    text += line;
    return;
  }
  const std::string inner = indent + "  ";
  text += json.is_array() ? "[" : "{";
  std::string end = "\n";
  for (const auto& [key, value] : json.items()) {
    const std::string name = json.is_object() ? line_text(Json(key)) + ": " : "";
    text += std::exchange(end, ",\n") + inner + name;
    write_readable(value, inner, name.size(), text);
  }
  text += "\n" + indent + (json.is_array() ? "]" : "}");
}

}  // namespace

std::string readable_text(const Json& json) {
  std::string text;
  write_readable(json, "", 0, text);
  return text + "\n";
}

Json emitters_json(const simulation::Scene& scene) {
  Json list = Json::array();
  for (const simulation::Emitter& e : scene.emitters) list.push_back(emitter_json(e, scene.materials));
  return list;
}

Json objects_json(const simulation::Scene& scene) {
  Json list = Json::array();
  for (const simulation::SceneObject& o : scene.objects) {
    list.push_back({{"name", o.name},
                    {"translate", array_of(o.translate_mm)},
                    {"rotate", array_of(o.rotate_deg)},
                    {"scale", o.scale}});
  }
  return list;
}

Json appearance_json(const simulation::Scene& scene, std::span<const simulation::MaterialAppearance> looks) {
  Json json = Json::object();
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const simulation::MaterialAppearance& l = looks[i];
    json[scene.materials[i]] = {
        {"strength", l.strength},
        {"variation", l.variation},
        {"specular", l.specular},
        {"specular_variation", l.specular_variation},
        {"height", l.height_mm},
        {"height_variation", l.height_variation},
        // A picture, or colors by amount.
        {"color", l.color.image.empty() && l.colors.empty() ? array_of(l.color.color) : Json(nullptr)}};
  }
  return json;
}

Json behavior_json(const simulation::Behavior& b) {
  return {{"bounce", b.bounce},
          {"float", b.floating},
          {"absorb", b.absorb},
          {"deceleration_bounce", b.deceleration_bounce},
          {"deceleration_float", b.deceleration_float}};
}

Json exchange_json(const simulation::Scene& scene) {
  return {{"ratio", scene.exchange.ratio}, {"rates", amounts_json(scene.exchange.rates, scene.materials)}};
}

Json rules_json(const simulation::Scene& scene) {
  Json list = Json::array();
  const auto shares = [&](const simulation::MaterialValues& values, const simulation::LayerShares& of_layers) {
    Json json = Json::object();
    for (const auto& [name, share] : simulation::named_shares(values, of_layers, scene.materials)) json[name] = share;
    return json;
  };
  for (const simulation::Rule& rule : scene.rules) {
    list.push_back({{"name", rule.name},
                    {"driver", rule.driver},
                    {"rate", rule.rate},
                    {"products", shares(rule.products, rule.layer_products)},
                    {"reactants", shares(rule.reactants, rule.layer_reactants)}});
  }
  return list;
}

Json more_rules_json(const simulation::Scene& scene, std::span<const simulation::RuleAsset> fitting) {
  Json list = Json::array();
  for (const simulation::RuleAsset& asset : fitting) {
    const bool is_there = std::any_of(scene.rules.begin(), scene.rules.end(),
                                      [&](const simulation::Rule& rule) { return rule.name == asset.name; });
    if (!is_there) list.push_back({{"name", asset.name}, {"about", asset.about}});
  }
  return list;
}

Json emitter_of_file(const simulation::Emitter& emitter, const std::vector<std::string>& materials,
                     double mm_per_unit) {
  Json json = emitter_json(emitter, materials);
  emitter_to_unit(json, mm_per_unit);
  return json;
}

Json event_of_file(const Json& event, double mm_per_unit, std::int64_t iteration) {
  if (!event.is_object()) throw InvalidInput("/event: found no object; expected an event as scene files have them");
  if (event.contains("iteration")) throw InvalidInput("/event/iteration: an event happens now; leave it out");
  Json json{{"iteration", iteration}};
  json.update(event);
  to_unit(json, "position", mm_per_unit);
  if (json.contains("emitter") && json["emitter"].is_object()) emitter_to_unit(json["emitter"], mm_per_unit);
  return json;
}

}  // namespace patinate::studio
