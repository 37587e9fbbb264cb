/// \file
/// The grain of materials: how what they look like varies over the surface, in lengths of the object and without seams.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "patinate/simulation/surface_atlas.h"
#include "simulation/composition/compose_kernel.h"
#include "simulation/composition/texel_places.h"
#include "simulation/composition/tile_cache.h"

namespace patinate::simulation::composition {

/// Noise in space [noise_at] at every texel: half of it of three octaves from the grain's length on, half of three from
/// an eighth of it on, so that both what is seen from afar and what is seen near are there. Octaves that the texels are
/// too coarse for are left out, so that a finer atlas is sharper and not another. Made tile by tile when first asked
/// for. Equal bits on every machine. Memory: a byte a texel, in pages as they are touched.
class Grain {
 public:
  /// @param places  Outlives it.
  explicit Grain(const TexelPlaces& places) : places_(&places) {}

  /// Keeps what is known where lengths stay. @param lengths_mm  One a material; 0 = it has none.
  void set_lengths(const std::vector<double>& lengths_mm);
  [[nodiscard]] bool has(std::size_t material) const {
    return material < fields_.size() && fields_[material].length > 0.0;
  }
  /// 64 values, 127.5 in the mean, standard deviation 51. Different tiles may be asked for by several threads at once.
  [[nodiscard]] const std::uint8_t* tile(std::size_t material, TileIndex tile);
  /// Grain of one texel, [0, 1]: for the slow version.
  [[nodiscard]] double value(std::size_t material, TexelIndex t) const;
  [[nodiscard]] std::size_t memory() const;

 private:
  struct Field {
    double length = 0.0;
    TileCache values = {};
  };
  /// value() of at most kTile texels.
  void values(std::size_t material, std::span<const TexelIndex> texels, std::span<double> out) const;

  const TexelPlaces* places_;
  std::vector<Field> fields_;
};

}  // namespace patinate::simulation::composition
