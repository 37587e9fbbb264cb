/// \file
/// A simulation's picture as the browser holds it: tiles of 8 x 8 texels, row by row, gutters filled. Says which tiles
/// a step has changed.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "patinate/simulation/compose.h"

namespace patinate::studio {

/// Tiles row by row over ceil(width / 8) columns, unlike TileIndex, which goes by pages.
using ScreenTile = std::uint32_t;

/// Texel of a simulation that every texel of the picture shows: itself, or outside the charts the nearest inside, as
/// in exported textures (dilate()). Memory: 4 bytes for each texel of a tile that is not whole.
class ScreenLayout {
 public:
  explicit ScreenLayout(const simulation::SurfaceAtlas& surface);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int columns() const { return (width_ + 7) / 8; }
  [[nodiscard]] ScreenTile num_tiles() const { return static_cast<ScreenTile>(columns() * ((height_ + 7) / 8)); }
  /// By texel of the tile, row by row: kNoTexel where the picture has ended.
  [[nodiscard]] std::array<simulation::TexelIndex, 64> sources(ScreenTile tile) const;
  /// Every tile that shows a texel of `changed`, once, in order.
  [[nodiscard]] std::vector<ScreenTile> showing(std::span<const simulation::TileIndex> changed) const;
  [[nodiscard]] std::size_t memory() const;

 private:
  [[nodiscard]] ScreenTile tile_at(int x, int y) const { return static_cast<ScreenTile>((y / 8) * columns() + x / 8); }

  simulation::TileGrid grid_;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint32_t>
      first_source_;  ///< By screen tile: into sources_; kWhole for one that is covered everywhere.
  std::vector<simulation::TexelIndex> sources_;
  std::vector<std::uint32_t> gutter_begin_;  ///< By TileIndex, one more: into gutter_tiles_.
  std::vector<ScreenTile> gutter_tiles_;     ///< Other tiles whose gutters show texels of this one.
};

/// Tiles of four bytes a texel row by row, as a texture: width x height x 4. @param tiles  All, in order.
[[nodiscard]] std::string rows_of_tiles(const ScreenLayout& layout, std::span<const std::uint8_t> tiles);

/// Heights as 255 steps of [low_mm, high_mm].
struct ReliefRange {
  double low_mm = -1.0;
  double high_mm = 1.0;
  [[nodiscard]] std::uint8_t code(double height_mm) const;
};

/// The picture itself: two planes of four bytes a texel, 256 bytes a tile. Memory: 8 bytes a texel.
class TilePlanes {
 public:
  enum Plane { Surface, Relief };  ///< R, G, B, specular; normal x, y, z, height.
  static constexpr std::size_t kTileBytes = 256;

  /// @param layout  Outlives this.
  explicit TilePlanes(const ScreenLayout& layout);

  struct Changes {
    std::vector<ScreenTile> surface, relief;  ///< In order.
  };
  /// Brings `tiles`, each given once, up to date. Only those whose bytes have changed count.
  [[nodiscard]] Changes update(const simulation::Composer& composer, std::span<const ScreenTile> tiles,
                               const ReliefRange& range, const RunControl& control = {});
  [[nodiscard]] std::span<const std::uint8_t> tile(Plane plane, ScreenTile tile) const;
  /// Row by row, as a texture: width x height x 4.
  [[nodiscard]] std::string rows(Plane plane) const;
  [[nodiscard]] std::size_t memory() const { return planes_[0].size() + planes_[1].size(); }

 private:
  const ScreenLayout* layout_;
  std::array<std::vector<std::uint8_t>, 2> planes_;
};

}  // namespace patinate::studio
