// What takes a setting back, and what a step is called in the list of steps.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "simulation/files/scene_event.h"
#include "simulation/rules/rule_io.h"
#include "tools/studio/live_client.h"
#include "tools/studio/live_labels.h"
#include "tools/studio/scene_text.h"

namespace patinate::studio {

namespace {

using simulation::Emitter;
using simulation::Scene;

template <class Item>
const Item* item_named(const std::vector<Item>& items, const std::string& name) {
  const auto found = std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  return found == items.end() ? nullptr : &*found;
}

Json vector_json(const Vec3& v, double mm_per_unit) {
  return Json::array({v.x() / mm_per_unit, v.y() / mm_per_unit, v.z() / mm_per_unit});
}

Json event_for(const char* op, const std::string& target, const char* member, Json value) {
  return {{"op", op}, {"target", target}, {member, std::move(value)}};
}

/// All of a rule, as an event sets it.
Json rule_event(const simulation::Rule& rule, const std::vector<std::string>& materials) {
  Json event{{"op", "rule"}, {"target", rule.name}, {"driver", rule.driver}, {"rate", rule.rate}};
  const auto set = [&](const char* key, const simulation::MaterialValues& values,
                       const simulation::LayerShares& of_layers) {
    event[key] = Json::object();
    for (const auto& [name, share] : simulation::named_shares(values, of_layers, materials)) event[key][name] = share;
  };
  set("products", rule.products, rule.layer_products);
  set("reactants", rule.reactants, rule.layer_reactants);
  if (!rule.where.empty()) event["where"] = rule.where;
  return event;
}

/// The members in which two emitters differ, as a person calls them.
std::string changed_members(const Emitter& before, const Emitter& after, const std::vector<std::string>& materials) {
  std::string names;
  const auto add = [&](bool differs, const std::string& name) {
    if (differs) names += (names.empty() ? "" : ", ") + name;
  };
  add(before.shape != after.shape,
      "becomes a " + (after.shape == simulation::EmitterShape::Surface
                          ? std::string("brush")
                          : std::string(simulation::kEmitterShapeNames[static_cast<std::size_t>(after.shape)])));
  add(before.is_on != after.is_on, after.is_on ? "on" : "off");
  add(before.direction != after.direction, "direction");
  add(before.size_mm != after.size_mm, "size");
  add(before.spread_deg != after.spread_deg, "spread " + short_number_text(rounded(after.spread_deg, 3)) + " deg");
  add(before.speed_mm_s != after.speed_mm_s, "speed " + short_number_text(rounded(after.speed_mm_s, 3)) + " mm/s");
  add(before.distance_mm != after.distance_mm, "distance " + short_number_text(rounded(after.distance_mm, 3)) + " mm");
  for (std::size_t i = 0; i < materials.size(); ++i) {
    add(before.carries[i] != after.carries[i], materials[i] + " " + short_number_text(rounded(after.carries[i], 3)));
  }
  return names.empty() ? "moved" : names;
}

std::string rule_members(const simulation::RuleChange& change) {
  if (change.rate) return *change.rate > 0.0 ? "rate " + short_number_text(rounded(*change.rate, 3)) : "rests";
  if (change.driver) return "formula";
  if (change.products) return "products";
  return change.reactants ? "reactants" : "where";
}

}  // namespace

std::string label_of(const simulation::SceneEvent& event, const Scene& scene) {
  const auto number = [](double value) { return short_number_text(rounded(value, 3)); };
  if (const auto* e = std::get_if<simulation::MoveEvent>(&event.what)) return "Move " + e->target;
  if (const auto* e = std::get_if<simulation::TurnEvent>(&event.what)) return "Turn " + e->object;
  if (const auto* e = std::get_if<simulation::ScaleEvent>(&event.what))
    return "Scale " + e->object + ": " + number(e->scale);
  if (const auto* e = std::get_if<simulation::RatioEvent>(&event.what)) return "Ratio " + number(e->ratio);
  if (const auto* e = std::get_if<simulation::RateEvent>(&event.what))
    return "Exchange of " + e->material + ": " + number(e->rate);
  if (const auto* e = std::get_if<simulation::SwitchEvent>(&event.what))
    return e->emitter + (e->is_on ? ": on" : ": off");
  if (const auto* e = std::get_if<simulation::EmitterEvent>(&event.what)) {
    const Emitter* before = item_named(scene.emitters, e->emitter.name);
    return e->emitter.name + ": " + (before ? changed_members(*before, e->emitter, scene.materials) : "changed");
  }
  if (const auto* e = std::get_if<simulation::RuleEvent>(&event.what))
    return item_named(scene.rules, e->rule) ? e->rule + ": " + rule_members(e->change) : "Begin " + e->rule;
  if (const auto* e = std::get_if<simulation::PaintEvent>(&event.what)) return "Stroke with " + e->emitter;
  return "How it flows";
}

/// Before the event happens. A rule that begins cannot leave: it rests.
std::vector<LiveEngine::BackEvent> LiveEngine::opposite(const simulation::SceneEvent& event) const {
  const Scene& scene = simulation_.scene();
  const double unit = file_.mm_per_unit;
  const auto one = [](const Json& back) {
    const std::string target = back.contains("emitter") ? back["emitter"].value("name", "") : back.value("target", "");
    return std::vector<BackEvent>{{back.value("op", "") + " " + target, std::make_shared<const Json>(back)}};
  };
  if (const auto* e = std::get_if<simulation::MoveEvent>(&event.what)) {
    const Emitter* emitter = item_named(scene.emitters, e->target);
    const simulation::SceneObject* object = item_named(scene.objects, e->target);
    if (!emitter && !object) return {};
    const Vec3 at = emitter ? emitter->position_mm : object->translate_mm;
    return one(event_for("move", e->target, "position", vector_json(at, unit)));
  }
  if (const auto* e = std::get_if<simulation::TurnEvent>(&event.what)) {
    const simulation::SceneObject* object = item_named(scene.objects, e->object);
    if (object) return one(event_for("turn", e->object, "rotate", vector_json(object->rotate_deg, 1.0)));
  }
  if (const auto* e = std::get_if<simulation::ScaleEvent>(&event.what)) {
    const simulation::SceneObject* object = item_named(scene.objects, e->object);
    if (object) return one(event_for("scale", e->object, "scale", object->scale));
  }
  if (const auto* e = std::get_if<simulation::EmitterEvent>(&event.what)) {
    const Emitter* emitter = item_named(scene.emitters, e->emitter.name);
    if (emitter) return one({{"op", "emitter"}, {"emitter", emitter_of_file(*emitter, scene.materials, unit)}});
  }
  if (const auto* e = std::get_if<simulation::SwitchEvent>(&event.what)) {
    const Emitter* emitter = item_named(scene.emitters, e->emitter);
    if (emitter) return one(event_for("switch", e->emitter, "on", emitter->is_on));
  }
  if (std::holds_alternative<simulation::RatioEvent>(event.what))
    return one({{"op", "ratio"}, {"ratio", scene.exchange.ratio}});
  if (const auto* e = std::get_if<simulation::RateEvent>(&event.what)) {
    const auto found = std::find(scene.materials.begin(), scene.materials.end(), e->material);
    if (found != scene.materials.end())
      return one(event_for("rate", e->material, "rate", scene.exchange.rates[found - scene.materials.begin()]));
  }
  if (std::holds_alternative<simulation::BehaviorEvent>(event.what)) {
    const Json behavior =
        slider_ ? Json{{"slider", *slider_}, {"absorb", scene.behavior.absorb}} : behavior_json(scene.behavior);
    return one({{"op", "behavior"}, {"behavior", behavior}});
  }
  if (const auto* e = std::get_if<simulation::RuleEvent>(&event.what)) {
    const simulation::Rule* rule = item_named(scene.rules, e->rule);
    if (!rule) return one(event_for("rule", e->rule, "rate", 0.0));
    Json back = rule_event(*rule, scene.materials);
    if (e->change.where && !back.contains("where")) back["where"] = "";
    return one(back);
  }
  return {};
}

/// An event that a step keeps.
void LiveEngine::perform_now(const Json& event_without_iteration) {
  Json event{{"iteration", simulation_.iteration()}};
  event.update(event_without_iteration);
  perform(event, parse_event(event, simulation_.scene(), file_.mm_per_unit));
}

}  // namespace patinate::studio
