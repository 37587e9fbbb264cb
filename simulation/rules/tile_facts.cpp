#include "simulation/rules/tile_facts.h"

#include "libcommon/core/parallel.h"

namespace patinate::simulation {

TileFacts::TileFacts(const SurfaceAtlas& surface)
    : surface_(&surface),
      covered_(surface.grid().num_tiles()),
      weight_(surface.grid().num_tiles()),
      is_uniform_(surface.grid().num_tiles()) {
  parallel_for(surface.grid().num_tiles(), 4096, {},
               [&](std::int64_t begin, std::int64_t end) {  // chunks share no word of is_uniform_
                 for (auto tile = static_cast<std::size_t>(begin); tile < static_cast<std::size_t>(end); ++tile) {
                   std::uint64_t covered = 0;
                   std::uint32_t weight = 0;
                   int object = -1;
                   bool has_one_weight = true, has_one_object = true;
                   for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
                     const auto texel = static_cast<TexelIndex>(tile * TileGrid::kTileTexels + i);
                     const int triangle = surface.triangle(texel);
                     if (triangle < 0) continue;
                     if (covered != 0) {
                       has_one_weight &= surface.weight(texel) == weight;
                       has_one_object &= surface.object(triangle) == object;
                     }
                     covered |= std::uint64_t{1} << i;
                     weight = surface.weight(texel);
                     object = surface.object(triangle);
                   }
                   covered_[tile] = covered;
                   weight_[tile] = static_cast<std::uint16_t>(has_one_weight ? weight : 0);
                   is_uniform_[tile] = covered == ~std::uint64_t{0} && has_one_object;
                 }
               });
}

std::vector<std::uint64_t> TileFacts::covered_tiles() const {
  std::vector<std::uint64_t> pages(covered_.size() / TileGrid::kPageTiles);
  for (std::size_t tile = 0; tile < covered_.size(); ++tile) {
    if (covered_[tile] != 0) pages[tile / TileGrid::kPageTiles] |= std::uint64_t{1} << tile % TileGrid::kPageTiles;
  }
  return pages;
}

void TileFacts::covered(TileIndex tile, std::array<float, TileGrid::kTileTexels>& out) const {
  const std::uint64_t bits = covered_[tile];
  if (bits == ~std::uint64_t{0}) {
    out.fill(1.0F);
    return;
  }
  for (std::size_t i = 0; i < TileGrid::kTileTexels; ++i) out[i] = static_cast<float>(bits >> i & 1);
}

void TileFacts::weights(TileIndex tile, std::array<std::uint32_t, TileGrid::kTileTexels>& out) const {
  if (weight_[tile] != 0) {  // what is not covered has no changes to weigh
    out.fill(weight_[tile]);
    return;
  }
  for (std::size_t i = 0; i < TileGrid::kTileTexels; ++i) {
    const auto texel = static_cast<TexelIndex>(tile * TileGrid::kTileTexels + i);
    out[i] = surface_->is_covered(texel) ? surface_->weight(texel) : 0;
  }
}

}  // namespace patinate::simulation
