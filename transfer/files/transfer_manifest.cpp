// transfer.json.
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/document/document.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/geometry/mesh_key.h"
#include "libcommon/history/footprint.h"
#include "patinate/core/json.h"
#include "transfer/files/transfer_edits.h"
#include "transfer/files/transfer_files.h"
#include "transfer/synthesis/open_options.h"

namespace patinate::transfer {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 5> kTileRuleNames{"square", "udim", "material", "node", "surface"};

}  // namespace

double footprint_px(const TexelMap& map, double pixel_mm, Footprint footprint) {
  const double pixels = map.median_texel_size_mm() / pixel_mm;
  if (footprint == Footprint::Pixel || pixels <= kMinFootprint_px) return 1.0;
  return std::min(kLargestFootprint_px, std::round(100.0 * pixels) / 100.0);
}

void describe(DocumentVisitor& v, EnergyReport& e) {
  v.member({"energy", "Mean over texels of a C + (1 - a) K.", at_least(0)}, e.energy);
  v.member({"coherence", "C.", at_least(0)}, e.coherence);
  v.member({"control_mismatch", "K.", at_least(0)}, e.control_mismatch);
  v.member({"control_error_mean", "Of the first control.", at_least(0)}, e.control_error_mean);
  v.member({"control_error_p95", "Its 95th percentile.", at_least(0)}, e.control_error_p95);
  v.member({"control_error_quarters",
            "The mean by quarters of the texels, those that ask for the lowest values first. Missing in earlier "
            "transfers.",
            between(0, 1), Presence::Optional},
           e.control_error_quarters);
  v.member({"coherent_share", "Adjacent texels that are adjacent in the source.", between(0, 1)}, e.coherent_share);
  v.member({"used_share", "Source pixels that appear.", between(0, 1)}, e.used_share);
}

Json energy_json(const EnergyReport& energy) {
  EnergyReport written = energy;
  return object_json(described(written));
}

void describe(DocumentVisitor& v, StructureFacts& s) {
  v.choice({"kind"}, s.kind, kStructureKindNames);
  v.member({"share", "Of the source's pixels: on lines, or of the rarer material.", between(0, 1)}, s.share);
  v.member({"scale_px",
            "About half of the largest cell between lines, or of the largest region, pixels of the history.", above(0)},
           s.scale_px);
  v.member(
      {"contrast_lab",
       "Lightness by which the faintest line differs from what surrounds it, or the materials from each other, L*.",
       above(0)},
      s.contrast_lab);
}

namespace {

constexpr std::array<std::string_view, 2> kUvNames{"file", "unwrapped"};

constexpr DocumentKind kTransferDocument{
    .format = "patinate.transfer",
    .title = "patinate transfer",
    .about = "transfer.json: where each texel of a mesh's atlas takes its color from, at all times."};

/// Options by which the energy is measured. Options that only the search knows change from version to version and are
/// not looked at.
TransferOptions read_measure(JsonReader json) {
  TransferOptions o;
  o.coherence_share = 0.65;
  o.neighborhood_radius_px = 3;
  o.appearance.structure = json.has("structure") ? json.member("structure").number(between(0, 10)) : 0.0;
  if (json.has("quality"))
    o.quality = static_cast<TransferQuality>(json.member("quality").choice(kTransferQualityNames));
  if (json.has("structure_map")) o.appearance.structure_map = json.member("structure_map").string();
  const auto put = [&](const char* name, int& value, const Range& range) {
    if (json.has(name)) value = static_cast<int>(json.member(name).integer(range));
  };
  o.turning = json.has("turning") ? static_cast<PieceTurning>(json.member("turning").choice(kPieceTurningNames))
                                  : PieceTurning::Never;
  if (json.has("coherence")) o.coherence_share = json.member("coherence").number(between(0, 1));
  put("neighborhood", o.neighborhood_radius_px, between(1, 5));
  put("spatial_radius", o.appearance.spatial_radius_px, between(0, 3));
  put("max_frames", o.appearance.max_frames, between(2, 128));
  put("appearance_samples", o.appearance.num_samples, between(64, 65536));
  return o;
}

Json used_options(const TransferOptions& used) {
  Json options = Json::object();
  for (const auto& [name, value] : option_values(used)) {
    const std::optional<double> number = parse_number(value);
    const bool is_integer = number && value.find_first_of(".e") == std::string::npos;
    options[name] = is_integer ? Json(static_cast<std::int64_t>(*number)) : number ? Json(*number) : Json(value);
  }
  return options;
}

}  // namespace

void describe(DocumentVisitor& v, TransferTile& tile) {
  v.member({.name = "name", .help = "1001, or a material.", .rule = &file_name_rule()}, tile.name);
  v.member({"coordinates", "As above."}, tile.coordinates);
  v.member({"controls"}, tile.controls);
}

void describe(DocumentVisitor& v, RecordedControl& c) {
  v.member({"source", "Control of the history."}, c.source);
  v.member({"destination", "Map, kind or expression on the mesh."}, c.destination);
  v.member({"weight", "Of several controls.", above(0)}, c.weight);
  v.choice({"mapping"}, c.mapping, kControlMappingNames);
  std::array<double, 2> range{c.range.low, c.range.high};
  v.member({"destination_range"}, range);
  c.range.low = range[0], c.range.high = range[1];
  v.member({"destination_unit", "Unit of that range."}, c.range.unit);
  v.member({"file", "The map that was used."}, c.file);
}

namespace {

void describe_history(DocumentVisitor& v, TransferManifest& m) {
  v.member({"path", "The history."}, m.history);
  v.member({"key", "Content key: of all that this was made from."}, m.history_key);
  v.member({"name", "Its name."}, m.history_name);
  v.member({"width", "px", at_least(1), Presence::Optional}, m.history_width);
  v.member({"height", "px", at_least(1), Presence::Optional}, m.history_height);
}

void describe_mesh(DocumentVisitor& v, TransferManifest& m) {
  v.member({"file", "The mesh with the UVs that were used, in mm."}, m.mesh);
  v.member({"made_from", "Name of the file that was given.", {}, Presence::Optional}, m.made_from);
  v.member({"key", "Content key: of all that this was made from.", {}, Presence::Optional}, m.mesh_key);
  v.member(or_null("unit", "Unit of that file; null when nobody said."), m.unit);
  v.member({"mm_per_mesh_unit", "mm", above(0)}, m.mm_per_mesh_unit);
}

/// One square has `coordinates`, several have `tiles`.
void describe_places(DocumentVisitor& v, TransferManifest& m) {
  const bool is_square = m.tile_rule == UvLayoutRule::Square;
  const Presence presence = v.wants_all() ? Presence::Optional : Presence::Required;
  v.one_of({"coordinates", "tiles"});
  if (is_square || v.wants_all()) {
    if (m.tiles.empty()) m.tiles.emplace_back();
    v.member({"coordinates",
              "Float EXR, channels source.x and source.y, of a library also source.index; -1 outside the charts.",
              {},
              presence},
             m.tiles.front().coordinates);
  }
  if (is_square && !v.wants_all()) return;
  v.member({.name = "tiles",
            .help = "Instead of `coordinates`, when there are several.",
            .presence = presence,
            .min_size = 1,
            .max_size = kMaxTiles},
           m.tiles);
  v.require("height", v.wants_all() || m.width == m.height, "the width: tiles are square");
}

}  // namespace

void describe(DocumentVisitor& v, TransferManifest& m) {
  v.object({"history"}, true, [&] { describe_history(v, m); });
  v.object({"mesh"}, true, [&] { describe_mesh(v, m); });
  v.member({"width", "Texels of a tile.", between(1, 65536)}, m.width);
  v.member({"height", "Texels of a tile.", between(1, 65536)}, m.height);
  v.object({"atlas", "Where UVs come from. Missing in earlier transfers: one square.", {}, Presence::Optional}, true,
           [&] {
             auto uvs = static_cast<int>(m.is_unwrapped);
             v.choice({"uvs"}, uvs, kUvNames);
             m.is_unwrapped = uvs == 1;
             v.choice({"tiles", "How UVs make tiles."}, m.tile_rule, kTileRuleNames);
           });
  v.member({"covered_texels", "Texels that a triangle covers.", at_least(0), Presence::Optional}, m.covered_texels);
  v.member({"texel_size_mm", "Surface length of a pixel of the history.", between(kMinTexel_mm, kLargestTexel_mm)},
           m.texel_size_mm);
  v.member({"footprint_px",
            "Pixels along the side of what a texel covers: above 1.25 lookups show means over so much of the history. "
            "Missing in earlier transfers: 1.",
            between(1, kLargestFootprint_px), Presence::Optional},
           m.footprint_px);
  v.member({"flow",
            "Which way the history lies on the surface: gravity, curvature, uv, or the name of a file of curves. "
            "Missing in earlier transfers: uv.",
            {},
            Presence::Optional},
           m.flow);
  describe_places(v, m);
  v.member({"subpixel", "Coordinates may lie between pixels; false: all are whole numbers."}, m.is_subpixel);
  v.member({"source_mask",
            "8 bit, of the history's size; what is 0 was not to be copied. Missing: only the history's own mask "
            "counted.",
            {},
            Presence::IfSet},
           m.source_mask);
  v.member({"edits", "Edits that were applied afterwards. Missing: none.", {}, Presence::IfSet}, m.edits);
  v.member({.name = "controls",
            .help = "Controls of the history and those of the mesh that they are matched to.",
            .max_size = 64},
           m.controls);
  v.any_object(
      {"options", "Options of `patinate transfer` that were in force."},
      [&](const JsonReader& json) { m.measured_with = read_measure(json); },
      [&](Json& json) { json = used_options(m.measured_with); });
  v.member({"seed", "Of all random numbers.", at_least(0), Presence::Optional}, m.seed);
  v.member({"energy"}, m.energy);
  v.member({"explained_variance",
            "Share of the history's colors that the compared components hold.",
            {},
            Presence::Optional},
           m.explained_variance);
  v.member({"structure",
            "Lines, or regions of two materials, that were found in the source and kept whole. Missing: there are "
            "none, or none were looked for.",
            {},
            Presence::IfSet},
           m.structure);
  std::optional<double> refused = m.refused_line_share > 0.0 ? std::optional(m.refused_line_share) : std::nullopt;
  v.member({"refused_line_share",
            "Share of the source that looks like lines and is too much to be some; missing: there is none, or lines "
            "were found.",
            between(0, 1), Presence::IfSet},
           refused);
  m.refused_line_share = refused.value_or(0.0);
  v.member({"key", "Content key: of all that this was made from."}, m.key);
}

std::string history_content_key(const HistoryReader& history) {
  if (!history.manifest().key.empty()) return history.manifest().key;
  ContentHash hash;
  hash.add_file(history.folder() / "history.json");
  const auto add = [&](const std::optional<fs::path>& file) {
    if (file) hash.add_file(history.folder() / *file);
  };
  for (const HistoryFrame& frame : history.manifest().frames) {
    add(frame.file);
    add(frame.mask);
    for (const HistoryImage& extra : frame.extras) add(extra.file);
    add(frame.amounts);
  }
  for (const ControlParameter& control : history.manifest().controls) {
    add(control.file);
    add(control.deviation);
  }
  for (const HistoryMap& map : history.manifest().maps) add(map.file);
  if (history.manifest().mask) hash.add_file(history.folder() / *history.manifest().mask);
  return hash.hex();
}

namespace {

std::vector<TransferTile> written_tiles(const TransferTask& task) {
  std::vector<TransferTile> tiles;
  if (rule_of(task) == UvLayoutRule::Square) return {{.name = "", .coordinates = "coordinates.exr"}};
  for (const std::string& name : task.atlas->tile_names()) {
    TransferTile& tile = tiles.emplace_back(TransferTile{.name = name, .coordinates = "coordinates." + name + ".exr"});
    for (std::size_t i = 0; i < task.input.controls.size(); ++i)
      tile.controls.push_back(tile_path(control_file(task, i), name).string());
  }
  return tiles;
}

std::vector<RecordedControl> written_controls(const TransferTask& task) {
  std::vector<RecordedControl> controls;
  for (std::size_t i = 0; i < task.input.controls.size(); ++i) {
    const TransferControl& c = task.input.controls[i];
    controls.push_back({.source = c.source,
                        .destination = c.destination,
                        .weight = c.weight,
                        .mapping = c.mapping,
                        .range = c.range,
                        .file = control_file(task, i)});
  }
  return controls;
}

}  // namespace

void write_transfer_manifest(const fs::path& folder, const fs::path& final_folder, const TransferTask& task,
                             const TransferResult& result, const std::string& key) {
  const HistoryReader& history = *task.history;
  const fs::path place = fs::canonical(history.folder());
  const bool has_mask = !task.input.source_mask.empty();
  TransferManifest m{.history = task.is_history_installed
                                    ? place
                                    : fs::relative(place, fs::weakly_canonical(fs::absolute(final_folder))),
                     .history_name = history.manifest().name,
                     .history_key = history_content_key(history),
                     .history_width = history.manifest().width,
                     .history_height = history.manifest().height,
                     .mesh = "mesh.obj",
                     .made_from = task.mesh_name,
                     .mesh_key = mesh_content_key(task.input.map->mesh()),
                     .tile_rule = rule_of(task),
                     .tiles = written_tiles(task),
                     .is_unwrapped = task.atlas && task.atlas->is_unwrapped,
                     .width = task.input.map->sheet().tile_width,
                     .height = task.input.map->sheet().tile_height,
                     .texel_size_mm = task.input.texel_size_mm,
                     .footprint_px = footprint_px(*task.input.map, task.input.texel_size_mm, task.options.footprint),
                     .is_subpixel = keeps_fractions(result.used, history.facts()),
                     .flow = task.flow,
                     .controls = written_controls(task),
                     .source_mask = has_mask ? std::optional<fs::path>(kSourceMaskFile) : std::nullopt,
                     .edits = std::nullopt,
                     .unit = task.unit,
                     .mm_per_mesh_unit = task.mm_per_mesh_unit,
                     .energy = result.energy,
                     .structure = result.structure,
                     .refused_line_share = result.refused_line_share,
                     .measured_with = result.used,
                     .covered_texels = task.input.map->num_covered(),
                     .seed = task.options.seed,
                     .explained_variance = result.explained_variance,
                     .key = key};
  save_json(folder / "transfer.json", document_json(kTransferDocument, described(m)));
}

TransferManifest read_transfer_manifest(const fs::path& path) {
  const fs::path folder = manifest_folder(path, "transfer.json");
  if (!fs::is_directory(folder)) throw IoError(path.string(), "is no transfer folder");
  TransferManifest m;
  read_document(kTransferDocument, folder / "transfer.json", described(m));
  m.history = (folder / m.history).lexically_normal();
  m.mesh = folder / m.mesh;
  for (TransferTile& tile : m.tiles) tile.coordinates = folder / tile.coordinates;
  if (m.source_mask) m.source_mask = folder / *m.source_mask;
  if (m.edits) m.edits = folder / *m.edits;
  for (RecordedControl& c : m.controls) c.file = folder / c.file;
  return m;
}

void rewrite_transfer_manifest(const fs::path& folder, const EnergyReport& energy) {
  Json json = load_json(folder / "transfer.json");
  json["energy"] = energy_json(energy);
  json["edits"] = kEditsFile;
  save_json(folder / "transfer.json", json);
}

Json transfer_schema() { return document_schema(kTransferDocument, described<TransferManifest>()); }

}  // namespace patinate::transfer
