#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/controls/control_expression.h"
#include "libcommon/controls/image_control.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_key.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tools/patinate/command_line/output_file.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/services/control_store.h"
#include "tools/patinate/services/mesh_source.h"
#include "tools/patinate/services/scene_controls.h"
#include "tools/patinate/services/tile_files.h"

namespace patinate::cli {

namespace {

struct ControlCommandOptions {
  AtlasOptions atlas;
  ControlKindOptions kinds;
};
void describe(OptionVisitor& v, ControlCommandOptions& o) {
  describe(v, o.atlas);
  describe(v, o.kinds);
}

bool is_kind(const std::string& kind) {
  const std::vector<std::string>& kinds = control_kind_names();
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

/// Everything that the map depends on.
std::string control_key(const std::string& kind, const AtlasMesh& atlas_mm, const ControlCommandOptions& options) {
  ContentHash hash;
  hash.add("control " + std::to_string(kControlVersion)).add(kind).add(mesh_content_key(atlas_mm.mesh));
  const std::vector<std::string> tiles = atlas_mm.tile_names();
  for (const std::string& name : tiles) hash.add(name);
  for (const auto& [name, value] : option_values(options)) hash.add(name).add(value);
  const auto add_files = [&](const std::filesystem::path& path) {
    for (const auto& file : tile_map_files(path, tiles)) hash.add_file(file);
  };
  if (is_kind(kind)) {
    for (const auto& file : control_input_files(kind, options.kinds)) add_files(file);
  } else {
    const ControlExpression expression(kind, control_kind_names());
    for (const ControlName& name : expression.names()) {
      if (name.is_file) add_files(name.text);
      if (name.is_file) continue;
      for (const auto& file : control_input_files(name.text, options.kinds)) add_files(file);
    }
  }
  return hash.hex();
}

/// glTF is in meters by its standard; other files are taken as mm unless --unit says otherwise.
double mm_per_mesh_unit(const MeshSource& source) { return mm_per_unit(source.unit_or_none().value_or("mm")); }

/// Where the mesh goes whose UVs were made for a map.
std::filesystem::path unwrapped_file(const std::filesystem::path& map_file) {
  return std::filesystem::path(map_file).replace_extension(".obj");
}

/// Whether the maps, and the mesh beside an unwrapped one, are to be made.
std::optional<JobStatus> check_outputs(CommandRun& run, const std::vector<std::filesystem::path>& files,
                                       const AtlasMesh& atlas, const std::string& key) {
  const std::optional<JobStatus> status = check_tile_files(run, files, key);
  if (!status || !atlas.is_unwrapped) return status;
  const std::filesystem::path mesh = unwrapped_file(files.front());
  const JobStatus mesh_status = check_output_file(mesh, read_obj_key(mesh), key, run.job_options());
  return *status == JobStatus::UpToDate ? mesh_status : *status;
}

}  // namespace

int cmd_control(CommandRun& run) {
  MeshSource mesh_source;
  std::filesystem::path output;
  std::string kind;
  ControlCommandOptions options;
  ControlStoreOptions store;
  declare_mesh(run.line, mesh_source);
  run.line.option("kind", "KIND", "A kind (see below), or an expression of kinds and of map files", kind);
  run.line.required();
  run.line.suggestions(control_kind_names());
  run.line.output("MAP.exr", "The control map to make, float, channel Y, [0, 1]", output);
  run.line.options(options);
  run.line.options(store);
  std::vector<std::pair<std::string, std::string>> kinds;
  for (const ControlKind& k : control_kinds()) kinds.emplace_back(k.name, k.brief);
  run.line.list("Kinds: the map is high at", kinds);
  run.line.example("control bust.glb --kind accessibility -o crevices.exr");
  run.line.example("control bust.glb --kind facing --direction 0,1,0 -o dust.exr");
  run.line.example("control bust.glb --kind \"0.7*accessibility + 0.3*facing\" -o mix.exr");
  if (!run.parse()) return 0;
  require_extension(output, {".exr"});
  (void)ControlExpression(kind, control_kind_names());  // A typo is said before work starts.
  refuse_scene_maps(kind, mesh_source.path);

  Mesh mesh = load_mesh(mesh_source, run);
  AtlasMesh atlas = make_atlas(mesh_source, std::move(mesh), options.atlas, run.control("atlas"));
  note_atlas(mesh_source, atlas, run);
  scale_mesh(atlas.mesh, mm_per_mesh_unit(mesh_source));
  const std::string key = control_key(kind, atlas, options);
  const std::vector<std::filesystem::path> files = tile_files(output, atlas.tile_names());
  const std::optional<JobStatus> status = check_outputs(run, files, atlas, key);
  if (!status) return 0;
  if (status == JobStatus::UpToDate) {
    report_tile_files(run, *status, output, files, Json::object());
    return 0;
  }
  const RunControl control = run.control("control");
  const TexelMap map = make_texel_map(mesh_source, atlas, options.atlas.resolution, control.part(0.0, 0.2));
  const ControlCache cache = user_control_cache(store.cache);
  const ControlMap result =
      is_kind(kind) ? cached_control(kind, map, options.kinds, cache, control.part(0.2, 1.0))
                    : make_control_expression(kind, map, options.kinds, control.part(0.2, 1.0), control_source(cache));
  for (std::size_t i = 0; i < files.size(); ++i) {
    write_scaled_exr(files[i], cut_tile(result.values, map.sheet(), static_cast<int>(i)),
                     {result.low, result.high, result.unit}, key);
  }
  if (atlas.is_unwrapped) {
    scale_mesh(atlas.mesh, 1.0 / mm_per_mesh_unit(mesh_source));
    write_obj(unwrapped_file(files.front()), atlas.mesh, key);
    run.note(unwrapped_file(files.front()).string() + ": the mesh with the UVs that the map belongs to");
  }
  for (const std::string& note : result.notes) run.note(note);
  run.detail("0 stands for " + number_text(result.low) + ", 1 for " + number_text(result.high) + " " + result.unit);
  Json more{{"range", {result.low, result.high}}, {"unit", result.unit}, {"covered", map.num_covered()}};
  if (atlas.is_unwrapped) more["mesh"] = unwrapped_file(files.front()).string();
  report_tile_files(run, *status, output, files, std::move(more));
  return 0;
}

}  // namespace patinate::cli
