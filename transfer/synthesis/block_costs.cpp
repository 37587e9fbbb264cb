#include "transfer/synthesis/block_costs.h"

#include <algorithm>
#include <cstdlib>

#include "libcommon/core/parallel.h"
#include "transfer/synthesis/surface_patch.h"

namespace patinate::transfer {

namespace {

constexpr int kBlock = 8;  // Texels.

int num_blocks(int texels) { return (texels + kBlock - 1) / kBlock; }

}  // namespace

BlockCosts::BlockCosts(const DestinationLevel& destination, const RefinedRegion& region,
                       const TexelNeighborhood& beside, const SeamFeatures& features)
    : map_(*destination.map),
      turns_(destination.placement.turns.get()),
      region_(region),
      beside_(beside),
      features_(features) {
  std::size_t num = 0;
  for (const TexelRect& rect : region.rects) {
    blocks_.push_back(
        {.rect = rect, .columns = num_blocks(rect.width()), .rows = num_blocks(rect.height()), .first = num});
    num += static_cast<std::size_t>(blocks_.back().columns) * static_cast<std::size_t>(blocks_.back().rows);
  }
  costs_.resize(num);
}

void BlockCosts::measure(const PlaceMap& places, const RunControl& control) {
  for (const Blocks& b : blocks_) {
    parallel_for(b.rows, 1, control, [&](std::int64_t begin, std::int64_t end) {
      TexelNeighborhood::Cursor cursor(beside_);
      for (std::int64_t row = begin; row < end; ++row) {
        std::int64_t* const first = costs_.data() + b.first + row * b.columns;
        std::fill(first, first + b.columns, 0);
        const int y0 = b.rect.y0 + static_cast<int>(row) * kBlock;
        for (int y = y0; y < std::min(y0 + kBlock, b.rect.y1); ++y) {
          for (int x = b.rect.x0; x < b.rect.x1; ++x) {
            const TexelId t = TexelId{y} * map_.width() + x;
            if (map_.is_covered(t) && region_.has(t)) first[(x - b.rect.x0) / kBlock] += texel_cost(t, cursor, places);
          }
        }
      }
    });
  }
}

const BlockCosts::Blocks& BlockCosts::blocks_with(std::size_t block) const {
  std::size_t i = blocks_.size() - 1;
  while (blocks_[i].first > block) --i;
  return blocks_[i];
}

std::int64_t BlockCosts::around(std::size_t block) const {
  const Blocks& b = blocks_with(block);
  const int at = static_cast<int>(block - b.first), x = at % b.columns, y = at / b.columns;
  std::int64_t sum = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (x + dx >= 0 && x + dx < b.columns && y + dy >= 0 && y + dy < b.rows)
        sum += costs_[b.first + static_cast<std::size_t>((y + dy) * b.columns + x + dx)];
    }
  }
  return sum;
}

TexelId BlockCosts::texel_in(std::size_t block) const {
  const Blocks& b = blocks_with(block);
  const int at = static_cast<int>(block - b.first);
  const int x0 = b.rect.x0 + at % b.columns * kBlock, y0 = b.rect.y0 + at / b.columns * kBlock;
  TexelId best = -1;
  int least = kBlock * kBlock;
  for (int y = y0; y < std::min(y0 + kBlock, b.rect.y1); ++y) {
    for (int x = x0; x < std::min(x0 + kBlock, b.rect.x1); ++x) {
      const TexelId t = TexelId{y} * map_.width() + x;
      const int away = std::abs(x - x0 - kBlock / 2) + std::abs(y - y0 - kBlock / 2);
      if (!map_.is_covered(t) || !region_.has(t) || away >= least) continue;
      best = t;
      least = away;
    }
  }
  return best;
}

std::int64_t BlockCosts::texel_cost(TexelId t, TexelNeighborhood::Cursor& cursor, const PlaceMap& places) const {
  const Place here = places.at(t);
  std::int64_t sum = 0;
  for_each_pair(t, cursor.at(t).subspan(beside_.first_adjacent()), map_.width(),
                [&](const PixelNeighbor& n, bool is_earlier, int weight) {
                  if (is_earlier) return;
                  const Turn turn =
                      turns_ == nullptr ? Turn{0} : turns_->between(map_.triangle(t), map_.triangle(n.texel));
                  sum += weight * features_.seam(here, places.at(n.texel), {n.x, n.y}, turn);
                });
  return sum;
}

}  // namespace patinate::transfer
