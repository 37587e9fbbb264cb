/// \file
/// Shares that lie on the same texels, summed.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <vector>

#include "simulation/transport/splat.h"

namespace patinate::simulation {

/// Sums that overlapping splats leave on each texel: by tile, which neighbors share, so that nothing is sorted but
/// tiles.
class PartSums {
 public:
  PartSums() : slots_(kFirstSlots, 0) {}

  void add(TexelIndex texel, std::uint32_t share) {
    const TileIndex tile = TileGrid::tile_of(texel);
    if (last_ == kNone || tiles_[last_].tile != tile) last_ = place_of(tile);
    Tile& at = tiles_[last_];
    const std::uint32_t l = texel % TileGrid::kTileTexels;
    const std::uint64_t bit = std::uint64_t{1} << l;
    at.share[l] = (at.texels & bit) != 0 ? at.share[l] + share : share;
    at.texels |= bit;
  }

  /// Appends a part for each texel that was added to: that of `middle`, which is one of them, then the others, rising.
  /// Nothing is left.
  void take(TexelIndex middle, std::vector<SplatPart>& parts) {
    const std::size_t first = parts.size();
    parts.push_back({middle, 0});
    order_.resize(num_tiles_);
    std::iota(order_.begin(), order_.end(), 0u);
    std::sort(order_.begin(), order_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return tiles_[a].tile < tiles_[b].tile; });
    for (const std::uint32_t k : order_) {
      const Tile& at = tiles_[k];
      for (std::uint64_t bits = at.texels; bits != 0; bits &= bits - 1) {
        const auto l = static_cast<std::uint32_t>(std::countr_zero(bits));
        const TexelIndex texel = at.tile * TileGrid::kTileTexels + l;
        if (texel == middle) {
          parts[first].share = at.share[l];
        } else {
          parts.push_back({texel, at.share[l]});
        }
      }
    }
    num_tiles_ = 0;
    last_ = kNone;
    std::fill(slots_.begin(), slots_.end(), 0u);
  }

 private:
  static constexpr std::size_t kFirstSlots = 512;  ///< A power of two, as their number always is.
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  struct Tile {
    TileIndex tile;
    std::uint64_t texels;  ///< A bit for each that has a share.
    std::array<std::uint32_t, TileGrid::kTileTexels> share;
  };

  [[nodiscard]] std::size_t slot_of(TileIndex tile) const { return (tile * 0x9E3779B1u >> 8) & (slots_.size() - 1); }
  /// Made when it is not there.
  [[nodiscard]] std::uint32_t place_of(TileIndex tile) {
    std::size_t s = slot_of(tile);
    for (; slots_[s] != 0; s = (s + 1) & (slots_.size() - 1)) {
      if (tiles_[slots_[s] - 1].tile == tile) return slots_[s] - 1;
    }
    if (2 * (num_tiles_ + std::size_t{1}) > slots_.size()) {
      grow();
      return place_of(tile);
    }
    if (num_tiles_ == tiles_.size()) tiles_.emplace_back();
    tiles_[num_tiles_].tile = tile;
    tiles_[num_tiles_].texels = 0;
    slots_[s] = ++num_tiles_;
    return num_tiles_ - 1;
  }
  void grow() {
    slots_.assign(2 * slots_.size(), 0);
    for (std::uint32_t k = 0; k < num_tiles_; ++k) {
      std::size_t s = slot_of(tiles_[k].tile);
      while (slots_[s] != 0) s = (s + 1) & (slots_.size() - 1);
      slots_[s] = k + 1;
    }
  }

  std::vector<Tile> tiles_;
  std::vector<std::uint32_t> slots_;  ///< Place + 1; 0: none.
  std::vector<std::uint32_t> order_;
  std::uint32_t num_tiles_ = 0, last_ = kNone;
};

}  // namespace patinate::simulation
