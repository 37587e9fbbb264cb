/// \file
/// A transfer's atlas cut into its tiles, level by level.
#pragma once

#include <cstddef>

#include "patinate/atlas/texel_map.h"

namespace patinate::transfer {

/// Every level of an atlas of several tiles in as many rectangles: the texels whose middles lie in a tile or its
/// margins, so that a chart never leaves its tile's. They cover the level but for places of the sheet where no tile is.
class TileGrid {
 public:
  /// @throws InvalidInput unless there are at least two tiles.
  explicit TileGrid(const Sheet& sheet);

  [[nodiscard]] int num_tiles() const { return num_tiles_; }
  [[nodiscard]] int width(std::size_t level) const { return width_ >> level; }
  [[nodiscard]] int height(std::size_t level) const { return height_ >> level; }
  [[nodiscard]] std::int64_t num_texels(std::size_t level) const { return std::int64_t{width(level)} * height(level); }
  [[nodiscard]] TexelRect rect(std::size_t level, int tile) const;
  [[nodiscard]] TexelRect whole(std::size_t level) const { return {0, 0, width(level), height(level)}; }
  /// Of a texel; num_tiles() or more where no tile is.
  [[nodiscard]] int tile_of(std::size_t level, int x, int y) const;
  /// Levels of more texels than two tiles have are worked on by tile; the coarser ones at once.
  [[nodiscard]] std::size_t num_tiled_levels() const;

 private:
  int columns_, rows_, cell_width_, cell_height_, width_, height_, num_tiles_;
};

}  // namespace patinate::transfer
