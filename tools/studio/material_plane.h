/// \file
/// What the texels of a simulation are made of, beside color and relief: metal, a film of water, plants; and how much
/// light from all around they get.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "patinate/simulation/engine.h"
#include "tools/studio/tile_planes.h"

namespace patinate::studio {

/// 256 bytes a tile, in the order of ScreenTile. By texel: metalness and wetness as `render` has them, 255 = 1; amount
/// of what plants grow of, 255 = 1 or more, where all plants are full-grown; share of the light from all around that
/// does not reach it, 255 = 1, as the objects stood when this was made.
class MaterialPlane {
 public:
  static constexpr std::size_t kTileBytes = TilePlanes::kTileBytes;

  /// @param layout  Outlives this.
  MaterialPlane(const simulation::Simulation& simulation, const ScreenLayout& layout, const RunControl& control = {});

  /// The material that is shown as a film; -1 = none. Where gammatons bounce about composed normals, water stays a
  /// color: these must not depend on who looks.
  [[nodiscard]] static int film_of(const simulation::Scene& scene);
  /// @returns tiles whose bytes have changed, in order.
  [[nodiscard]] std::vector<ScreenTile> update(const simulation::Simulation& simulation);
  /// After a restore or other looks: everything is looked at again.
  void forget() { seen_ = -1; }
  [[nodiscard]] std::span<const std::uint8_t> tile(ScreenTile tile) const {
    return {&bytes_[std::size_t{tile} * kTileBytes], kTileBytes};
  }
  /// Row by row, as a texture: width x height x 4.
  [[nodiscard]] std::string rows() const { return rows_of_tiles(*layout_, bytes_); }

 private:
  const ScreenLayout* layout_;
  bool has_metal_;
  int film_, plant_;                  ///< Materials; -1 = none.
  std::int64_t seen_ = -1;            ///< Tiles that changed in this iteration or later are not in it yet.
  std::vector<std::uint8_t> hidden_;  ///< By TexelIndex.
  std::vector<std::uint8_t> bytes_;
};

}  // namespace patinate::studio
