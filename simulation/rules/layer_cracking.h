/// \file
/// What happens to layers that crack after rules have acted: cracks grow, and pieces fall.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/layer_atlas.h"
#include "simulation/layers/crack_cells.h"
#include "simulation/layers/crack_growth.h"
#include "simulation/rules/layer_tile.h"

namespace patinate::simulation {

class LayerCracking {
 public:
  /// @param layers  Outlives it; some layer cracks.
  LayerCracking(LayerAtlas& layers, std::uint64_t seed) : layers_(&layers), growth_(layers, seed), cells_(layers) {}

  /// What rules have brought about in tiles.
  struct Finds {
    std::vector<LayerTexel> weak, loosened;
    std::vector<TileIndex> opened;  ///< Where another layer shows.
    void take(Finds& other);
  };
  /// Adds what is found in a tile that is stored. Several threads may ask at once.
  void find(TileIndex tile, const LayerTile& aged, Finds& finds) const;

  /// @param finds   Of all threads, in any order. @param buffer, sums  As LayerTile takes them.
  /// @returns tiles that may look different, rising. LayerAtlas::renew_tops() is done.
  [[nodiscard]] std::vector<TileIndex> step(Finds finds, LayerTile& buffer, MaterialAtlas& atlas, LayerSums& sums,
                                            const RunControl& control);

  /// After layers or texels' weights were changed in any other way.
  void forget() { cells_.forget(); }

 private:
  LayerAtlas* layers_;
  CrackGrowth growth_;
  CrackCells cells_;
};

}  // namespace patinate::simulation
