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

constexpr const char* kTilePlace = "<UDIM>";  ///< In file names, for the tile's name.

/// A file's name, with a place for the tile's name when there are tiles.
std::string tiled_name(const std::string& stem, UvLayoutRule rule) {
  return stem + (rule == UvLayoutRule::Square ? "" : std::string(".") + kTilePlace) + ".exr";
}

}  // namespace

UvLayoutRule rule_of(const TransferTask& task) { return task.atlas ? task.atlas->rule : UvLayoutRule::Square; }

std::string control_file(const TransferTask& task, std::size_t index) {
  return tiled_name(task.input.controls.size() == 1 ? "control" : "control." + task.input.controls[index].source,
                    rule_of(task));
}

namespace {

/// Puts the part of the sheet that begins at (x, y) into a strip.
using FillStrip = std::function<void(int x, int y, ImageF& strip)>;
/// A few rows at a time: an atlas may be larger than what there is beside it. @param fill  Called by several threads.
void write_tile(const fs::path& file, const Sheet& sheet, int tile, const std::vector<std::string>& channels,
                const FillStrip& fill, const RunControl& run) {
  constexpr int kMinRows = 4 * kExrChunkRows, kMaxRows = 32 * kExrChunkRows;
  const int threads = thread_count(run), strip_rows = std::clamp(2 * threads * kExrChunkRows, kMinRows, kMaxRows),
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

Sheet TransferManifest::sheet() const {
  std::vector<std::string> names;
  for (const TransferTile& tile : tiles) names.push_back(tile.name);
  if (names.size() > 1) return make_sheet(std::move(names), width, Sheet::kMaxPartTexels);
  return {.tile_width = width, .tile_height = height, .columns = 1, .names = std::move(names)};
}

namespace {

/// x and y in pixels; -1 for none.
void put_place(const SourcePlace& place, int source_width, float* xy) {
  constexpr float kStep = 1.0f / 256.0f;  // Pixels a unit of PixelNeighbor's fractions.
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

/// Works as coordinate_image(), on a part of the atlas. @param strip  Its first texel is (x, y); its first two channels
/// are set.
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

/// @param place_of  Called by several threads.
void write_coordinates(const fs::path& file, const TransferTask& task, int tile,
                       const std::function<SourcePlace(TexelId t)>& place_of, const RunControl& run) {
  const TexelMap& map = *task.input.map;
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
  write_tile(file, map.sheet(), tile, channels, fill, run);
}

}  // namespace

void rewrite_coordinates(const TransferManifest& manifest, const EditedPlaces& edited, const RunControl& run) {
  const Sheet sheet = manifest.sheet();
  std::vector<std::string> channels{kCoordinateChannels[0], kCoordinateChannels[1]};
  if (edited.frames != nullptr) channels.insert(channels.end(), {kPatchChannels[0], kPatchChannels[1]});
  if (!edited.parts.empty()) channels.emplace_back(kIndexChannel);
  for (int tile = 0; tile < sheet.num_tiles(); ++tile) {
    ImageF values = read_channels(manifest.tiles[tile].coordinates, channels);
    ImageF one(1, 1, values.channels());
    for (const TexelId t : edited.texels) {
      const int x = static_cast<int>(t % edited.map.width()), y = static_cast<int>(t / edited.map.width());
      const int in_x = x - sheet.first_x(tile), in_y = y - sheet.first_y(tile);
      if (!values.contains(in_x, in_y)) continue;
      put_coordinates(one, x, y, edited.place_of, edited.map.width(), edited.source_width);
      if (edited.frames != nullptr) put_patch(one, x, y, edited.map, *edited.frames, edited.place_of);
      if (!edited.parts.empty()) put_index(one, edited.parts);
      std::copy(one.values().begin(), one.values().end(), values.pixel(in_x, in_y).begin());
    }
    ImageRowWriter writer(manifest.tiles[tile].coordinates, values.width(), values.height(),
                          {.channels = channels, .depth = ExrDepth::Float, .num_threads = thread_count(run)});
    writer.write(values.values());
    writer.finish();
  }
}

void write_transfer_files(const fs::path& folder, const TransferTask& task, const TransferResult& result,
                          const RunControl& run) {
  const Sheet& sheet = task.input.map->sheet();
  for (int tile = 0; tile < sheet.num_tiles(); ++tile) {
    for (std::size_t i = 0; i < task.input.controls.size(); ++i) {
      const auto fill = [&](int x, int y, ImageF& strip) {
        for (int row = 0; row < strip.height(); ++row)
          std::copy_n(&task.input.controls[i].values.at(x, y + row), strip.width(), strip.row(row).begin());
      };
      write_tile(folder / tile_path(control_file(task, i), sheet.names[tile]), sheet, tile, {"Y"}, fill, run);
    }
    const fs::path file = folder / tile_path(tiled_name("coordinates", rule_of(task)), sheet.names[tile]);
    write_coordinates(
        file, task, tile, [&](TexelId t) { return result.place(t); }, run);
  }
  write_obj(folder / "mesh.obj", task.atlas ? task.atlas->mesh : task.input.map->mesh());
  if (!task.input.source_mask.empty()) write_codes(folder / kSourceMaskFile, task.input.source_mask);
}

}  // namespace patinate::transfer
