#include "simulation/rules/layer_cracking.h"

#include <algorithm>
#include <utility>

namespace patinate::simulation {

namespace {

void append(std::vector<LayerTexel>& from, std::vector<LayerTexel>& to) {
  to.insert(to.end(), from.begin(), from.end());
  from.clear();
}

void make_rising(std::vector<TileIndex>& tiles) {
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
}

}  // namespace

void LayerCracking::Finds::take(Finds& other) {
  append(other.weak, weak);
  append(other.loosened, loosened);
}

void LayerCracking::find(TileIndex tile, const LayerTile& aged, Finds& finds) const {
  growth_.find_seeds(tile, finds.weak);
  aged.find_loosened(finds.loosened);
}

std::vector<TileIndex> LayerCracking::step(Finds finds, LayerTile& buffer, MaterialAtlas& atlas, LayerSums& sums,
                                           const RunControl& control) {
  std::vector<TileIndex> tiles = growth_.grow(finds.weak, control);
  for (const LayerTexel& at : finds.loosened) tiles.push_back(TileGrid::tile_of(at.texel));
  make_rising(tiles);
  for (const TileIndex tile : tiles) layers_->renew_tops(tile);
  const std::vector<LayerTexel> falling = cells_.falling(std::move(finds.loosened));
  for (std::size_t i = 0; i < falling.size();) {
    const TileIndex tile = TileGrid::tile_of(falling[i].texel);
    buffer.load(tile);
    for (; i < falling.size() && TileGrid::tile_of(falling[i].texel) == tile; ++i)
      buffer.drop(falling[i].texel % TileGrid::kTileTexels, static_cast<int>(falling[i].layer), sums);
    bool is_opened = false;
    (void)buffer.store(*layers_, atlas, sums, is_opened);
    layers_->renew_tops(tile);
    tiles.push_back(tile);
  }
  make_rising(tiles);
  return tiles;
}

}  // namespace patinate::simulation
