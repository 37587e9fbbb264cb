#include "patinate/transfer/transfer_io.h"

#include <algorithm>
#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/geometry/mesh_key.h"
#include "libcommon/history/footprint.h"
#include "libcommon/image/image_rows.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "transfer/files/flow_io.h"
#include "transfer/files/transfer_files.h"
#include "transfer/synthesis/open_options.h"

namespace patinate::transfer {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 5> kTileRuleNames{"square", "udim", "material", "node", "surface"};
constexpr const char* kTilePlace = "<UDIM>";  ///< In file names, for the tile's name.
constexpr const char* kSourceMaskFile = "source_mask.png";

UvLayoutRule rule_of(const TransferTask& task) { return task.atlas ? task.atlas->rule : UvLayoutRule::Square; }

/// A file's name, with a place for the tile's name when there are tiles.
std::string tiled_name(const std::string& stem, UvLayoutRule rule) {
  return stem + (rule == UvLayoutRule::Square ? "" : std::string(".") + kTilePlace) + ".exr";
}

std::string control_file(const TransferTask& task, std::size_t index) {
  return tiled_name(task.input.controls.size() == 1 ? "control" : "control." + task.input.controls[index].source,
                    rule_of(task));
}

void write_tile(const fs::path& file, const Sheet& sheet, int tile, const std::vector<std::string>& channels,
                const FillStrip& fill, const RunControl& run) {
  constexpr int kLeastRows = 4 * kExrChunkRows, kMostRows = 32 * kExrChunkRows;
  const int threads = thread_count(run), strip_rows = std::clamp(2 * threads * kExrChunkRows, kLeastRows, kMostRows),
            num_channels = static_cast<int>(channels.size());
  const RunControl silent = run.silent();
  ImageRowWriter writer(file, sheet.tile_width, sheet.tile_height,
                        {.channels = channels, .depth = ExrDepth::Float, .num_threads = threads});
  for (int y = 0; y < sheet.tile_height; y += strip_rows) {
    ImageF strip(sheet.tile_width, std::min(strip_rows, sheet.tile_height - y), num_channels);
    parallel_for(strip.height(), kExrChunkRows, silent, [&](std::int64_t begin, std::int64_t end) {
      ImageF part(sheet.tile_width, static_cast<int>(end - begin), num_channels);
      fill(sheet.first_x(tile), sheet.first_y(tile) + y + static_cast<int>(begin), part);
      std::copy(part.values().begin(), part.values().end(), strip.row(static_cast<int>(begin)).data());
    });
    writer.write(strip.values());
  }
  writer.finish();
}

}  // namespace

double footprint_px(const TexelMap& map, double pixel_mm, Footprint footprint) {
  const double pixels = map.median_texel_size_mm() / pixel_mm;
  if (footprint == Footprint::Pixel || pixels <= kLeastFootprint_px) return 1.0;
  return std::min(kLargestFootprint_px, std::round(100.0 * pixels) / 100.0);
}

Json energy_json(const EnergyReport& e) {
  return {{"energy", e.energy},
          {"coherence", e.coherence},
          {"control_mismatch", e.control_mismatch},
          {"control_error_mean", e.control_error_mean},
          {"control_error_p95", e.control_error_p95},
          {"control_error_quarters", e.control_error_quarters},
          {"coherent_share", e.coherent_share},
          {"used_share", e.used_share}};
}

namespace {

Json tiles_json(const TransferTask& task) {
  Json tiles = Json::array();
  for (const std::string& name : task.atlas->tile_names()) {
    Json controls = Json::array();
    for (std::size_t i = 0; i < task.input.controls.size(); ++i)
      controls.push_back(tile_path(control_file(task, i), name).string());
    tiles.push_back({{"name", name}, {"coordinates", "coordinates." + name + ".exr"}, {"controls", controls}});
  }
  return tiles;
}

Json controls_json(const TransferTask& task) {
  Json controls = Json::array();
  for (std::size_t i = 0; i < task.input.controls.size(); ++i) {
    const TransferControl& c = task.input.controls[i];
    controls.push_back({{"source", c.source},
                        {"destination", c.destination},
                        {"weight", c.weight},
                        {"mapping", kControlMappingNames[static_cast<std::size_t>(c.mapping)]},
                        {"destination_range", {c.range.low, c.range.high}},
                        {"destination_unit", c.range.unit},
                        {"file", control_file(task, i)}});
  }
  return controls;
}

Json structure_json(const StructureFacts& s) {
  return {{"kind", kStructureKindNames[static_cast<std::size_t>(s.kind)]},
          {"share", s.share},
          {"scale_px", s.scale_px},
          {"contrast_lab", s.contrast_lab}};
}

StructureFacts read_structure(JsonReader json) {
  StructureFacts s;
  s.kind = static_cast<StructureKind>(json.member("kind").choice(kStructureKindNames));
  s.share = json.member("share").number(between(0, 1));
  s.scale_px = json.member("scale_px").number(above(0));
  s.contrast_lab = json.member("contrast_lab").number(above(0));
  json.finish();
  return s;
}

EnergyReport read_energy(JsonReader json) {
  EnergyReport e;
  e.energy = json.member("energy").number();
  e.coherence = json.member("coherence").number();
  e.control_mismatch = json.member("control_mismatch").number();
  e.control_error_mean = json.member("control_error_mean").number();
  e.control_error_p95 = json.member("control_error_p95").number();
  if (json.has("control_error_quarters")) {  // Missing in earlier transfers.
    const JsonReader quarters = json.member("control_error_quarters");
    const std::vector<JsonReader> values = quarters.elements(e.control_error_quarters.size());
    if (values.size() != e.control_error_quarters.size()) quarters.fail("4 numbers");
    for (std::size_t q = 0; q < values.size(); ++q) e.control_error_quarters[q] = values[q].number();
  }
  e.coherent_share = json.member("coherent_share").number();
  e.used_share = json.member("used_share").number();
  return e;
}

/// What says how the energy is measured. Options that only the search knows change from version to version and are not
/// looked at.
TransferOptions read_measure(JsonReader json) {
  TransferOptions o;
  o.coherence_share = 0.65;
  o.neighborhood_radius_px = 3;
  o.appearance.structure = json.has("structure") ? json.member("structure").number(between(0, 10)) : 0.0;
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

RecordedControl read_control(JsonReader& json) {
  RecordedControl c;
  c.source = json.member("source").string();
  c.destination = json.member("destination").string();
  c.weight = json.member("weight").number(above(0));
  c.mapping = static_cast<ControlMapping>(json.member("mapping").choice(kControlMappingNames));
  std::vector<double> range;
  for (JsonReader& end : json.member("destination_range").elements(2)) range.push_back(end.number());
  if (range.size() != 2) json.member("destination_range").fail("two numbers");
  c.range = {range[0], range[1], json.member("destination_unit").string()};
  c.file = json.member("file").path();
  json.finish();
  return c;
}

/// `atlas` is missing in transfers of earlier versions, which have one square.
void read_tiles(JsonReader& reader, TransferManifest& manifest) {
  if (reader.has("atlas")) {
    JsonReader atlas = reader.member("atlas");
    constexpr std::array<std::string_view, 2> kUvs{"file", "unwrapped"};
    manifest.is_unwrapped = atlas.member("uvs").choice(kUvs) == 1;
    manifest.tile_rule = static_cast<UvLayoutRule>(atlas.member("tiles").choice(kTileRuleNames));
    atlas.finish();
  }
  if (manifest.tile_rule == UvLayoutRule::Square) {
    manifest.tiles.push_back({"", reader.member("coordinates").path()});
    return;
  }
  const JsonReader list = reader.member("tiles");
  for (JsonReader& tile : list.elements(kMaxTiles)) {
    const JsonReader name = tile.member("name");
    if (!is_file_name(name.string())) name.fail("a name of " + file_name_text());
    manifest.tiles.push_back({name.string(), tile.member("coordinates").path()});
    (void)tile.member("controls");
    tile.finish();
  }
  if (manifest.tiles.empty()) list.fail("at least one tile");
  if (manifest.width != manifest.height) reader.member("height").fail("the width: tiles are square");
}

}  // namespace

Sheet TransferManifest::sheet() const {
  std::vector<std::string> names;
  for (const TransferTile& tile : tiles) names.push_back(tile.name);
  if (names.size() > 1) return make_sheet(std::move(names), width, Sheet::kMaxPartTexels);
  return {.tile_width = width, .tile_height = height, .columns = 1, .names = std::move(names)};
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

/// x and y in pixels; -1 for none.
void put_place(const SourcePlace& place, int source_width, float* xy) {
  constexpr float kStep = 1.0f / 256.0f;
  const std::int32_t column = place.pixel % source_width, line = place.pixel / source_width;
  xy[0] = place.pixel < 0 ? -1.0f : static_cast<float>(column) + kStep * static_cast<float>(place.beside_x);
  xy[1] = place.pixel < 0 ? -1.0f : static_cast<float>(line) + kStep * static_cast<float>(place.beside_y);
}

}  // namespace

ImageF coordinate_image(const TransferResult& result, int width, int height, int source_width) {
  ImageF image(width, height, 2);
  for (TexelId t = 0; t < image.num_pixels(); ++t) put_place(result.place(t), source_width, image.data() + 2 * t);
  return image;
}

namespace {

/// As coordinate_image(), of a part of the atlas. @param strip  Its first texel is (x, y); its first two channels are
/// set.
void put_coordinates(ImageF& strip, int x, int y, const std::function<SourcePlace(TexelId t)>& place_of, int width,
                     int source_width) {
  for (int row = 0; row < strip.height(); ++row) {
    for (int column = 0; column < strip.width(); ++column) {
      put_place(place_of(TexelId{y + row} * width + x + column), source_width, strip.pixel(column, row).data());
    }
  }
}

/// The last channel: the history of a library that each pixel belongs to.
void put_index(ImageF& strip, const std::vector<LibraryPart>& library) {
  for (int y = 0; y < strip.height(); ++y) {
    for (int x = 0; x < strip.width(); ++x) {
      const auto after =
          std::upper_bound(library.begin(), library.end(), strip.at(x, y),
                           [](float column, const LibraryPart& part) { return column < static_cast<float>(part.x); });
      strip.at(x, y, strip.channels() - 1) =
          static_cast<float>(after - library.begin() - 1);  // -1 lies before the first.
    }
  }
}

}  // namespace

fs::path control_tile_file(const TransferTask& task, std::size_t control, int tile) {
  return tile_path(control_file(task, control), task.input.map->sheet().names[static_cast<std::size_t>(tile)]);
}

fs::path coordinate_tile_file(const TransferTask& task, int tile) {
  return tile_path(tiled_name("coordinates", rule_of(task)),
                   task.input.map->sheet().names[static_cast<std::size_t>(tile)]);
}

void write_control_tile(const fs::path& folder, const TransferTask& task, std::size_t control, int tile,
                        const FillStrip& fill, const RunControl& run) {
  write_tile(folder / control_tile_file(task, control, tile), task.input.map->sheet(), tile, {"Y"}, fill, run);
}

void write_surface_files(const fs::path& folder, const TransferTask& task) {
  write_obj(folder / "mesh.obj", task.atlas ? task.atlas->mesh : task.input.map->mesh());
  if (!task.input.source_mask.empty()) write_codes(folder / kSourceMaskFile, task.input.source_mask);
}

void write_coordinate_tile(const fs::path& folder, const TransferTask& task, int tile, const TexelMap& map,
                           const std::function<SourcePlace(TexelId t)>& place_of, const RunControl& run) {
  const HistoryFacts& history = task.history->facts();
  const std::vector<LibraryPart>& parts = history.parts;
  std::vector<std::string> channels{kCoordinateChannels[0], kCoordinateChannels[1]};
  if (task.input.frames) channels.insert(channels.end(), {kPatchChannels[0], kPatchChannels[1]});
  if (!parts.empty()) channels.emplace_back(kIndexChannel);
  const auto fill = [&](int x, int y, ImageF& strip) {
    put_coordinates(strip, x, y, place_of, map.width(), history.width);
    if (task.input.frames) put_patch(strip, x, y, map, *task.input.frames, place_of);
    if (!parts.empty()) put_index(strip, parts);
  };
  write_tile(folder / coordinate_tile_file(task, tile), map.sheet(), tile, channels, fill, run);
}

void write_transfer_files(const fs::path& folder, const TransferTask& task, const TransferResult& result,
                          const RunControl& run) {
  for (int tile = 0; tile < task.input.map->sheet().num_tiles(); ++tile) {
    for (std::size_t i = 0; i < task.input.controls.size(); ++i) {
      const auto fill = [&](int x, int y, ImageF& strip) {
        for (int row = 0; row < strip.height(); ++row)
          std::copy_n(&task.input.controls[i].values.at(x, y + row), strip.width(), strip.row(row).begin());
      };
      write_control_tile(folder, task, i, tile, fill, run);
    }
    write_coordinate_tile(
        folder, task, tile, *task.input.map, [&](TexelId t) { return result.place(t); }, run);
  }
  write_surface_files(folder, task);
}

void write_transfer_manifest(const fs::path& folder, const fs::path& final_folder, const TransferTask& task,
                             const TransferResult& result, const std::string& key) {
  const HistoryReader& history = *task.history;
  Json options = Json::object();
  for (const auto& [name, value] : option_values(result.used)) {
    const std::optional<double> number = parse_number(value);
    const bool is_integer = number && value.find_first_of(".e") == std::string::npos;
    options[name] = is_integer ? Json(static_cast<std::int64_t>(*number)) : number ? Json(*number) : Json(value);
  }
  const fs::path place = fs::canonical(history.folder());
  const fs::path history_path =
      task.is_history_installed ? place : fs::relative(place, fs::weakly_canonical(fs::absolute(final_folder)));
  Json json;
  json["format"] = "patinate.transfer";
  json["version"] = 1;
  json["history"] = {{"path", history_path.string()},
                     {"key", history_content_key(history)},
                     {"name", history.manifest().name},
                     {"width", history.manifest().width},
                     {"height", history.manifest().height}};
  json["mesh"] = {{"file", "mesh.obj"},
                  {"made_from", task.mesh_name},
                  {"key", mesh_content_key(task.input.map->mesh())},
                  {"unit", task.unit ? Json(*task.unit) : Json(nullptr)},
                  {"mm_per_mesh_unit", task.mm_per_mesh_unit}};
  json["width"] = task.input.map->sheet().tile_width;
  json["height"] = task.input.map->sheet().tile_height;
  json["atlas"] = {{"uvs", task.atlas && task.atlas->is_unwrapped ? "unwrapped" : "file"},
                   {"tiles", kTileRuleNames[static_cast<std::size_t>(rule_of(task))]}};
  json["covered_texels"] = task.input.map->num_covered();
  json["texel_size_mm"] = task.input.texel_size_mm;
  json["footprint_px"] = footprint_px(*task.input.map, task.input.texel_size_mm, task.options.footprint);
  json["flow"] = task.flow;
  if (rule_of(task) == UvLayoutRule::Square) {
    json["coordinates"] = "coordinates.exr";
  } else {
    json["tiles"] = tiles_json(task);
  }
  json["subpixel"] = keeps_fractions(result.used, history.facts());
  if (!task.input.source_mask.empty()) json["source_mask"] = kSourceMaskFile;
  json["controls"] = controls_json(task);
  json["options"] = options;
  json["seed"] = task.options.seed;
  json["energy"] = energy_json(result.energy);
  json["explained_variance"] = result.explained_variance;
  if (result.structure) json["structure"] = structure_json(*result.structure);
  if (result.refused_line_share > 0.0) json["refused_line_share"] = result.refused_line_share;
  json["key"] = key;
  save_json(folder / "transfer.json", json);
}

TransferManifest read_transfer_manifest(const fs::path& path) {
  const fs::path folder = manifest_folder(path, "transfer.json");
  if (!fs::is_directory(folder)) throw IoError(path.string(), "is no transfer folder");
  const fs::path file = folder / "transfer.json";
  const Json json = load_json(file);
  JsonReader reader(file.string(), json);
  reader.expect_format("patinate.transfer", 1);
  TransferManifest manifest;
  JsonReader history = reader.member("history");
  manifest.history = history.member("path").path().lexically_normal();
  manifest.history_key = history.member("key").string();
  manifest.history_name = history.member("name").string();
  for (const char* known : {"width", "height"}) (void)history.member(known);
  history.finish();
  JsonReader mesh = reader.member("mesh");
  manifest.mesh = mesh.member("file").path();
  manifest.mm_per_mesh_unit = mesh.member("mm_per_mesh_unit").number(above(0));
  if (const JsonReader unit = mesh.member("unit"); !unit.is_null()) manifest.unit = unit.string();
  for (const char* known : {"made_from", "key"}) (void)mesh.member(known);
  mesh.finish();
  manifest.width = static_cast<int>(reader.member("width").integer(between(1, 65536)));
  manifest.height = static_cast<int>(reader.member("height").integer(between(1, 65536)));
  read_tiles(reader, manifest);
  manifest.is_subpixel = reader.member("subpixel").boolean();
  if (reader.has("source_mask")) manifest.source_mask = reader.member("source_mask").path();
  manifest.texel_size_mm = reader.member("texel_size_mm").number(between(kLeastTexel_mm, kLargestTexel_mm));
  if (reader.has("footprint_px"))
    manifest.footprint_px = reader.member("footprint_px").number(between(1, kLargestFootprint_px));
  const JsonReader controls = reader.member("controls");
  for (JsonReader& c : controls.elements(64)) manifest.controls.push_back(read_control(c));
  manifest.energy = read_energy(reader.member("energy"));
  if (reader.has("structure")) manifest.structure = read_structure(reader.member("structure"));
  if (reader.has("refused_line_share"))
    manifest.refused_line_share = reader.member("refused_line_share").number(between(0, 1));
  manifest.measured_with = read_measure(reader.member("options"));
  manifest.key = reader.member("key").string();
  for (const char* known : {"covered_texels", "seed", "explained_variance"}) (void)reader.member(known);
  if (reader.has("flow")) manifest.flow = reader.member("flow").string();  // Missing in earlier transfers: uv.
  reader.finish();
  return manifest;
}

}  // namespace patinate::transfer
