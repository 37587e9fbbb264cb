#include <algorithm>
#include <variant>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/engine/engine_state.h"

namespace patinate::simulation {

namespace {

template <class Item>
Item* find_named(std::vector<Item>& items, const std::string& name) {
  const auto found = std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  return found == items.end() ? nullptr : &*found;
}

SceneObject& object_named(Scene& scene, const std::string& name) {
  if (SceneObject* object = find_named(scene.objects, name)) return *object;
  throw InvalidInput("the scene has no object called '" + name + "'");
}

Emitter& emitter_named(Scene& scene, const std::string& name) {
  if (Emitter* emitter = find_named(scene.emitters, name)) return *emitter;
  throw InvalidInput("the scene has no emitter called '" + name + "'");
}

// One for each kind of event. Each says whether objects have moved.

bool apply(const MoveEvent& event, Scene& scene) {
  if (Emitter* emitter = find_named(scene.emitters, event.target)) {
    emitter->position_mm = event.position_mm;
    return false;
  }
  object_named(scene, event.target).translate_mm = event.position_mm;
  return true;
}

bool apply(const TurnEvent& event, Scene& scene) {
  object_named(scene, event.object).rotate_deg = event.rotate_deg;
  return true;
}

bool apply(const ScaleEvent& event, Scene& scene) {
  object_named(scene, event.object).scale = event.scale;
  return true;
}

bool apply(const EmitterEvent& event, Scene& scene) {
  Emitter& emitter = emitter_named(scene, event.emitter.name);
  if (emitter.gammatons != event.emitter.gammatons) {
    throw InvalidInput("an emitter keeps its name and its number of gammatons: the streams of the others would shift");
  }
  emitter = event.emitter;
  return false;
}

bool apply(const SwitchEvent& event, Scene& scene) {
  emitter_named(scene, event.emitter).is_on = event.is_on;
  return false;
}

bool apply(const RatioEvent& event, Scene& scene) {
  scene.exchange.ratio = event.ratio;
  return false;
}

bool apply(const RateEvent& event, Scene& scene) {
  const auto found = std::find(scene.materials.begin(), scene.materials.end(), event.material);
  if (found == scene.materials.end()) throw InvalidInput("the scene has no material called '" + event.material + "'");
  scene.exchange.rates[found - scene.materials.begin()] = event.rate;
  return false;
}

bool apply(const BehaviorEvent& event, Scene& scene) {
  scene.behavior = event.behavior;
  return false;
}

bool apply(const RuleEvent& event, Scene& scene) {
  std::vector<Rule>& rules = scene.rules;
  const RuleChange& change = event.change;
  if (std::count_if(rules.begin(), rules.end(), [&](const Rule& rule) { return rule.name == event.rule; }) > 1) {
    throw InvalidInput("two rules are called '" + event.rule + "': give each a name of its own to change one");
  }
  Rule* rule = find_named(rules, event.rule);
  if (!rule && !change.begins) throw InvalidInput("the scene has no rule called '" + event.rule + "'");
  if (!rule) {
    if (rules.size() >= kMaxRules)
      throw InvalidInput("the scene has " + std::to_string(rules.size()) +
                         " rules, the most that it may have; no rule can be added");
    rules.push_back(*change.begins);
    return false;
  }
  if (change.driver) rule->driver = *change.driver;
  if (change.rate) rule->rate = *change.rate;
  if (change.products) rule->products = *change.products;
  if (change.reactants) rule->reactants = *change.reactants;
  if (change.layer_products) rule->layer_products = *change.layer_products;
  if (change.layer_reactants) rule->layer_reactants = *change.layer_reactants;
  if (change.where) rule->where = *change.where;
  return false;
}

/// Changes no scene: Simulation::paint().
bool apply(const PaintEvent&, Scene&) { return false; }

}  // namespace

bool apply_event(const SceneEvent& event, Scene& scene) {
  return std::visit([&](const auto& what) { return apply(what, scene); }, event.what);
}

}  // namespace patinate::simulation
