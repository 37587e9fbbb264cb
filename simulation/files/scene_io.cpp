#include "patinate/simulation/scene_io.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/geometry/mesh_repair.h"
#include "libcommon/history/history_documents.h"
#include "libcommon/history/history_times.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/atlas/atlas_mesh.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "simulation/files/layers_json.h"
#include "simulation/files/scene_json.h"
#include "simulation/files/scene_maps_json.h"
#include "simulation/files/scene_notes.h"
#include "simulation/files/weather_json.h"
#include "simulation/rules/rule_io.h"
#include "simulation/rules/scene_maps.h"
#include "simulation/tracing/scene_checks.h"

namespace patinate::simulation {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxObjects = 1000;

std::vector<std::string> read_names(const JsonReader& json) {
  std::vector<std::string> names;
  for (const JsonReader& element : json.elements(1000)) {
    names.push_back(element.string());
    if (names.back().empty()) element.fail("a name");
    if (std::count(names.begin(), names.end(), names.back()) > 1) element.fail("names that differ");
  }
  if (names.empty() || names.size() > kMaxMaterials) json.fail("1 to " + std::to_string(kMaxMaterials) + " materials");
  return names;
}

/// Members of an object, by name.
std::vector<std::pair<std::string, JsonReader>> read_members(JsonReader& parent, const Json& root,
                                                             std::string_view key) {
  std::vector<std::pair<std::string, JsonReader>> members;
  if (!parent.has(key)) return members;
  JsonReader object = parent.member(key);
  if (!object.is_object()) object.fail("an object");
  for (const auto& [name, value] : root.at(std::string(key)).items()) members.emplace_back(name, object.member(name));
  return members;
}

std::vector<MaterialAppearance> read_appearance(JsonReader& json, const Json& root, const SceneContext& context) {
  const std::map<std::string, MaterialAppearance> library = library_appearance(context);
  std::vector<MaterialAppearance> appearance(context.materials.size());
  std::vector<bool> is_known(appearance.size(), false);
  for (std::size_t i = 0; i < appearance.size(); ++i) {
    const auto found = library.find(context.materials[i]);
    if (found == library.end()) continue;
    appearance[i] = found->second;
    is_known[i] = true;
  }
  for (auto& [name, member] : read_members(json, root, "appearance")) {
    const auto i = static_cast<std::size_t>(material_index(member, name, context.materials));
    appearance[i] = read_material_appearance(member, appearance[i], context);
    is_known[i] = true;
  }
  for (std::size_t i = 0; i < appearance.size(); ++i) {
    if (is_known[i]) continue;
    std::string known;
    for (const auto& [name, look] : library) known += (known.empty() ? "" : ", ") + name;
    json.member("materials")
        .fail("for '" + context.materials[i] + "' a member of \"appearance\": only " + known +
              " look like something by themselves");
  }
  return appearance;
}

/// Result of `read`, also from an earlier call under this key.
template <class T, class Read>
T asset(std::mutex& mutex, std::map<std::string, T>& assets, const std::string& key, Read&& read) {
  {
    const std::scoped_lock lock(mutex);
    if (const auto found = assets.find(key); found != assets.end()) return found->second;
  }
  T value = read();
  const std::scoped_lock lock(mutex);
  return assets.try_emplace(key, std::move(value)).first->second;
}

class ObjectReader {
 public:
  ObjectReader(SceneFile& file, const SceneContext& context, const std::map<std::string, Preset>& presets,
               AtlasMethod method, SceneAssets& assets)
      : file_(file), context_(context), presets_(presets), method_(method), assets_(assets) {}

  [[nodiscard]] SceneObject read(JsonReader json, const RunControl& control) {
    SceneObject object;
    object.name = json.member("name").string();
    if (json.has("crease")) object.crease_deg = json.member("crease").number(between(0, 180));
    if (json.has("texels_per_mm")) object.texels_per_mm = json.member("texels_per_mm").number(between(1e-9, 1e9));
    LaidOutMesh laid_out = read_object_mesh(json, object.name, object.crease_deg, control);
    object.mesh = std::move(laid_out.mesh);
    object.has_file_uvs = laid_out.has_file_uvs;
    if (json.has("preset")) {
      if (json.has("layers")) json.member("preset").fail("no preset beside \"layers\", whose first has one");
      object.preset = preset_named(json.member("preset"), presets_);
    }
    if (json.has("layers")) (void)json.member("layers");  // once the maps are known
    if (json.has("maps")) read_maps(json.member("maps"), object);
    const auto vector = [&](const char* name, double scale, Vec3& value) {
      if (!json.has(name)) return;
      const std::vector<double> v = json.member(name).numbers(3);
      value = Vec3(v[0], v[1], v[2]) * scale;
    };
    vector("translate", context_.mm_per_unit, object.translate_mm);
    vector("rotate", 1.0, object.rotate_deg);
    if (json.has("scale")) object.scale = json.member("scale").number(above(0));
    if (json.has("initial")) (void)json.member("initial");  // once the maps are known
    json.finish();
    return object;
  }

 private:
  [[nodiscard]] LaidOutMesh read_object_mesh(JsonReader& json, const std::string& name, double crease_deg,
                                             const RunControl& control) {
    const fs::path path = json.member("mesh").path();
    if (!assets_.given_meshes.contains(path)) file_.inputs.emplace_back("mesh of " + name, path);
    const std::string node = json.has("node") ? json.member("node").string() : "";
    const std::string material = json.has("material") ? json.member("material").string() : "";
    const std::string key = path.string() + "|" + node + "|" + material + "|" +
                            std::to_string(static_cast<int>(method_)) + "|" + std::to_string(file_.scene.resolution) +
                            "|" + number_text(context_.mm_per_unit) + "|" + number_text(crease_deg);
    return asset(assets_.mutex, assets_.meshes, key,
                 [&] { return laid_out_mesh(path, name, node, material, crease_deg, control); });
  }

  [[nodiscard]] LaidOutMesh laid_out_mesh(const fs::path& path, const std::string& name, const std::string& node,
                                          const std::string& material, double crease_deg, const RunControl& control) {
    try {
      std::vector<std::string> notes;
      const auto given = assets_.given_meshes.find(path);
      Mesh mesh = given != assets_.given_meshes.end() ? *given->second : read_mesh(path, &notes);
      for (const std::string& note : notes) file_.notes.push_back(path.string() + ": " + note);
      if (!node.empty() || !material.empty()) mesh = select_surfaces(mesh, node, material);
      RepairedMesh repaired = repair_mesh(std::move(mesh));
      if (const std::string text = repaired.repairs.text(); !text.empty())
        file_.notes.push_back(path.string() + ": " + text);
      mesh = with_crease_normals(std::move(repaired.mesh), crease_deg);
      scale_mesh(mesh, is_gltf_file(path) ? 1000.0 : context_.mm_per_unit);
      const AtlasMesh atlas = make_atlas_mesh(std::move(mesh), method_, file_.scene.resolution, control);
      for (const std::string& note : atlas.notes) file_.notes.push_back("object '" + name + "': " + note);
      return {.mesh = sheet_mesh(atlas, make_sheet(atlas.tile_names(), file_.scene.resolution)),
              .has_file_uvs = !atlas.is_unwrapped && atlas.tile_names().size() == 1};
    } catch (const InvalidInput& e) {
      throw IoError(path.string(), e.what());
    }
  }

  void read_maps(JsonReader json, SceneObject& object) {
    if (json.has("color")) object.color_map = context_.read_picture(json.member("color"), 3);
    if (json.has("specular")) object.specular_map = context_.read_picture(json.member("specular"), 1);
    if (json.has("height")) object.height_map = context_.read_picture(json.member("height"), 1);
    json.finish();
  }

  SceneFile& file_;
  const SceneContext& context_;
  const std::map<std::string, Preset>& presets_;
  AtlasMethod method_;
  SceneAssets& assets_;
};

AtlasMethod read_atlas(JsonReader json, Scene& scene) {
  int method = 0;
  if (json.has("resolution"))
    scene.resolution = static_cast<int>(json.member("resolution").integer(between(16, 16384)));
  if (json.has("uvs")) method = json.member("uvs").choice(kAtlasMethodNames);
  json.finish();
  return static_cast<AtlasMethod>(method);
}

void read_time(JsonReader json, SceneFile& file) {
  if (json.has("unit")) file.time_unit = static_cast<TimeUnit>(json.member("unit").choice(kTimeUnitNames));
  if (json.has("per_iteration")) {
    const JsonReader time = json.member("per_iteration");
    file.scene.time_per_iteration = time.number(between(0, 1e9));
    if (file.scene.time_per_iteration > 0.0 && file.scene.time_per_iteration < kMinTimeStep)
      time.fail("0, for none, or at least 1e-12");
  }
  if (json.has("contact")) (void)json.member("contact");  // once the exchange is known
  json.finish();
}

/// "contact" of "time".
void read_contact(JsonReader json, ExchangeOptions& exchange) {
  if (json.has("contact")) exchange.contact = json.member("contact").number(between(0, 1e6));
}

/// Steps of a two-hundredth of the largest object; drops cling round edges of up to 30 degrees and more where they are
/// rounded.
TracingOptions tracing_of_size(const Scene& scene) {
  double size = 0.0;
  for (const SceneObject& object : scene.objects)
    size = std::max(size, object.scale * bounding_box(object.mesh).diagonal());
  TracingOptions t;
  t.reach_mm = size / 200.0;
  t.epsilon_mm = 0.4 * t.reach_mm;
  t.pull = 0.6;
  t.rest_speed_mm_s = size / 500.0;
  t.wet_attraction = 0.3;
  t.rivulet_mm = 3.0 * scene.exchange.splat_mm;
  return t;
}

/// A rule with what it is limited to.
Rule read_limited_rule(const JsonReader& json, const SceneContext& context, Scene& scene) {
  const std::vector<std::string> maps = map_names(scene), layers = layer_names(scene);
  Rule rule = read_scene_rule(json, scene.materials, maps, layers);
  JsonReader members = json;
  if (members.is_object() && members.has("where")) rule.where = read_mask(members.member("where"), context, scene);
  check_signals(json, rule, context, scene);
  return rule;
}

/// A drop is as wide as three texels of an atlas of 1024 that is two thirds covered.
double drop_width_mm(const Scene& scene) {
  // A 1024 atlas that is two thirds covered (docs/algorithms/material_exchange.md, Splats).
  constexpr double kTexels = 1024.0 * 1024.0 * 2.0 / 3.0;
  double area = 0.0;
  for (const SceneObject& object : scene.objects) {
    for (int t = 0; t < object.mesh.num_triangles(); ++t)
      area += 0.5 * area_vector(object.mesh, t).norm() * object.scale * object.scale;
  }
  return 3.0 * std::sqrt(area / kTexels);
}

/// "layers" of an object, or of its preset. @param layered  Of presets.
std::optional<JsonReader> layers_of(JsonReader& object, const std::map<std::string, JsonReader>& layered) {
  if (object.has("layers")) return object.member("layers");
  if (!object.has("preset")) return std::nullopt;
  const auto found = layered.find(object.member("preset").string());
  return found == layered.end() ? std::nullopt : std::optional(found->second);
}

void read_run(JsonReader json, SceneFile& file) {
  if (json.has("iterations")) file.iterations = json.member("iterations").integer(between(0, 1e9));
  file.history_every = std::max<std::int64_t>(1, file.iterations / 10);
  if (json.has("history_every")) file.history_every = json.member("history_every").integer(between(1, 1e9));
  if (json.has("controls")) {
    const std::vector<std::string> names = parameter_map_names(file.scene.materials);
    for (const JsonReader& element : json.member("controls").elements(100)) {
      const std::string name = element.string();
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        element.fail("a parameter map: hits, last_hit, residence, MATERIAL.deposited or MATERIAL.final" +
                     did_you_mean(name, names));
      }
      if (!is_file_name(name)) element.fail("a parameter map whose material is named with " + file_name_text());
      file.controls.push_back(name);
    }
  }
  json.finish();
}

}  // namespace

double SceneFile::frame_time(std::int64_t iteration) const {
  const double per_iteration = scene.time_per_iteration > 0.0 ? scene.time_per_iteration : 1.0;
  return rounded(static_cast<double>(iteration) * per_iteration, 12);
}

SceneFile read_scene(const fs::path& path, const RunControl& control) {
  SceneAssets assets;
  return read_scene(path, load_json(path), assets, control);
}

SceneFile read_scene(const fs::path& path, const Json& as_written, SceneAssets& assets, const RunControl& control) {
  Json root = as_written;
  update_spelling(root, 1,
                  {{"behaviour", "behavior"}, {"alpha", "rate"}, {"makes", "products"}, {"uses", "reactants"}});
  SceneFile file;
  file.file = path;
  file.name = path.stem().string();
  JsonReader json(path.string(), root);
  json.expect_format("patinate.scene", 2);
  Scene& scene = file.scene;
  file.mm_per_unit = kMmPerLengthUnit[json.member("unit").choice(kLengthUnitNames)];
  scene.materials = read_names(json.member("materials"));
  SceneContext context;
  context.materials = scene.materials;
  context.mm_per_unit = file.mm_per_unit;
  context.add_input = [&file](const std::string& role, const fs::path& input) {
    file.inputs.emplace_back(role, input);
  };
  context.read_picture = [&file, &assets](const JsonReader& reader, int num_channels) {
    const fs::path picture = reader.path();
    file.inputs.emplace_back(reader.pointer(), picture);
    return asset(assets.mutex, assets.pictures, std::to_string(num_channels) + picture.string(),
                 [&] { return num_channels == 3 ? read_color(picture) : read_gray(picture); });
  };
  if (json.has("gravity")) {
    const std::vector<double> g = json.member("gravity").numbers(3);
    scene.gravity_mm_s2 = Vec3(g[0], g[1], g[2]) * file.mm_per_unit;
  }
  if (json.has("time")) read_time(json.member("time"), file);
  context.time_unit = file.time_unit;
  context.time_per_iteration = scene.time_per_iteration;
  if (json.has("seed")) scene.seed = static_cast<std::uint64_t>(json.member("seed").integer(at_least(0)));
  const AtlasMethod method = json.has("atlas") ? read_atlas(json.member("atlas"), scene) : AtlasMethod::Auto;
  scene.appearance = read_appearance(json, root, context);
  std::map<std::string, Preset> presets = library_presets(context);
  std::map<std::string, JsonReader> layered;  // presets
  for (auto& [name, member] : read_members(json, root, "presets")) {
    if (!member.has("layers")) {
      presets[name] = read_preset(member, context, false);
      continue;
    }
    layered.emplace(name, member.member("layers"));
    member.finish();
  }
  const std::map<std::string, Preset> of_one_layer = presets;
  for (const auto& [name, member] : layered) presets[name] = {};
  ObjectReader objects(file, context, presets, method, assets);
  const JsonReader object_list = json.member("objects");
  const std::vector<JsonReader> elements = object_list.elements(kMaxObjects);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const double n = static_cast<double>(elements.size());
    scene.objects.push_back(
        objects.read(elements[i], control.part(static_cast<double>(i) / n, static_cast<double>(i + 1) / n)));
  }
  if (json.has("maps")) read_maps(json.member("maps"), context, scene);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    JsonReader object = elements[i];
    if (const auto of_object = layers_of(object, layered)) {
      read_layers(*of_object, context, of_one_layer, scene, i);
    } else if (object.has("preset")) {
      check_pattern(object.member("preset"), scene.objects[i].preset, scene);
    }
    if (object.has("initial")) read_initial(object.member("initial"), context, scene, i);
  }
  if (json.has("weather")) scene.weather = read_weather(json.member("weather"), context, file.time_unit);
  context.weather = scene.weather.is_given;
  const JsonReader emitter_list = json.member("emitters");
  for (const JsonReader& emitter : emitter_list.elements(1000))
    scene.emitters.push_back(read_emitter(emitter, context));
  if (scene.emitters.empty()) emitter_list.fail("at least one emitter: without, nothing would happen");
  if (json.has("behavior")) scene.behavior = read_behavior(json.member("behavior"));
  scene.exchange.splat_mm = drop_width_mm(scene);
  scene.tracing = tracing_of_size(scene);
  if (json.has("tracing")) scene.tracing = read_tracing(json.member("tracing"), context, scene.tracing);
  if (json.has("exchange")) scene.exchange = read_exchange(json.member("exchange"), context, scene.exchange);
  if (json.has("time")) read_contact(json.member("time"), scene.exchange);
  if (json.has("rules")) {
    for (const JsonReader& rule : json.member("rules").elements(kMaxRules)) {
      scene.rules.push_back(read_limited_rule(rule, context, scene));
      if (const auto named = rule_path(rule)) file.inputs.emplace_back("rule " + scene.rules.back().name, *named);
    }
  }
  if (json.has("events")) read_events(json.member("events"), context, scene);
  if (json.has("run"))
    read_run(json.member("run"), file);
  else
    file.history_every = std::max<std::int64_t>(1, file.iterations / 10);
  json.finish();
  try {
    check_scene(scene);
    for (std::string& note : describe_meshes(make_scene_mesh(scene))) file.notes.push_back(std::move(note));
    for (std::string& note : scene_notes(file, context.mm_per_unit)) file.notes.push_back(std::move(note));
  } catch (const InvalidInput& e) {
    throw IoError(path.string(), e.what());
  }
  return file;
}

}  // namespace patinate::simulation
