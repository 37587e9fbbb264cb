#include "transfer/synthesis/tile_grid.h"

#include <algorithm>

#include "patinate/core/error.h"

namespace patinate::transfer {

TileGrid::TileGrid(const Sheet& sheet)
    : columns_(sheet.columns),
      rows_(sheet.rows()),
      cell_width_(sheet.tile_width + 2 * sheet.margin()),
      cell_height_(sheet.tile_height + 2 * sheet.margin()),
      width_(sheet.width()),
      height_(sheet.height()),
      num_tiles_(sheet.num_tiles()) {
  if (num_tiles_ < 2) throw InvalidInput("the mesh has one tile, which cannot be cut; expected UVs of several tiles");
}

namespace {

/// The first texel of a level whose middle lies behind the texel `at` of the finest. @param size,coarse  Texels there
/// and here.
int first_behind(std::int64_t at, std::int64_t size, std::int64_t coarse) {
  const std::int64_t above = 2 * at * coarse - size;
  return static_cast<int>(std::clamp<std::int64_t>(above <= 0 ? 0 : (above + 2 * size - 1) / (2 * size), 0, coarse));
}

}  // namespace

TexelRect TileGrid::rect(std::size_t level, int tile) const {
  const int column = tile % columns_, row = tile / columns_, w = width(level), h = height(level);
  return {first_behind(std::int64_t{column} * cell_width_, width_, w),
          first_behind(std::int64_t{row} * cell_height_, height_, h),
          first_behind(std::int64_t{column + 1} * cell_width_, width_, w),
          first_behind(std::int64_t{row + 1} * cell_height_, height_, h)};
}

int TileGrid::tile_of(std::size_t level, int x, int y) const {
  const auto find = [](int at, int cell, int count, int size, int coarse) {
    int found = static_cast<int>(std::min<std::int64_t>(count - 1, std::int64_t{at} * size / coarse / cell));
    while (found > 0 && first_behind(std::int64_t{found} * cell, size, coarse) > at) --found;
    while (found + 1 < count && first_behind(std::int64_t{found + 1} * cell, size, coarse) <= at) ++found;
    return found;
  };
  return find(y, cell_height_, rows_, height_, height(level)) * columns_ +
         find(x, cell_width_, columns_, width_, width(level));
}

std::size_t TileGrid::num_tiled_levels() const {
  std::size_t levels = 0;
  while (num_texels(levels) > 2 * std::int64_t{cell_width_} * cell_height_) ++levels;
  return levels;
}

}  // namespace patinate::transfer
