/// \file
/// Controls and places of an atlas whose tiles lie in files.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "patinate/transfer/transfer.h"
#include "transfer/synthesis/tile_grid.h"
#include "transfer/tiles/tile_files.h"

namespace patinate::transfer {

/// @param values  Of the rectangle.
[[nodiscard]] std::vector<float> covered_values(const TexelMap& map, const TexelRect& rect,
                                                std::span<const float> values);

/// Files of a control's tiles: values of the tile's rectangle, and those of covered texels, sorted. Floats.
struct ControlFiles {
  std::function<std::filesystem::path(int tile)> values, sorted;
};
void write_control_files(const ControlFiles& files, int tile, const TexelMap& map, const TexelRect& rect,
                         std::span<const float> values, const RunControl& control);

/// match_control() of one tile of an atlas.
[[nodiscard]] ImageF match_tile(const ControlFiles& files, int tile, int num_tiles, const TexelMap& map,
                                const TexelRect& rect, const TransferControl& control, const History& history,
                                const ImageU8& source_mask, const RunControl& run);

/// The controls of a level in the files of its tiles.
class StoredTargets {
 public:
  StoredTargets(std::filesystem::path folder, const TileGrid& grid, std::size_t level, int num_controls)
      : folder_(std::move(folder)), grid_(grid), level_(level), num_controls_(num_controls) {}

  /// Of a rectangle; 0 where no tile is.
  [[nodiscard]] ControlImage image(const TexelRect& rect);
  /// Of a rectangle, and of other texels.
  void load(const TexelRect& rect, std::span<const TexelId> others, LevelPart& part);

 private:
  /// Nothing where no tile is.
  [[nodiscard]] std::span<const std::uint16_t> at(int x, int y);

  std::filesystem::path folder_;
  const TileGrid& grid_;
  std::size_t level_;
  int num_controls_;
  std::map<int, MappedFile> files_;
};

/// Controls of a rectangle of a level, of the next finer one's.
[[nodiscard]] ControlImage halve_tile(StoredTargets& fine, const TexelMap& fine_map, const TexelMap& map,
                                      const TexelRect& rect, const RunControl& control);

/// The places of a level before a pass, tile by tile.
class TiledPlaces {
 public:
  TiledPlaces(const std::filesystem::path& folder, const TileGrid& grid, std::size_t level, int pass);
  /// A tile's own.
  void load(const TexelRect& rect, int tile, PlaceMap& places, std::span<std::uint8_t> changed_near) {
    stored_.load(tile, rect, grid_.width(level_), places, changed_near);
  }
  void load(std::span<const TexelId> texels, PlaceMap& places, std::span<std::uint8_t> changed_near);
  /// A rectangle, whosever tiles it is in.
  void load_part(const TexelRect& rect, PlaceMap& places);

 private:
  const TileGrid& grid_;
  std::size_t level_;
  StoredPlaces stored_;
};
[[nodiscard]] inline TiledPlaces stored_places(const std::filesystem::path& folder, const TileGrid& grid,
                                               std::size_t level, int pass) {
  return {folder, grid, level, pass};
}

}  // namespace patinate::transfer
