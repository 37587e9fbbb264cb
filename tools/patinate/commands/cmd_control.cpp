#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "app/controls/control_store.h"
#include "app/controls/scene_controls.h"
#include "app/mesh/mesh_source.h"
#include "app/request/output_file.h"
#include "app/request/usage_error.h"
#include "libcommon/controls/control_arguments.h"
#include "libcommon/controls/image_control.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_key.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/commands/declared_options.h"
#include "tools/patinate/commands/output_command.h"
#include "tools/patinate/commands/tile_files.h"

namespace patinate::cli {

namespace {

struct ControlCommandOptions {
  app::AtlasOptions atlas;
  ControlKindOptions kinds;
};
void describe(OptionVisitor& v, ControlCommandOptions& o) {
  describe(v, o.atlas);
  describe(v, o.kinds);
}

/// Everything that the map depends on.
std::string control_key(const std::string& text, const AtlasMesh& atlas_mm, ControlCommandOptions options) {
  const std::optional<ControlName> kind = single_kind(text);
  if (kind) options.kinds = named_options(*kind, options.kinds);
  ContentHash hash;
  hash.add("control " + std::to_string(kControlVersion)).add(kind ? kind->text : text);
  hash.add(mesh_content_key(atlas_mm.mesh));
  const std::vector<std::string> tiles = atlas_mm.tile_names();
  for (const std::string& name : tiles) hash.add(name);
  for (const auto& [name, value] : option_values(options)) hash.add(name).add(value);
  const ControlExpression expression(text, control_kind_names());
  const auto add_files = [&](const std::filesystem::path& path) {
    for (const auto& file : tile_map_files(path, tiles)) hash.add_file(file);
  };
  for (const ControlName& name : expression.names()) {
    if (name.is_file) add_files(name.text);
    if (name.is_file) continue;
    for (const auto& file : control_input_files(name.text, named_options(name, options.kinds))) add_files(file);
  }
  return hash.hex();
}

/// glTF is in meters by its standard; other files are taken as mm unless --unit says otherwise.
double mm_per_mesh_unit(const app::MeshSource& source) {
  return app::mm_per_unit(source.unit_or_none().value_or("mm"));
}

/// Where the mesh goes whose UVs were made for a map.
std::filesystem::path unwrapped_file(const std::filesystem::path& map_file) {
  return std::filesystem::path(map_file).replace_extension(".obj");
}

/// One of the maps that are asked for.
struct AskedMap {
  std::string kind;
  std::vector<std::filesystem::path> files;  ///< Files of its tiles.
  std::string key;

  /// The maps, and the mesh beside an unwrapped one.
  [[nodiscard]] std::vector<std::filesystem::path> outputs(const AtlasMesh& atlas) const {
    std::vector<std::filesystem::path> all = files;
    if (atlas.is_unwrapped) all.push_back(unwrapped_file(files.front()));
    return all;
  }
};

constexpr std::string_view kKindPlace = "<KIND>";

/// The map's file: of several each has its kind in its name. @throws UsageError
std::filesystem::path map_file(const std::filesystem::path& output, const std::string& kind, std::size_t num_kinds) {
  if (num_kinds == 1) return output;
  std::string name = output.filename().string();
  const std::size_t at = name.find(kKindPlace);
  if (at == std::string::npos)
    throw app::UsageError("-o: found `" + output.string() + "` for " + std::to_string(num_kinds) +
                          " kinds; expected a name with <KIND> in it, as bust_<KIND>.exr");
  const std::optional<ControlName> single = single_kind(kind);
  if (!single)
    throw app::UsageError("--kind: `" + kind +
                          "` has no name for <KIND>; an expression is made by a command of its own");
  return output.parent_path() / name.replace(at, kKindPlace.size(), single->text);
}

void require_each_once(std::vector<std::string> kinds) {
  for (std::string& kind : kinds) {
    if (const std::optional<ControlName> single = single_kind(kind)) kind = single->text;
  }
  std::sort(kinds.begin(), kinds.end());
  const auto twice = std::adjacent_find(kinds.begin(), kinds.end());
  if (twice != kinds.end()) throw app::UsageError("--kind: `" + *twice + "` is given twice");
}

/// Maps that are to be made; nothing when the command has no more to do.
std::optional<std::vector<std::size_t>> maps_to_make(CommandRun& run, const std::filesystem::path& output,
                                                     const AtlasMesh& atlas, const std::vector<AskedMap>& maps) {
  if (maps.size() == 1) {
    const std::optional<JobStatus> status = check_tile_files(run, maps[0].outputs(atlas), maps[0].key);
    if (!status) return std::nullopt;
    return *status == JobStatus::UpToDate ? std::vector<std::size_t>{} : std::vector<std::size_t>{0};
  }
  ContentHash all;
  std::vector<app::OutputPiece> pieces;
  for (const AskedMap& map : maps) {
    all.add(map.key);
    pieces.push_back({.files = map.outputs(atlas), .key = map.key});
  }
  return unfinished_pieces(run, output, all.hex(), pieces);
}

/// Writes a map, and where UVs were made the mesh that it belongs to. @returns what a report says of it.
Json write_map(CommandRun& run, const AskedMap& asked, const ControlMap& made, const TexelMap& map,
               const AtlasMesh& atlas, double mm_per_unit) {
  for (std::size_t i = 0; i < asked.files.size(); ++i) {
    write_scaled_exr(asked.files[i], cut_tile(made.values, map.sheet(), static_cast<int>(i)),
                     {made.low, made.high, made.unit}, asked.key);
  }
  Json more{{"range", {made.low, made.high}}, {"unit", made.unit}, {"covered", map.num_covered()}};
  if (atlas.is_unwrapped) {
    Mesh mesh = atlas.mesh;
    scale_mesh(mesh, 1.0 / mm_per_unit);
    const std::filesystem::path file = unwrapped_file(asked.files.front());
    write_obj(file, mesh, asked.key);
    run.note(file.string() + ": the mesh with the UVs that the map belongs to");
    more["mesh"] = file.string();
  }
  run.notes(made.notes);
  run.detail("0 stands for " + number_text(made.low) + ", 1 for " + number_text(made.high) + " " + made.unit);
  return more;
}

}  // namespace

int cmd_control(CommandRun& run) {
  app::MeshSource mesh_source;
  std::filesystem::path output;
  std::vector<std::string> kinds;
  ControlCommandOptions options;
  app::ControlStoreOptions store;
  declare_mesh(run.line, mesh_source);
  run.line.repeated(
      "kind", "KIND",
      "A kind with its arguments (see below), or an expression of kinds and of map files; several kinds make a map "
      "each",
      kinds);
  run.line.required();
  run.line.suggestions(control_kind_names());
  run.line.output("MAP.exr",
                  "Control map to make: float, channel Y, [0, 1]; for several kinds, a name with <KIND> in it", output);
  run.line.options(options.atlas);
  run.line.options(store);
  declare_kind_options(run.line, options.kinds);
  std::vector<std::pair<std::string, std::string>> listed;
  for (const ControlKind& k : control_kinds()) listed.emplace_back(k.name, k.brief);
  run.line.list("Kinds: the map is high at", listed);
  run.line.long_list("Arguments of kinds", kind_argument_rows());
  run.line.example("control bust.glb --kind accessibility -o crevices.exr");
  run.line.example("control bust.glb --kind \"facing(direction=0,1,0)\" -o dust.exr");
  run.line.example("control bust.glb --kind \"0.7*accessibility(scale=3) + 0.3*facing\" -o mix.exr");
  run.line.example("control bust.glb --kind facing --kind height -o \"bust_<KIND>.exr\"");
  if (!run.parse()) return 0;
  app::require_extension(output, {".exr"});
  require_each_once(kinds);
  for (const std::string& kind : kinds) {
    (void)ControlExpression(kind, control_kind_names());  // A typo is said before work starts.
    (void)map_file(output, kind, kinds.size());
    app::refuse_scene_maps(kind, mesh_source.path);
  }

  Mesh mesh = app::load_mesh(mesh_source, words_of(run));
  AtlasMesh atlas = app::make_atlas(mesh_source, std::move(mesh), options.atlas, run.control("atlas"));
  scale_mesh(atlas.mesh, mm_per_mesh_unit(mesh_source));
  std::vector<AskedMap> maps;
  for (const std::string& kind : kinds)
    maps.push_back({kind, tile_files(map_file(output, kind, kinds.size()), atlas.tile_names()),
                    control_key(kind, atlas, options)});
  const std::optional<std::vector<std::size_t>> todo = maps_to_make(run, output, atlas, maps);
  if (!todo) return 0;
  app::note_atlas(mesh_source, atlas, words_of(run));
  Json more = Json::object();
  if (!todo->empty()) {
    const RunControl control = run.control("control");
    const TexelMap map = app::make_texel_map(mesh_source, atlas, options.atlas.resolution, control.part(0.0, 0.2));
    const ControlCache cache = app::user_control_cache(store.cache);
    for (std::size_t k = 0; k < todo->size(); ++k) {
      const AskedMap& asked = maps[(*todo)[k]];
      const auto share = [&](std::size_t i) {
        return 0.2 + 0.8 * static_cast<double>(i) / static_cast<double>(todo->size());
      };
      const RunControl part = control.part(share(k), share(k + 1));
      const std::optional<ControlName> kind = single_kind(asked.kind);
      const ControlMap made =
          kind ? cached_control(kind->text, map, named_options(*kind, options.kinds), cache, part)
               : make_control_expression(asked.kind, map, options.kinds, part, control_source(cache));
      more = write_map(run, asked, made, map, atlas, mm_per_mesh_unit(mesh_source));
    }
  }
  const JobStatus status = todo->empty() ? JobStatus::UpToDate : JobStatus::Done;
  if (maps.size() == 1) {
    report_tile_files(run, status, output, maps.front().files, std::move(more));
    return 0;
  }
  Json files = Json::array();
  for (const AskedMap& asked : maps) {
    for (const auto& file : asked.files) files.push_back(Json{{"kind", asked.kind}, {"file", file.string()}});
  }
  run.report_output(status, output, Json{{"maps", files}});
  return 0;
}

}  // namespace patinate::cli
