/// \file
/// Cracks of layers: where they begin, and how they grow (docs/algorithms/layer_cracks.md).
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/layer_atlas.h"

namespace patinate::simulation {

/// A texel of a layer.
struct LayerTexel {
  TexelIndex texel = 0;
  std::uint32_t layer = 1;
  friend auto operator<=>(const LayerTexel&, const LayerTexel&) = default;
};

/// Grows the cracks of a LayerAtlas. One texel in four is a weak place, with a strength of its own. A crack begins at
/// one where the stress that other cracks leave exceeds its strength. Its two tips run at right angles to the largest
/// tension, a relief length an iteration, until they meet a crack or an edge. It keeps no state of its own:
/// a run may be resumed with another of these.
class CrackGrowth {
 public:
  /// @param layers  Outlives it; some layer cracks.
  CrackGrowth(LayerAtlas& layers, std::uint64_t seed);

  /// Appends the weak places of a tile where stress may exceed strength. Several threads may ask at once.
  void find_seeds(TileIndex tile, std::vector<LayerTexel>& out) const;
  /// Moves tips, then begins cracks where the stress is largest first. @param seeds  In any order.
  /// @returns tiles with new cracks, rising.
  [[nodiscard]] std::vector<TileIndex> grow(std::span<const LayerTexel> seeds, const RunControl& control);

 private:
  struct Begin;
  [[nodiscard]] Begin begin_at(const LayerTexel& seed) const;
  void note(const LayerTexel& seed, const Begin& begin);
  void open(const LayerTexel& at);
  /// Over a relief length. @returns false when it has met something.
  [[nodiscard]] bool run(CrackTip& tip);
  enum class Move { On, Wait, End };
  [[nodiscard]] Move move(CrackTip& tip, double length_mm);
  [[nodiscard]] bool touches(const CrackTip& tip, TexelIndex before) const;
  /// In quanta of stress, of a weak place.
  [[nodiscard]] double strength_at(int layer, TexelIndex texel) const;
  [[nodiscard]] double random_at(int layer, TexelIndex texel, std::uint32_t purpose) const;

  LayerAtlas* layers_;
  std::uint64_t seed_;
  std::vector<std::vector<std::uint8_t>> weak_;  ///< By layer, then texel: 0 = no weak place, else its strength.
  std::array<double, kMaxLayers> pull_{};  ///< By layer: the largest tension along some axis, in parts of the stress.
  std::vector<TileIndex> changed_;
};

}  // namespace patinate::simulation
