/// \file
/// What rules need to know of a tile's texels, found once: which are covered, and their area weights.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// 12 bytes a tile.
class TileFacts {
 public:
  TileFacts() = default;
  /// @param surface  Outlives the facts.
  explicit TileFacts(const SurfaceAtlas& surface);

  /// By page: a bit for each tile with a covered texel.
  [[nodiscard]] std::vector<std::uint64_t> covered_tiles() const;
  /// Whether all texels are covered and belong to one object.
  [[nodiscard]] bool is_uniform(TileIndex tile) const { return is_uniform_[tile]; }
  /// By tile: a bit for each covered texel.
  [[nodiscard]] std::span<const std::uint64_t> covered_texels() const { return covered_; }
  /// 1 where a texel is covered, else 0.
  void covered(TileIndex tile, std::array<float, TileGrid::kTileTexels>& out) const;
  /// Area weights; 0 where a texel is not covered.
  void weights(TileIndex tile, std::array<std::uint32_t, TileGrid::kTileTexels>& out) const;

 private:
  const SurfaceAtlas* surface_ = nullptr;
  std::vector<std::uint64_t> covered_;  ///< A bit for each texel.
  std::vector<std::uint16_t> weight_;   ///< Weight of all covered texels; 0 = they differ.
  std::vector<bool> is_uniform_;
};

}  // namespace patinate::simulation
