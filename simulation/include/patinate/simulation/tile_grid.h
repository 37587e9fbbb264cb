/// \file
/// The order in which a simulation keeps texels: tiles of 8 x 8, so that what is near on the surface is near in memory
/// and "what has changed" can be told in small pieces (5,000 random hits touch a quarter of a 1k atlas's tiles, but
/// nearly all of its 32 x 32 squares).
#pragma once

#include <cstdint>

namespace patinate::simulation {

using TexelIndex = std::uint32_t;  ///< tile * 64 + (y % 8) * 8 + x % 8.
using TileIndex = std::uint32_t;   ///< Row by row; a tile's texels are [tile * 64, tile * 64 + 64).

/// Texels of a grid by tiles. Width and height are rounded up to whole pages of 64 x 64 texels (8 x 8 tiles), in which
/// memory is given out.
struct TileGrid {
  static constexpr int kTileSide = 8;
  static constexpr int kTileTexels = 64;
  static constexpr int kPageTiles = 64;
  static constexpr int kPageTexels = 4096;

  int width = 0;  ///< Texels that a user sees.
  int height = 0;

  [[nodiscard]] int pages_x() const { return (width + 63) / 64; }
  [[nodiscard]] int pages_y() const { return (height + 63) / 64; }
  [[nodiscard]] std::uint32_t num_pages() const {
    return static_cast<std::uint32_t>(pages_x()) * static_cast<std::uint32_t>(pages_y());
  }
  [[nodiscard]] TileIndex num_tiles() const { return num_pages() * kPageTiles; }
  [[nodiscard]] std::uint32_t num_texels() const { return num_pages() * kPageTexels; }

  /// Pages row by row, in a page tiles row by row, in a tile texels row by row. @param x,y  Inside the grid.
  [[nodiscard]] TexelIndex index(int x, int y) const {
    const auto ux = static_cast<std::uint32_t>(x);
    const auto uy = static_cast<std::uint32_t>(y);
    const std::uint32_t page = (uy >> 6) * static_cast<std::uint32_t>(pages_x()) + (ux >> 6);
    return page << 12 | (uy >> 3 & 7) << 9 | (ux >> 3 & 7) << 6 | (uy & 7) << 3 | (ux & 7);
  }
  [[nodiscard]] int x(TexelIndex t) const {
    return static_cast<int>((t >> 12) % static_cast<std::uint32_t>(pages_x()) << 6 | (t >> 6 & 7) << 3 | (t & 7));
  }
  [[nodiscard]] int y(TexelIndex t) const {
    return static_cast<int>((t >> 12) / static_cast<std::uint32_t>(pages_x()) << 6 | (t >> 9 & 7) << 3 | (t >> 3 & 7));
  }
  [[nodiscard]] static TileIndex tile_of(TexelIndex t) { return t >> 6; }
  [[nodiscard]] static std::uint32_t page_of(TexelIndex t) { return t >> 12; }
  /// Whether the texel lies in the part that a user sees.
  [[nodiscard]] bool is_inside(TexelIndex t) const { return x(t) < width && y(t) < height; }
};

}  // namespace patinate::simulation
