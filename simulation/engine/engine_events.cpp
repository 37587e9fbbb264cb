#include <algorithm>

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

void change_rule(const SceneEvent& event, std::vector<Rule>& rules) {
  if (!event.rule) throw InvalidInput("a rule event says nothing of a rule");
  const RuleChange& change = *event.rule;
  if (std::count_if(rules.begin(), rules.end(), [&](const Rule& rule) { return rule.name == event.target; }) > 1) {
    throw InvalidInput("two rules are called '" + event.target + "': give each a name of its own to change one");
  }
  Rule* rule = find_named(rules, event.target);
  if (!rule && !change.begins) throw InvalidInput("the scene has no rule called '" + event.target + "'");
  if (!rule) {
    if (rules.size() >= kMaxRules)
      throw InvalidInput("the scene has " + std::to_string(rules.size()) + " rules; more cannot come to it");
    rules.push_back(*change.begins);
    return;
  }
  if (change.driver) rule->driver = *change.driver;
  if (change.rate) rule->rate = *change.rate;
  if (change.products) rule->products = *change.products;
  if (change.reactants) rule->reactants = *change.reactants;
}

}  // namespace

bool apply_event(const SceneEvent& event, Scene& scene) {
  using Op = SceneEvent::Op;
  switch (event.op) {
    case Op::Move:
      if (Emitter* emitter = find_named(scene.emitters, event.target)) {
        emitter->position_mm = event.value;
        return false;
      }
      object_named(scene, event.target).translate_mm = event.value;
      return true;
    case Op::Turn:
      object_named(scene, event.target).rotate_deg = event.value;
      return true;
    case Op::Scale:
      object_named(scene, event.target).scale = event.value[0];
      return true;
    case Op::Emitter: {
      Emitter* emitter = find_named(scene.emitters, event.target);
      if (!emitter || !event.emitter) throw InvalidInput("the scene has no emitter called '" + event.target + "'");
      if (emitter->gammatons != event.emitter->gammatons || emitter->name != event.emitter->name) {
        throw InvalidInput(
            "an emitter keeps its name and its number of gammatons: the streams of the others would shift");
      }
      *emitter = *event.emitter;
      return false;
    }
    case Op::Switch: {
      Emitter* emitter = find_named(scene.emitters, event.target);
      if (!emitter) throw InvalidInput("the scene has no emitter called '" + event.target + "'");
      emitter->is_on = event.value[0] != 0.0;
      return false;
    }
    case Op::Ratio:
      scene.exchange.ratio = event.value[0];
      return false;
    case Op::Rate: {
      const auto found = std::find(scene.materials.begin(), scene.materials.end(), event.target);
      if (found == scene.materials.end()) throw InvalidInput("the scene has no material called '" + event.target + "'");
      scene.exchange.rates[static_cast<std::size_t>(found - scene.materials.begin())] = event.value[0];
      return false;
    }
    case Op::Behavior:
      if (event.behavior) scene.behavior = *event.behavior;
      return false;
    case Op::Rule:
      change_rule(event, scene.rules);
      return false;
    case Op::Paint:
      return false;  // changes no scene: Simulation::paint()
  }
  return false;
}

}  // namespace patinate::simulation
