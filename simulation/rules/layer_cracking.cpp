#include "simulation/rules/layer_cracking.h"

#include <algorithm>
#include <utility>

#include "simulation/layers/crack_relief.h"

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

/// With those around each in the atlas: within kLiftTexels, what is loose lifts texels by.
void add_around(const TileGrid& grid, std::vector<TileIndex>& tiles) {
  static_assert(kLiftTexels <= TileGrid::kTileSide);
  const std::size_t num = tiles.size();
  for (std::size_t k = 0; k < num; ++k) {
    const TexelIndex first = tiles[k] * TileGrid::kTileTexels;
    for (const int dy : {-TileGrid::kTileSide, 0, TileGrid::kTileSide}) {
      for (const int dx : {-TileGrid::kTileSide, 0, TileGrid::kTileSide}) {
        const int x = grid.x(first) + dx, y = grid.y(first) + dy;
        if (x >= 0 && y >= 0 && x < grid.width && y < grid.height) tiles.push_back(TileGrid::tile_of(grid.index(x, y)));
      }
    }
  }
  make_rising(tiles);
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
  tiles.insert(tiles.end(), finds.opened.begin(), finds.opened.end());
  for (const LayerTexel& at : finds.loosened) tiles.push_back(TileGrid::tile_of(at.texel));
  make_rising(tiles);
  for (const TileIndex tile : tiles) layers_->renew_tops(tile);
  cells_.renew(tiles);
  const std::vector<LayerTexel> falling = cells_.falling(std::move(finds.loosened));
  std::vector<TileIndex> dropped;
  for (std::size_t i = 0; i < falling.size();) {
    const TileIndex tile = TileGrid::tile_of(falling[i].texel);
    buffer.load(tile);
    for (; i < falling.size() && TileGrid::tile_of(falling[i].texel) == tile; ++i)
      buffer.drop(falling[i].texel % TileGrid::kTileTexels, static_cast<int>(falling[i].layer), sums);
    bool is_opened = false;
    (void)buffer.store(*layers_, atlas, sums, is_opened);
    layers_->renew_tops(tile);
    dropped.push_back(tile);
  }
  cells_.renew(dropped);
  tiles.insert(tiles.end(), dropped.begin(), dropped.end());
  add_around(layers_->surface().grid(), tiles);
  return tiles;
}

}  // namespace patinate::simulation
