#include "patinate/transfer/transfer_reader.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "libcommon/core/text.h"
#include "libcommon/image/between_pixels.h"
#include "patinate/atlas/dilate.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/time_map.h"
#include "transfer/files/flow_io.h"
#include "transfer/files/transfer_edits.h"
#include "transfer/guidance/painted_control.h"
#include "transfer/lookup/packed_lookup.h"
#include "transfer/lookup/source_turn.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::transfer {

namespace {

/// @throws IoError
void check_coordinates(const std::filesystem::path& file, const ImageF& coordinates, const HistoryFacts& history,
                       bool is_subpixel) {
  std::vector<std::uint32_t> pixels(static_cast<std::size_t>(coordinates.width())),
      beside(is_subpixel ? pixels.size() : 0);
  for (int y = 0; y < coordinates.height(); ++y)
    pack_checked_rows(file, coordinates.row(y), y, coordinates.width(), history.width, history.height, pixels, beside);
}

}  // namespace

ImageF gather(const ImageF& source, const ImageF& coordinates, float outside, const RunControl& control) {
  return look_up(source, coordinates, outside, control);
}

TransferReader::TransferReader(const std::filesystem::path& path)
    : folder_(path), atlas_(folder_.read_atlas()), mesh_(sheet_mesh(atlas_, folder_.sheet())) {
  if (std::int64_t{sheet().width()} * sheet().height() > Sheet::kMaxTexels) {
    throw IoError(path.string(), "has " + size_text(sheet().width(), sheet().height()) +
                                     " texels in all tiles, more than are held at once; `texture`, and `export` to a "
                                     "folder, go tile by tile");
  }
  read_coordinates();
}

ImageF TransferReader::read_sheet(const std::vector<std::filesystem::path>& files,
                                  const std::vector<std::string>& channels, float outside) const {
  ImageF whole;
  if (sheet().num_tiles() > 1)
    whole = ImageF(sheet().width(), sheet().height(), static_cast<int>(channels.size()), outside);
  for (int i = 0; i < sheet().num_tiles(); ++i) {
    const std::filesystem::path& file = files[i];
    ImageF tile = read_channels(file, channels);
    if (tile.width() != manifest().width || tile.height() != manifest().height) {
      throw IoError(file.string(), "is " + size_text(tile.width(), tile.height()) + "; expected " +
                                       size_text(manifest().width, manifest().height));
    }
    if (sheet().num_tiles() == 1) return tile;
    for (int y = 0; y < tile.height(); ++y) {  // Margins stay uncovered.
      const auto from = tile.row(y);
      std::copy(from.begin(), from.end(), whole.pixel(sheet().first_x(i), sheet().first_y(i) + y).data());
    }
  }
  return whole;
}

void TransferReader::read_coordinates() {
  std::vector<std::filesystem::path> files;
  for (const TransferTile& tile : manifest().tiles) files.push_back(tile.coordinates);
  coordinates_ = read_sheet(files, {kCoordinateChannels[0], kCoordinateChannels[1]}, -1.0f);
  for (int i = 0; i < sheet().num_tiles(); ++i) {
    check_coordinates(files[i], sheet().num_tiles() == 1 ? coordinates_ : cut_tile(coordinates_, sheet(), i),
                      history().facts(), manifest().is_subpixel);
  }
}

TransferControl TransferReader::control(std::size_t index) const {
  const RecordedControl& c = manifest().controls.at(index);
  std::vector<std::filesystem::path> files;
  for (const TransferTile& tile : manifest().tiles) files.push_back(tile_path(c.file, tile.name));
  return {c.source, c.destination, read_sheet(files, {"Y"}, 0.0f), c.range, c.weight, c.mapping};
}

ImageF TransferReader::matched_control(std::size_t index) const {
  std::vector<TransferControl> controls{control(index)};
  for (std::size_t i = 0; i < manifest().controls.size(); ++i) {
    // The control that says which history of a library applies decides how others are matched.
    if (manifest().controls[i].source == kLibraryControl && i != index) controls.push_back(control(i));
  }
  ImageF matched = std::move(match_controls(history(), source_mask(), controls, coverage()).destination[0]);
  if (!manifest().edits) return matched;
  const TexelMap map(mesh(), sheet());
  const SurfaceBrush brush(map);
  for (const TransferEdit& edit : read_transfer_edits(*manifest().edits).edits) {
    if (edit.kind != EditKind::Stroke || edit.control != controls[0].source) continue;
    for (const BrushedTexel& b : brush.find(edit.stroke)) {
      float& value = matched.values()[static_cast<std::size_t>(b.texel)];
      value = static_cast<float>(brushed(static_cast<double>(value), edit.value, b.kept));
    }
  }
  return matched;
}

ImageU8 TransferReader::source_mask() const {
  return usable_mask(history(), manifest().source_mask ? read_mask(*manifest().source_mask) : ImageU8());
}

ImageU8 TransferReader::coverage() const {
  ImageU8 coverage(coordinates_.width(), coordinates_.height());
  for (int y = 0; y < coverage.height(); ++y) {
    for (int x = 0; x < coverage.width(); ++x) coverage.at(x, y) = coordinates_.at(x, y, 0) >= 0.0f ? 255 : 0;
  }
  return coverage;
}

const PackedPlaces& TransferReader::filled_places() const {
  std::call_once(filled_once_, [&] {
    filled_ = std::make_shared<const PackedPlaces>(
        transfer::filled_places(coordinates_, history().facts().width, history().facts().height, sheet()));
  });
  return *filled_;
}

const Image<std::uint32_t>& TransferReader::filled_turns() const {
  std::call_once(turns_once_, [&] {
    std::vector<std::filesystem::path> files;
    for (const TransferTile& tile : manifest().tiles) {
      const std::vector<std::string> there = probe_image(tile.coordinates).channels;
      for (const char* name : kPatchChannels) {
        if (std::find(there.begin(), there.end(), name) == there.end()) return;
      }
      files.push_back(tile.coordinates);
    }
    const ImageF angle_mirror = read_sheet(files, {kPatchChannels[0], kPatchChannels[1]}, 0.0f);
    const PackedCoordinates indices =
        pack_coordinates(coordinates_, history().facts().width, history().facts().height).pixels;
    Image<std::uint32_t> turns(indices.width(), indices.height());
    for (int y = 0; y < turns.height(); ++y)
      pack_checked_turns(files.front(), angle_mirror.row(y), y, turns.width(), indices.row(y), turns.row(y));
    fill_sheet(turns, sheet());
    turns_ = std::move(turns);
  });
  return turns_;
}

ImageF TransferReader::sample_map(MaterialMap map, double time, Between between, const RunControl& control) const {
  ImageF values = gather_sheet(sample_material_map(history(), map, time, between), control);
  if (map == MaterialMap::Normal) make_unit_between(filled_places().view(), values.values());
  if (map == MaterialMap::Normal && !filled_turns().empty()) turn_normals(filled_turns().values(), values.values());
  return values;
}

std::vector<ImageF> TransferReader::tiles_of(ImageF values) const {
  std::vector<ImageF> tiles;
  if (sheet().num_tiles() == 1) {
    tiles.push_back(std::move(values));
    return tiles;
  }
  for (int i = 0; i < sheet().num_tiles(); ++i) tiles.push_back(cut_tile(values, sheet(), i));
  return tiles;
}

std::vector<ImageF> TransferReader::gather_tiles(const ImageF& source, const RunControl& control) const {
  return tiles_of(gather_sheet(source, control));
}

ImageF TransferReader::gather_sheet(const ImageF& source, const RunControl& control) const {
  return gather_packed(source, filled_places(), 0.0f, control);
}

std::vector<ImageF> TransferReader::filled_tiles(const ImageF& values) const {
  const ImageU8 covered = coverage();
  std::vector<ImageF> tiles;
  for (int i = 0; i < sheet().num_tiles(); ++i) {
    tiles.push_back(cut_tile(values, sheet(), i));
    dilate(tiles.back(), cut_tile(covered, sheet(), i), -1);
  }
  return tiles;
}

std::vector<ImageF> TransferReader::sample_tiles(double time, Between between, const RunControl& control) const {
  // Blending the two frames first equals blending two lookups, and touches fewer texels.
  return tiles_of(gather_sheet(patinate::sample(history(), time, between), control));
}

std::vector<ImageF> TransferReader::sample_tiles(const ImageF& times, Between between,
                                                 const RunControl& control) const {
  return filled_tiles(gather_at_times(history(), coordinates_, times, between, control));
}

ImageF TransferReader::sample(double time, const RunControl& control) const {
  return gather_sheet(history().sample(time), control);
}

}  // namespace patinate::transfer
