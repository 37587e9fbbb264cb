#include "transfer/synthesis/surface_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace patinate::transfer {

PatchFinder::PatchFinder(const TexelMap& map, const TexelNeighborhood& neighbors, const RefinedRegion* region,
                         const FrameTurns* turns)
    : map_(map),
      first_adjacent_(neighbors.first_adjacent()),
      cursor_(neighbors),
      region_(region),
      turns_(turns),
      slots_(4 * kMostTexels) {}

PatchFinder::Slot& PatchFinder::slot_of(TexelId texel) {
  auto at = static_cast<std::size_t>((static_cast<std::uint64_t>(texel) * 0x9E3779B97F4A7C15ull) >> 40) % slots_.size();
  while (slots_[at].texel >= 0 && slots_[at].texel != texel) at = (at + 1) % slots_.size();
  if (slots_[at].texel < 0) {
    slots_[at] = {texel, -1};
    used_.push_back(at);
  }
  return slots_[at];
}

PatchTexel PatchFinder::mean_place(const PatchTexel& otherwise, const SurfacePatch& patch) {
  struct Beside {
    FixedPoint offset, step;
  };
  std::array<Beside, TexelNeighborhood::kNumAdjacent> beside;
  std::int32_t turn = 0, num = 0;
  for (const PixelNeighbor& n : cursor_.at(otherwise.texel).subspan(first_adjacent_)) {
    if (n.texel < 0 || n.texel == otherwise.texel) continue;
    const std::int32_t index = slot_of(n.texel).index;
    if (index < 0) continue;
    const PatchTexel& other = patch.texels[index];
    beside[num++] = {other.offset, {n.x, n.y}};
    if (turns_ != nullptr)
      turn += difference_of(difference_of(other.turn, frame_turn(otherwise.texel, n.texel)), otherwise.turn);
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
  for (std::size_t at : used_) slots_[at] = {};
  used_.clear();
  patch.half_px = half_px;
  patch.texels.assign(1, {center, {}, 0});
  patch.edges.clear();
  slot_of(center).index = 0;
  const std::int32_t half = half_px * PixelNeighbor::kOne;
  for (std::size_t i = 0; i < patch.texels.size() && patch.texels.size() < kMostTexels; ++i) {
    const PatchTexel from = patch.texels[i];
    std::array<PixelNeighbor, TexelNeighborhood::kNumAdjacent> beside;
    std::copy_n(cursor_.at(from.texel).begin() + static_cast<std::ptrdiff_t>(first_adjacent_), beside.size(),
                beside.begin());
    for (const PixelNeighbor& n : beside) {
      if (n.texel < 0 || slot_of(n.texel).index >= 0 || (region_ != nullptr && !region_->has(n.texel))) continue;
      const FixedPoint step = turned({n.x, n.y}, from.turn);
      const PatchTexel placed = mean_place({n.texel,
                                            {from.offset.x + step.x, from.offset.y + step.y},
                                            sum_of(from.turn, frame_turn(from.texel, n.texel))},
                                           patch);
      if (std::abs(placed.offset.x) > half || std::abs(placed.offset.y) > half || patch.texels.size() >= kMostTexels)
        continue;
      slot_of(n.texel).index = static_cast<std::int32_t>(patch.texels.size());
      patch.texels.push_back(placed);
    }
  }
}

void PatchFinder::find_edges(SurfacePatch& patch) {
  for (std::size_t i = 0; i < patch.texels.size(); ++i) {
    const TexelId texel = patch.texels[i].texel;
    for_each_pair(texel, cursor_.at(texel).subspan(first_adjacent_), map_.width(),
                  [&](const PixelNeighbor& n, bool is_earlier, int weight) {
                    const std::int32_t other = slot_of(n.texel).index;
                    if (is_earlier && other >= 0) return;  // The other one counts it.
                    patch.edges.push_back({.first = static_cast<std::int32_t>(i),
                                           .second = other,
                                           .outside = other >= 0 ? -1 : n.texel,
                                           .step = {n.x, n.y},
                                           .turn = frame_turn(texel, n.texel),
                                           .weight = weight});
                  });
  }
}

}  // namespace patinate::transfer
