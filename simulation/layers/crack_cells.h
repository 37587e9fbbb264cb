/// \file
/// Pieces of layers that cracks and edges cut off, and when they fall.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "simulation/layers/crack_growth.h"

namespace patinate::simulation {

/// A piece is cut off when it is no larger than kMostLengths relief lengths squared. It falls as a whole, with the
/// cracks around it, once it has lost its adhesion over kLostShare of its area. What is larger is a sheet, of which
/// fall single texels that have lost theirs, as cracks that have do, where no other layer holds them down.
class CrackCells {
 public:
  static constexpr double kLostShare = 0.5;
  static constexpr double kMostLengths = 10.0;

  /// @param layers  Outlives it.
  explicit CrackCells(const LayerAtlas& layers) : layers_(&layers) {}

  /// What falls, rising. @param loosened  Texels of layers that crack which have just lost their adhesion.
  [[nodiscard]] std::vector<LayerTexel> falling(std::vector<LayerTexel> loosened);

 private:
  struct Piece;
  [[nodiscard]] Piece piece_at(const LayerTexel& from);
  [[nodiscard]] bool is_loose(const LayerTexel& at) const { return (layers_->loose()[at.texel] >> at.layer & 1) != 0; }

  [[nodiscard]] bool is_outermost(const LayerTexel& at) const { return layers_->tops()[at.texel] == at.layer; }

  const LayerAtlas* layers_;
  std::vector<std::uint8_t> seen_, in_sheet_;  ///< By texel: a bit for each layer.
  std::vector<TexelIndex> marked_;
};

}  // namespace patinate::simulation
