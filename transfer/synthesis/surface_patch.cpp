#include "transfer/synthesis/surface_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace patinate::transfer {

PatchFinder::PatchFinder(const TexelMap& map, const TexelNeighborhood& neighbors, const FrameTurns* turns)
    : map_(map),
      first_adjacent_(neighbors.first_adjacent()),
      cursor_(neighbors),
      turns_(turns),
      slots_(4 * kMostTexels, -1) {}

void PatchFinder::forget() {
  for (std::size_t at : used_) slots_[at] = -1;
  used_.clear();
  known_.clear();
  rows_.clear();
}

std::int32_t PatchFinder::known_of(TexelId texel) {
  auto at = static_cast<std::size_t>((static_cast<std::uint64_t>(texel) * 0x9E3779B97F4A7C15ull) >> 40) % slots_.size();
  while (slots_[at] >= 0 && known_[slots_[at]].texel != texel) at = (at + 1) % slots_.size();
  if (slots_[at] < 0) {
    slots_[at] = static_cast<std::int32_t>(known_.size());
    known_.push_back({.texel = texel});
    used_.push_back(at);
  }
  return slots_[at];
}

PatchFinder::Row& PatchFinder::row_of(std::int32_t known) {
  if (known_[known].row >= 0) return rows_[known_[known].row];
  known_[known].row = static_cast<std::int32_t>(rows_.size());
  Row& row = rows_.emplace_back();
  row.turns.fill(kNotAsked);
  const TexelId texel = known_[known].texel;
  const auto beside = cursor_.at(texel).subspan(first_adjacent_);
  for (std::size_t k = 0; k < beside.size(); ++k) {
    row.neighbors[k] = beside[k];
    const bool is_other = beside[k].texel >= 0 && beside[k].texel != texel;
    row.known[k] = is_other ? known_of(beside[k].texel) : -1;
  }
  return row;
}

PatchTexel PatchFinder::mean_place(std::int32_t known, const PatchTexel& otherwise, const SurfacePatch& patch) {
  struct Beside {
    FixedPoint offset, step;
  };
  std::array<Beside, TexelNeighborhood::kNumAdjacent> beside;
  std::int32_t turn = 0, num = 0;
  Row& row = row_of(known);
  for (std::size_t k = 0; k < beside.size(); ++k) {
    const std::int32_t index = row.known[k] < 0 ? -1 : known_[row.known[k]].index;
    if (index < 0) continue;
    const PatchTexel& other = patch.texels[index];
    beside[num++] = {other.offset, {row.neighbors[k].x, row.neighbors[k].y}};
    if (turns_ != nullptr) turn += difference_of(difference_of(other.turn, turn_in(row, known, k)), otherwise.turn);
  }
  if (num == 0) return otherwise;
  const auto mean = [&](std::int32_t sum) { return static_cast<std::int32_t>(std::floor((sum + 0.5 * num) / num)); };
  PatchTexel placed{otherwise.texel, {}, sum_of(otherwise.turn, mean(turn))};
  std::int32_t x = 0, y = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(num); ++k) {
    const FixedPoint step = turned(beside[k].step, placed.turn);
    x += beside[k].offset.x - step.x;
    y += beside[k].offset.y - step.y;
  }
  placed.offset = {mean(x), mean(y)};
  return placed;
}

void PatchFinder::find_texels(TexelId center, int half_px, SurfacePatch& patch) {
  if (center != center_) forget();
  center_ = center;
  for (Known& known : known_) known.index = -1;
  patch.half_px = half_px;
  patch.texels.assign(1, {center, {}, 0});
  patch.edges.clear();
  known_[known_of(center)].index = 0;
  const std::int32_t half = half_px * PixelNeighbor::kOne;
  for (std::size_t i = 0; i < patch.texels.size() && patch.texels.size() < kMostTexels; ++i) {
    const PatchTexel from = patch.texels[i];
    const std::int32_t own = known_of(from.texel);
    for (std::size_t k = 0; k < TexelNeighborhood::kNumAdjacent; ++k) {
      Row& row = row_of(own);  // Rows found beside are added, and move the others.
      const PixelNeighbor n = row.neighbors[k];
      const std::int32_t beside = row.known[k];
      if (beside < 0 || known_[beside].index >= 0) continue;
      const FixedPoint step = turned({n.x, n.y}, from.turn);
      const PatchTexel placed = mean_place(
          beside, {n.texel, {from.offset.x + step.x, from.offset.y + step.y}, sum_of(from.turn, turn_in(row, own, k))},
          patch);
      if (std::abs(placed.offset.x) > half || std::abs(placed.offset.y) > half || patch.texels.size() >= kMostTexels)
        continue;
      known_[beside].index = static_cast<std::int32_t>(patch.texels.size());
      patch.texels.push_back(placed);
    }
  }
}

void PatchFinder::find_edges(SurfacePatch& patch) {
  for (std::size_t i = 0; i < patch.texels.size(); ++i) {
    const TexelId texel = patch.texels[i].texel;
    const std::int32_t own = known_of(texel);
    Row& row = row_of(own);
    for_each_pair(texel, row.neighbors, map_.width(), [&](const PixelNeighbor& n, bool is_earlier, int weight) {
      const auto k = static_cast<std::size_t>(&n - row.neighbors.data());
      const std::int32_t other = known_[row.known[k]].index;
      if (is_earlier && other >= 0) return;  // The other one counts it.
      patch.edges.push_back({.first = static_cast<std::int32_t>(i),
                             .second = other,
                             .outside = other >= 0 ? -1 : n.texel,
                             .step = {n.x, n.y},
                             .turn = turn_in(row, own, k),
                             .weight = weight});
    });
  }
}

}  // namespace patinate::transfer
