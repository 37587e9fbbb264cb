#include "transfer/synthesis/surface_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace patinate::transfer {

PatchFinder::PatchFinder(const TexelMap& map, const TexelNeighborhood& neighbors, const RefinedRegion* region)
    : width_(map.width()),
      first_adjacent_(neighbors.first_adjacent()),
      cursor_(neighbors),
      region_(region),
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

FixedPoint PatchFinder::mean_offset(TexelId texel, const FixedPoint& otherwise, const SurfacePatch& patch) {
  std::int32_t x = 0, y = 0, num = 0;
  for (const PixelNeighbor& n : cursor_.at(texel).subspan(first_adjacent_)) {
    if (n.texel < 0 || n.texel == texel) continue;
    const std::int32_t index = slot_of(n.texel).index;
    if (index < 0) continue;
    const FixedPoint& o = patch.texels[static_cast<std::size_t>(index)].offset;
    x += o.x - n.x;
    y += o.y - n.y;
    ++num;
  }
  if (num == 0) return otherwise;
  const auto rounded = [&](std::int32_t sum) { return static_cast<std::int32_t>(std::floor((sum + 0.5 * num) / num)); };
  return {rounded(x), rounded(y)};
}

void PatchFinder::find_texels(TexelId center, int half_px, SurfacePatch& patch) {
  for (std::size_t at : used_) slots_[at] = {};
  used_.clear();
  patch.half_px = half_px;
  patch.texels.assign(1, {center, {}});
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
      const FixedPoint offset = mean_offset(n.texel, {from.offset.x + n.x, from.offset.y + n.y}, patch);
      if (std::abs(offset.x) > half || std::abs(offset.y) > half || patch.texels.size() >= kMostTexels) continue;
      slot_of(n.texel).index = static_cast<std::int32_t>(patch.texels.size());
      patch.texels.push_back({n.texel, offset});
    }
  }
}

void PatchFinder::find_edges(SurfacePatch& patch) {
  for (std::size_t i = 0; i < patch.texels.size(); ++i) {
    const TexelId texel = patch.texels[i].texel;
    for_each_pair(texel, cursor_.at(texel).subspan(first_adjacent_), width_,
                  [&](const PixelNeighbor& n, bool is_earlier, int weight) {
                    const std::int32_t other = slot_of(n.texel).index;
                    if (is_earlier && other >= 0) return;  // The other one counts it.
                    patch.edges.push_back({.first = static_cast<std::int32_t>(i),
                                           .second = other,
                                           .outside = other >= 0 ? -1 : n.texel,
                                           .step = {n.x, n.y},
                                           .weight = weight});
                  });
  }
}

}  // namespace patinate::transfer
