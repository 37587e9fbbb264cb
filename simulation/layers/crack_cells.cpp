#include "simulation/layers/crack_cells.h"

#include <algorithm>

#include "simulation/layers/crack_relief.h"

namespace patinate::simulation {

namespace {

/// f(texel) for those that a texel is linked to. Inside a plain tile they lie beside it in memory.
template <class F>
void for_each_beside(const SurfaceAtlas& surface, TexelIndex texel, F&& f) {
  constexpr std::uint32_t kSide = TileGrid::kTileSide, kLast = kSide - 1;
  const std::uint32_t x = texel % kSide, y = texel / kSide % kSide;
  if (x > 0 && x < kLast && y > 0 && y < kLast && surface.is_plain(TileGrid::tile_of(texel))) {
    for (const TexelIndex beside : {texel + 1, texel - 1, texel + kSide, texel - kSide}) f(beside);
    return;
  }
  std::array<SurfaceAtlas::Link, 4> plain;
  for (const SurfaceAtlas::Link& link : surface.links(texel, plain)) f(link.texel);
}

}  // namespace

struct CrackCells::Piece {
  std::vector<TexelIndex> texels;  ///< With the cracks around it; of a sheet, those that were looked at.
  bool is_sheet = false;
  std::int64_t area = 0, lost = 0;  ///< Weights.
};

CrackCells::Piece CrackCells::piece_at(const LayerTexel& from) {
  const SurfaceAtlas& surface = layers_->surface();
  const int layer = static_cast<int>(from.layer);
  const auto bit = static_cast<std::uint8_t>(1U << from.layer);
  const double texel_mm = surface.median_texel_size_mm();
  const double side = kMostLengths * relief_length_mm(*layers_, layer, from.texel) / texel_mm;
  const auto most = static_cast<std::int64_t>(side * side * SurfaceAtlas::kMedianWeight);
  Piece piece{.texels = {from.texel}};
  std::vector<TexelIndex> cracks;
  seen_[from.texel] |= bit;
  for (std::size_t i = 0; i < piece.texels.size() && !piece.is_sheet; ++i) {
    const TexelIndex texel = piece.texels[i];
    piece.area += surface.weight(texel);
    if (is_loose({.texel = texel, .layer = from.layer})) piece.lost += surface.weight(texel);
    piece.is_sheet = piece.area > most;
    for_each_beside(surface, texel, [&](TexelIndex beside) {
      if (layers_->tops()[beside] < layer) return;
      piece.is_sheet = piece.is_sheet || (in_sheet_[beside] & bit) != 0;
      if ((layers_->cracked()[beside] & bit) != 0) {
        cracks.push_back(beside);
      } else if ((seen_[beside] & bit) == 0) {
        seen_[beside] |= bit;
        piece.texels.push_back(beside);
      }
    });
  }
  marked_.insert(marked_.end(), piece.texels.begin(), piece.texels.end());
  if (piece.is_sheet) {
    for (const TexelIndex texel : piece.texels) in_sheet_[texel] |= bit;
  } else {
    piece.texels.insert(piece.texels.end(), cracks.begin(), cracks.end());
  }
  return piece;
}

std::vector<LayerTexel> CrackCells::falling(std::vector<LayerTexel> loosened) {
  std::sort(loosened.begin(), loosened.end());
  seen_.resize(layers_->cracked().size());
  in_sheet_.resize(seen_.size());
  std::vector<LayerTexel> out;
  for (const LayerTexel& at : loosened) {
    const bool is_cracked = (layers_->cracked()[at.texel] >> at.layer & 1) != 0;
    if (is_cracked && is_outermost(at)) out.push_back(at);
    if (is_cracked || (seen_[at.texel] >> at.layer & 1) != 0) continue;
    const Piece piece = piece_at(at);
    const bool falls = static_cast<double>(piece.lost) >= kLostShare * static_cast<double>(piece.area);
    if (!piece.is_sheet && !falls) continue;
    for (const TexelIndex texel : piece.texels) {
      const LayerTexel each{.texel = texel, .layer = at.layer};
      if (!piece.is_sheet || (is_loose(each) && is_outermost(each))) out.push_back(each);
    }
  }
  for (const TexelIndex texel : marked_) seen_[texel] = in_sheet_[texel] = 0;
  marked_.clear();
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace patinate::simulation
