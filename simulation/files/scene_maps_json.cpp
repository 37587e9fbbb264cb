#include "simulation/files/scene_maps_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "libcommon/core/expression.h"
#include "libcommon/core/json_options.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/rules/initial_amounts.h"
#include "simulation/rules/scene_maps.h"
#include "simulation/rules/surface_parameter.h"

namespace patinate::simulation {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxMaps = 64;
constexpr std::array<std::string_view, 6> kFunctionNames{"min", "max", "abs", "pow", "clamp", "smoothstep"};

/// Reads options of one kind from the members of an object.
class MapOptionReader final : public JsonOptionReader {
 public:
  /// @param names  Options that count; all others are passed over.
  MapOptionReader(JsonReader& json, const SceneContext& context, std::string kind, std::vector<std::string> names)
      : json_(json), context_(context), kind_(std::move(kind)), names_(std::move(names)) {}

  using JsonOptionReader::visit;
  void visit(const OptionInfo& info, std::string& value) override {
    const auto json = given(info);
    if (!json) return;
    value = json->string();
    if (fs::path(value).extension().empty()) return;  // a word
    context_.add_input(json->pointer(), json->path());
    value = json->path().string();
  }

 private:
  [[nodiscard]] std::optional<JsonReader> given(const OptionInfo& info) override {
    std::string key(info.name);
    if (std::find(names_.begin(), names_.end(), key) == names_.end()) return std::nullopt;
    if (key.starts_with(kind_ + "_")) key.erase(0, kind_.size() + 1);
    if (info.unit == "mm") key += "_mm";
    return json_.has(key) ? std::optional(json_.member(key)) : std::nullopt;
  }

  JsonReader& json_;
  const SceneContext& context_;
  std::string kind_;
  std::vector<std::string> names_;
};

std::vector<std::string> object_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneObject& object : scene.objects) names.push_back(object.name);
  return names;
}

std::string list_text(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

std::size_t object_index(const JsonReader& json, const std::string& name, const Scene& scene) {
  const std::vector<std::string> names = object_names(scene);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) json.fail("the name of an object (" + list_text(names) + ")" + did_you_mean(name, names));
  return static_cast<std::size_t>(found - names.begin());
}

ImageF read_map_picture(const JsonReader& json, const SceneContext& context) {
  ImageF image = context.read_picture(json, 1);
  const auto values = image.values();
  if (!std::all_of(values.begin(), values.end(), [](float v) { return v >= 0.0F && v <= 1.0F; }))
    json.fail("a picture of values in [0, 1]");
  return image;
}

void read_images(JsonReader& json, const SceneContext& context, const Scene& scene, SceneMap& map) {
  map.images.resize(scene.objects.size());
  if (json.has("image") == json.has("images"))
    json.fail("\"image\", a picture over the UVs of each object, or \"images\", one by object");
  if (json.has("image")) {
    const ImageF image = read_map_picture(json.member("image"), context);
    std::fill(map.images.begin(), map.images.end(), image);
    return;
  }
  JsonReader images = json.member("images");
  for (const std::string& name : images.keys()) {
    const JsonReader path = images.member(name);
    map.images[object_index(path, name, scene)] = read_map_picture(path, context);
  }
}

void read_objects(const JsonReader& json, const Scene& scene, SceneMap& map) {
  map.is_inside.assign(scene.objects.size(), false);
  for (const JsonReader& element : json.elements(scene.objects.size()))
    map.is_inside[object_index(element, element.string(), scene)] = true;
}

void check_distance_source(JsonReader& json, const Scene& scene, const SceneMap& map) {
  if (map.kind != "distance") return;
  if (map.options.distance_from.empty()) (void)json.member("from");
  const fs::path from(map.options.distance_from);
  if (scene.objects.size() > 1 && !from.extension().empty() && from.extension() != ".csv")
    json.member("from").fail("edges or a CSV of curves: a picture has no place in a scene with several objects");
  try {
    (void)control_input_files(map.kind, map.options);
  } catch (const ParseError&) {
    json.member("from").fail("boundary, creases, ridges, valleys, a CSV of curves or a picture");
  }
}

/// A map but for its name. @param json  Its members; not finished.
SceneMap read_map(JsonReader& json, const SceneContext& context, const Scene& scene) {
  if (!json.is_object()) json.fail("a map: an object with \"kind\"");
  SceneMap map;
  const std::vector<std::string>& kinds = scene_map_kinds();
  if (!json.has("kind") && (json.has("image") || json.has("images"))) {
    map.kind = "image";
  } else {
    map.kind = json.member("kind").string();
    if (std::find(kinds.begin(), kinds.end(), map.kind) == kinds.end())
      json.member("kind").fail("a kind of map (" + list_text(kinds) + ")" + did_you_mean(map.kind, kinds));
  }
  if (map.kind == "image") {
    read_images(json, context, scene, map);
  } else if (map.kind == "objects") {
    read_objects(json.member("objects"), scene, map);
  } else if (map.kind == "noise") {
    MapOptionReader reader(json, context, map.kind, {"noise_wavelength", "noise_octaves", "noise_seed"});
    describe(reader, map.noise);
  } else if (map.kind == "wood_grain") {
    MapOptionReader reader(json, context, map.kind,
                           {"wood_grain_ring", "wood_grain_stretch", "wood_grain_waviness",
                            "wood_grain_knots_per_meter", "wood_grain_seed"});
    describe(reader, map.wood_grain);
  } else {
    const std::vector<std::string> names = control_option_names(map.kind);
    const double gravity = scene.gravity_mm_s2.norm();
    if (gravity > 0.0 && !json.has("up")) {
      for (int k = 0; k < 3; ++k) map.options.up[k] = 0.0 - scene.gravity_mm_s2[k] / gravity;
      map.options.facing.direction = map.options.up;
    }
    MapOptionReader reader(json, context, map.kind, names);
    describe(reader, map.options);
    check_distance_source(json, scene, map);
  }
  return map;
}

/// @returns the map's name: WORD_1, WORD_2, ...
std::string add_map(SceneMap map, const std::string& word, Scene& scene) {
  const std::vector<std::string> taken = driver_names(scene.materials, map_names(scene), layer_names(scene));
  int number = 1;
  while (std::find(taken.begin(), taken.end(), word + "_" + std::to_string(number)) != taken.end()) ++number;
  map.name = word + "_" + std::to_string(number);
  scene.maps.push_back(std::move(map));
  return scene.maps.back().name;
}

void check_map_name(const JsonReader& json, const std::string& name, const Scene& scene) {
  if (!is_map_name(name) || std::find(kFunctionNames.begin(), kFunctionNames.end(), name) != kFunctionNames.end())
    json.fail("a map whose name is letters, digits and _, and no function of expressions");
  if (std::find(scene.materials.begin(), scene.materials.end(), name) != scene.materials.end())
    json.fail("a map of another name than '" + name + "': the material of that name would hide it");
  if (name == "slope" || is_time_signal(name))
    json.fail("a map of another name than '" + name + "', which drivers have already");
}

}  // namespace

void read_maps(JsonReader json, const SceneContext& context, Scene& scene) {
  const std::vector<std::string> names = json.keys();
  if (names.size() > kMaxMaps) json.fail("at most " + std::to_string(kMaxMaps) + " maps");
  for (const std::string& name : names) {
    JsonReader member = json.member(name);
    check_map_name(member, name, scene);
    SceneMap map = read_map(member, context, scene);
    member.finish();
    map.name = name;
    scene.maps.push_back(std::move(map));
  }
}

std::string read_mask(const JsonReader& json, const SceneContext& context, Scene& scene) {
  if (json.is_string()) return json.string();
  SceneMap map;
  if (json.is_array()) {
    map.kind = "objects";
    read_objects(json, scene, map);
  } else if (json.is_object()) {
    JsonReader members = json;
    map = read_map(members, context, scene);
    members.finish();
  } else {
    json.fail("an expression, a list of objects, or a map");
  }
  return add_map(std::move(map), "where", scene);
}

void check_pattern(const JsonReader& json, const Preset& preset, const Scene& scene) {
  if (preset.pattern.empty()) return;
  std::vector<std::string> names = map_names(scene);
  names.insert(names.end(), built_in_maps().begin(), built_in_maps().end());
  if (std::find(names.begin(), names.end(), preset.pattern) == names.end()) {
    json.fail("a preset whose pattern, '" + preset.pattern + "', is a map (" + list_text(names) + ")" +
              did_you_mean(preset.pattern, names));
  }
}

std::string read_start_value(JsonReader json, const Range& range, const std::string& word, const SceneContext& context,
                             Scene& scene) {
  if (json.is_number()) return number_text(json.number(range));
  if (!json.is_object()) return json.string();
  const double amount = json.has("amount") ? json.member("amount").number(range) : 1.0;
  SceneMap map = read_map(json, context, scene);
  json.finish();
  return number_text(amount) + " * " + add_map(std::move(map), word, scene);
}

void read_initial(JsonReader json, const SceneContext& context, Scene& scene, std::size_t object) {
  for (const std::string& material : json.keys()) {
    const JsonReader value = json.member(material);
    const auto m = static_cast<std::size_t>(material_index(value, material, scene.materials));
    scene.objects[object].initial[m] = read_start_value(value, between(0, kMostAmount), "initial", context, scene);
    try {
      (void)initial_names(scene, object, static_cast<int>(m));
    } catch (const InvalidInput& e) {
      throw IoError(value.file(), value.pointer() + ": " + e.what());
    }
  }
}

}  // namespace patinate::simulation
