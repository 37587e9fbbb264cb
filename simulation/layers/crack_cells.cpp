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
  std::vector<TexelIndex> texels;  ///< Of a sheet, those that were looked at.
  std::vector<TexelIndex> cracks;  ///< Around it, some more than once; none of a sheet.
  bool is_sheet = false;
  std::int64_t area = 0, lost = 0;  ///< Weights.
};

CrackCells::Piece CrackCells::piece_at(const LayerTexel& from) {
  const SurfaceAtlas& surface = layers_->surface();
  const int layer = static_cast<int>(from.layer);
  const auto bit = static_cast<std::uint8_t>(1U << from.layer);
  const std::int64_t most = most_area(from);
  Piece piece{.texels = {from.texel}, .cracks = {}};
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
        piece.cracks.push_back(beside);
      } else if ((seen_[beside] & bit) == 0) {
        seen_[beside] |= bit;
        piece.texels.push_back(beside);
      }
    });
  }
  marked_.insert(marked_.end(), piece.texels.begin(), piece.texels.end());
  if (piece.is_sheet) {
    for (const TexelIndex texel : piece.texels) in_sheet_[texel] |= bit;
    piece.cracks.clear();
  }
  return piece;
}

std::int64_t CrackCells::most_area(const LayerTexel& at) const {
  const double texel_mm = layers_->surface().median_texel_size_mm();
  const double side = kMostLengths * relief_length_mm(*layers_, static_cast<int>(at.layer), at.texel) / texel_mm;
  return static_cast<std::int64_t>(side * side * SurfaceAtlas::kMedianWeight);
}

std::uint8_t CrackCells::open_at(TexelIndex texel) const {
  const unsigned there = (2U << layers_->tops()[texel]) - 1;
  return static_cast<std::uint8_t>(layers_->cracked()[texel] | ~there);
}

CrackCells::Cell* CrackCells::cell_at(int layer, TexelIndex texel) {
  const std::uint32_t number = cell_of_[layer].empty() ? 0 : cell_of_[layer][texel];
  return number == 0 || !cells_[number - 1].is_known ? nullptr : &cells_[number - 1];
}

void CrackCells::forget() {
  open_.clear();
  loose_.clear();
  cells_.clear();
  for (std::vector<std::uint32_t>& of : cell_of_) of.clear();
}

void CrackCells::begin_memory() {
  loose_.assign(layers_->loose().begin(), layers_->loose().end());
  open_.resize(loose_.size());
  for (TexelIndex t = 0; t < open_.size(); ++t) open_[t] = open_at(t);
}

void CrackCells::renew(TexelIndex texel) {
  const std::uint8_t open = open_at(texel), loose = layers_->loose()[texel];
  const unsigned opened = open ^ open_[texel], loosened = loose ^ loose_[texel];
  if ((opened | loosened) == 0) return;
  for (int l = 1; l < layers_->num_layers(); ++l) {
    if ((opened >> l & 1) != 0) {
      if (Cell* cell = cell_at(l, texel)) cell->is_known = false;
      for_each_beside(layers_->surface(), texel, [&](TexelIndex beside) {
        if (Cell* cell = (open >> l & 1) != 0 ? nullptr : cell_at(l, beside)) cell->is_known = false;
      });
    }
    Cell* cell = (loosened >> l & 1) != 0 ? cell_at(l, texel) : nullptr;
    if (cell) cell->lost += ((loose >> l & 1) != 0 ? 1 : -1) * std::int64_t{layers_->surface().weight(texel)};
  }
  open_[texel] = open;
  loose_[texel] = loose;
}

void CrackCells::renew(std::span<const TileIndex> tiles) {
  constexpr std::size_t kMostCells = 1 << 20;  // 32 MB.
  if (cells_.size() > kMostCells) forget();
  if (open_.empty()) return begin_memory();
  for (const TileIndex tile : tiles) {
    for (TexelIndex i = 0; i < TileGrid::kTileTexels; ++i) renew(tile * TileGrid::kTileTexels + i);
  }
}

void CrackCells::remember(const Piece& piece, int layer) {
  std::vector<std::uint32_t>& of = cell_of_[layer];
  of.resize(open_.size());
  cells_.push_back({.area = piece.area, .lost = piece.lost});
  for (const TexelIndex texel : piece.texels) of[texel] = static_cast<std::uint32_t>(cells_.size());
}

bool CrackCells::is_known_to_hold(const LayerTexel& at) {
  Cell* cell = cell_at(static_cast<int>(at.layer), at.texel);
  if (cell == nullptr) return false;
  if (cell->looked_at == num_calls_) return true;
  const bool falls = static_cast<double>(cell->lost) >= kLostShare * static_cast<double>(cell->area);
  cell->is_known = !falls && cell->area <= most_area(at);
  cell->looked_at = num_calls_;
  return cell->is_known;
}

std::vector<LayerTexel> CrackCells::falling(std::vector<LayerTexel> loosened) {
  std::sort(loosened.begin(), loosened.end());
  seen_.resize(layers_->cracked().size());
  in_sheet_.resize(seen_.size());
  ++num_calls_;
  std::vector<LayerTexel> out;
  for (const LayerTexel& at : loosened) {
    const bool is_cracked = (layers_->cracked()[at.texel] >> at.layer & 1) != 0;
    if (is_cracked && is_outermost(at)) out.push_back(at);
    if (is_cracked || (seen_[at.texel] >> at.layer & 1) != 0 || is_known_to_hold(at)) continue;
    const Piece piece = piece_at(at);
    const bool falls = static_cast<double>(piece.lost) >= kLostShare * static_cast<double>(piece.area);
    if (!piece.is_sheet && !falls) {
      remember(piece, static_cast<int>(at.layer));
      continue;
    }
    for (const TexelIndex texel : piece.texels) {
      const LayerTexel each{.texel = texel, .layer = at.layer};
      if (!piece.is_sheet || (is_loose(each) && is_outermost(each))) out.push_back(each);
    }
    for (const TexelIndex texel : piece.cracks) out.push_back({.texel = texel, .layer = at.layer});
  }
  for (const TexelIndex texel : marked_) seen_[texel] = in_sheet_[texel] = 0;
  marked_.clear();
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace patinate::simulation
