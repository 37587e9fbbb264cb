/// \file
/// Pieces of layers that cracks and edges cut off, and when they fall.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "simulation/layers/crack_growth.h"

namespace patinate::simulation {

/// A piece is cut off when it is no larger than kMostLengths relief lengths squared. It falls as a whole, with the
/// cracks around it, once it has lost its adhesion over kLostShare of its area. What is larger is a sheet, of which
/// fall single texels that have lost theirs, as cracks that have do, where no other layer holds them down.
///
/// A piece that was cut off and did not fall is remembered, with how much of it is loose, until its outline changes: it
/// is not looked for again with every texel that it loses. No result depends on what is remembered.
class CrackCells {
 public:
  static constexpr double kLostShare = 0.5;
  static constexpr double kMostLengths = 10.0;

  /// @param layers  Outlives it.
  explicit CrackCells(const LayerAtlas& layers) : layers_(&layers) {}

  /// What falls, rising. @param loosened  Texels of layers that crack which have just lost their adhesion.
  [[nodiscard]] std::vector<LayerTexel> falling(std::vector<LayerTexel> loosened);
  /// Before falling(), for all tiles where layers were opened or have lost adhesion since (LayerAtlas::renew_tops()).
  void renew(std::span<const TileIndex> tiles);
  /// After layers or texels' weights were changed in any other way.
  void forget();

 private:
  struct Piece;
  /// Cut off, and remembered.
  struct Cell {
    std::int64_t area = 0, lost = 0;  ///< Weights.
    std::uint64_t looked_at = 0;      ///< Number of the last call of falling() that has asked for it.
    bool is_known = true;             ///< Its outline is as it was.
  };
  [[nodiscard]] Piece piece_at(const LayerTexel& from);
  [[nodiscard]] std::int64_t most_area(const LayerTexel& at) const;
  void remember(const Piece& piece, int layer);
  /// @returns whether it holds for sure.
  [[nodiscard]] bool is_known_to_hold(const LayerTexel& at);
  void begin_memory();
  void renew(TexelIndex texel);
  /// Bits of layers that end at a texel.
  [[nodiscard]] std::uint8_t open_at(TexelIndex texel) const;
  [[nodiscard]] Cell* cell_at(int layer, TexelIndex texel);
  [[nodiscard]] bool is_loose(const LayerTexel& at) const { return (layers_->loose()[at.texel] >> at.layer & 1) != 0; }
  [[nodiscard]] bool is_outermost(const LayerTexel& at) const { return layers_->tops()[at.texel] == at.layer; }

  const LayerAtlas* layers_;
  std::vector<std::uint8_t> seen_, in_sheet_;  ///< By texel: a bit for each layer.
  std::vector<TexelIndex> marked_;
  std::vector<std::uint8_t> open_, loose_;  ///< By texel, as of renew(): a bit for each layer. Empty: nothing is known.
  std::array<std::vector<std::uint32_t>, kMaxLayers> cell_of_;  ///< By layer, then texel: one more than an index; or 0.
  std::vector<Cell> cells_;
  std::uint64_t num_calls_ = 0;
};

}  // namespace patinate::simulation
