/// \file
/// Where gammatons have ever been.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "patinate/simulation/scene.h"
#include "simulation/transport/cargo.h"

namespace patinate::simulation {

/// A bit for each texel on which the middle of a splat has lain; 1/8 byte a texel. It is cheap enough to be always
/// kept, as parameter maps are not.
class MetTexels {
 public:
  explicit MetTexels(const TileGrid& grid) : tiles_(grid.num_tiles(), 0) {}

  void add(std::span<const Contact> contacts) {
    for (const Contact& contact : contacts) add(contact.texel);
  }
  void add(TexelIndex texel) { tiles_[TileGrid::tile_of(texel)] |= std::uint64_t{1} << texel % TileGrid::kTileTexels; }
  [[nodiscard]] bool has(TexelIndex texel) const {
    return (tiles_[TileGrid::tile_of(texel)] >> texel % TileGrid::kTileTexels & 1) != 0;
  }
  /// By tile: a bit for each of its texels, the first lowest.
  [[nodiscard]] std::span<const std::uint64_t> tiles() const { return tiles_; }
  [[nodiscard]] std::span<std::uint64_t> tiles() { return tiles_; }

 private:
  std::vector<std::uint64_t> tiles_;
};

/// Texels that splats of `options` reach from a middle in `met`: 255, in the user's order of pixels; 0 elsewhere.
/// Splats are balanced: a texel has a part of another's exactly where that one has a part of its own, up to what rounds
/// to nothing at a splat's rim.
[[nodiscard]] ImageU8 reached_texels(const MetTexels& met, const ExchangeOptions& options, const SurfaceAtlas& surface,
                                     const RunControl& control = {});

}  // namespace patinate::simulation
