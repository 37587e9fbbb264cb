#include <nlohmann/json.hpp>
#include <string_view>

#include "libcommon/core/text.h"
#include "simulation/files/scene_json.h"

namespace patinate::simulation {

/// Default appearance parameters and presets: simulation/scene/assets/materials.json.
extern const std::string_view kMaterialLibrary;

namespace {

const Json& library() {
  static const Json json = Json::parse(kMaterialLibrary, nullptr, true, true);
  return json;
}

Vec3 read_material_color(JsonReader json) {
  const std::vector<double> rgb = json.numbers(3, between(0, 1));
  return {rgb[0], rgb[1], rgb[2]};
}

std::vector<ColorStop> read_color_stops(JsonReader json) {
  std::vector<ColorStop> stops;
  std::vector<JsonReader> elements = json.elements();
  if (elements.size() < 2 || elements.size() > kMaxColorStops)
    json.fail("2 to " + std::to_string(kMaxColorStops) + " colors, each with its amount");
  for (JsonReader& one : elements) {
    const double least = stops.empty() ? 0.0 : stops.back().amount + kMinColorStep;
    ColorStop stop{.amount = one.member("amount").number(between(least, kMostAmount)),
                   .color = read_material_color(one.member("color"))};
    if (one.has("second_color")) stop.second_color = read_material_color(one.member("second_color"));
    one.finish();
    stops.push_back(stop);
  }
  return stops;
}

/// One color, with or without a second one, or colors by amount; what is given takes the place of all the default's.
void read_colors(JsonReader& json, MaterialAppearance& look, const SceneContext& context) {
  if (json.has("colors")) {
    if (json.has("color") || json.has("second_color"))
      json.fail("\"colors\" by amount, or \"color\" with or without \"second_color\"");
    look.colors = read_color_stops(json.member("colors"));
    look.color = {.color = look.colors.back().color};
    look.second_color.reset();
    return;
  }
  if (json.has("color") || json.has("second_color")) look.colors.clear();
  if (json.has("color")) {
    look.color = read_color_source(json.member("color"), context);
    look.second_color.reset();
  }
  if (json.has("second_color")) look.second_color = read_material_color(json.member("second_color"));
}

}  // namespace

ColorSource read_color_source(JsonReader json, const SceneContext& context) {
  ColorSource source;
  if (json.is_string()) {
    source.image = context.read_picture(json, 3);
  } else if (json.is_object()) {
    source.image = context.read_picture(json.member("image"), 3);
    source.image_mm = json.member("width_mm").number(between(1e-6, 1e9));
    json.finish();
  } else {
    source.color = read_material_color(json);
  }
  return source;
}

MaterialAppearance read_material_appearance(JsonReader json, MaterialAppearance defaults, const SceneContext& context) {
  MaterialAppearance look = std::move(defaults);
  const auto number = [&](const char* name, double& value, const Range& range) {
    if (json.has(name)) value = json.member(name).number(range);
  };
  read_colors(json, look, context);
  number("strength", look.strength, between(0, 1000));
  number("variation", look.variation, between(0, 1));
  number("specular", look.specular, between(-1, 1));
  number("specular_variation", look.specular_variation, between(0, 1));
  number("height", look.height_mm, between(-1e6, 1e6));
  number("height_variation", look.height_variation, between(0, 1));
  number("grain", look.grain_mm, between(0, 1e9));
  json.finish();
  return look;
}

Preset read_preset(JsonReader json, const SceneContext& context, bool may_have_others) {
  Preset preset;
  if (json.has("composition")) {
    JsonReader composition = json.member("composition");
    for (std::size_t i = 0; i < context.materials.size(); ++i) {
      if (composition.has(context.materials[i]))
        preset.amounts[i] = composition.member(context.materials[i]).number(between(0, 3));
    }
    if (!may_have_others) composition.finish();
  }
  if (json.has("color")) preset.color = read_color_source(json.member("color"), context);
  if (json.has("second_color") != (json.has("pattern") || json.has("grain")) ||
      (json.has("pattern") && json.has("grain"))) {
    json.fail(
        "\"second_color\" and one of \"pattern\", the map that says where it is, and \"grain\", the length of noise "
        "that "
        "does, or none of them");
  }
  if (json.has("second_color")) preset.second_color = read_material_color(json.member("second_color"));
  if (json.has("pattern")) preset.pattern = json.member("pattern").string();
  if (json.has("grain")) preset.grain_mm = json.member("grain").number(above(0));
  if (json.has("specular")) preset.specular = json.member("specular").number(between(0, 1));
  if (json.has("metalness")) preset.metalness = json.member("metalness").number(between(0, 1));
  json.finish();
  return preset;
}

std::map<std::string, MaterialAppearance> library_appearance(const SceneContext& context) {
  std::map<std::string, MaterialAppearance> appearance;
  for (const auto& [name, value] : library().at("appearance").items()) {
    appearance[name] =
        read_material_appearance(JsonReader("materials.json", value, "/appearance/" + name), {}, context);
  }
  return appearance;
}

std::map<std::string, Preset> library_presets(const SceneContext& context) {
  std::map<std::string, Preset> presets;
  for (const auto& [name, value] : library().at("presets").items()) {
    presets[name] = read_preset(JsonReader("materials.json", value, "/presets/" + name), context, true);
  }
  return presets;
}

}  // namespace patinate::simulation
