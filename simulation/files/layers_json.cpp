#include "simulation/files/layers_json.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/files/scene_maps_json.h"
#include "simulation/rules/initial_layers.h"

namespace patinate::simulation {

namespace {

std::string read_layer_name(const JsonReader& json, const std::vector<Layer>& others) {
  std::string name = json.string();
  if (!is_map_name(name)) json.fail("a name of letters, digits and _, no digit first");
  if (std::any_of(others.begin(), others.end(), [&](const Layer& layer) { return layer.name == name; }))
    json.fail("names of layers that differ");
  return name;
}

CrackTension read_tension(JsonReader json) {
  CrackTension tension;
  if (json.has("along")) tension.along = read_direction(json.member("along"));
  tension.ratio = json.member("ratio").number(between(0.1, 10));
  json.finish();
  return tension;
}

LayerCracks read_cracks(JsonReader json, const std::string& layer, const SceneContext& context, Scene& scene) {
  LayerCracks cracks;
  if (json.has("strength"))
    cracks.strength =
        read_start_value(json.member("strength"), between(0, kMaxStrength), layer + "_strength", context, scene);
  if (json.has("relief")) cracks.relief = json.member("relief").number(between(0.1, 1000));
  if (json.has("shrinkage")) cracks.shrinkage = json.member("shrinkage").number(between(0, 0.5));
  if (json.has("initial")) {
    constexpr double kMostFactor = 1000.0;
    cracks.initial =
        read_start_value(json.member("initial"), between(0, kMostFactor), layer + "_cracks", context, scene);
  }
  if (json.has("tension")) cracks.tension = read_tension(json.member("tension"));
  json.finish();
  return cracks;
}

/// @param others  Those below it; none: it is the substrate.
Layer read_layer(JsonReader json, const SceneContext& context, const std::map<std::string, Preset>& presets,
                 const std::vector<Layer>& others, Scene& scene) {
  Layer layer{.name = read_layer_name(json.member("name"), others)};
  for (const char* name : {"thickness_um", "adhesion", "cracks"}) {
    if (others.empty() && json.has(name)) json.member(name).fail("none: the first layer is the substrate");
  }
  if (!others.empty()) {
    layer.thickness_um = read_start_value(json.member("thickness_um"), between(0, kMaxThicknessUm),
                                          layer.name + "_thickness", context, scene);
    if (json.has("adhesion"))
      layer.adhesion =
          read_start_value(json.member("adhesion"), between(0, 1), layer.name + "_adhesion", context, scene);
    if (json.has("cracks")) layer.cracks = read_cracks(json.member("cracks"), layer.name, context, scene);
  }
  if (json.has("preset")) {
    layer.look = preset_named(json.member("preset"), presets);
    json.finish();
  } else {
    layer.look = read_preset(json, context, false);
  }
  check_pattern(json, layer.look, scene);
  return layer;
}

}  // namespace

const Preset& preset_named(const JsonReader& json, const std::map<std::string, Preset>& presets) {
  const std::string name = json.string();
  const auto found = presets.find(name);
  if (found != presets.end()) return found->second;
  std::vector<std::string> names;
  std::string list;
  for (const auto& [known, preset] : presets) {
    names.push_back(known);
    list += (list.empty() ? "" : ", ") + known;
  }
  json.fail("a preset (" + list + ")" + did_you_mean(name, names));
}

void read_layers(const JsonReader& json, const SceneContext& context, const std::map<std::string, Preset>& presets,
                 Scene& scene, std::size_t object) {
  const std::vector<JsonReader> elements = json.elements();
  if (elements.empty() || elements.size() > kMaxLayers)
    json.fail("1 to " + std::to_string(kMaxLayers) + " layers, the substrate included");
  std::vector<Layer> layers;
  for (const JsonReader& element : elements) layers.push_back(read_layer(element, context, presets, layers, scene));
  SceneObject& of = scene.objects[object];
  of.preset = layers.front().look;
  if (layers.size() == 1) return;
  of.preset.amounts = {};
  of.layers = std::move(layers);
  for (std::size_t l = 1; l < of.layers.size(); ++l) {
    try {
      (void)layer_map_names(scene, object, l);
    } catch (const InvalidInput& e) {
      throw IoError(elements[l].file(), elements[l].pointer() + ": " + e.what());
    }
  }
}

}  // namespace patinate::simulation
