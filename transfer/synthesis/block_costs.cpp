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

BlockCosts::BlockCosts(const DestinationLevel& destination, const TexelNeighborhood& beside,
                       const SeamFeatures& features)
    : map_(*destination.map),
      turns_(destination.placement.turns.get()),
      beside_(beside),
      features_(features),
      columns_(num_blocks(map_.width())),
      rows_(num_blocks(map_.height())),
      costs_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

void BlockCosts::measure(const PlaceMap& places, const RunControl& control) {
  parallel_for(rows_, 1, control, [&](std::int64_t begin, std::int64_t end) {
    TexelNeighborhood::Cursor cursor(beside_);
    for (std::int64_t row = begin; row < end; ++row) {
      std::int64_t* const first = costs_.data() + row * columns_;
      std::fill(first, first + columns_, 0);
      const int y0 = static_cast<int>(row) * kBlock;
      for (int y = y0; y < std::min(y0 + kBlock, map_.height()); ++y) {
        for (int x = 0; x < map_.width(); ++x) {
          const TexelId t = TexelId{y} * map_.width() + x;
          if (map_.is_covered(t)) first[x / kBlock] += texel_cost(t, cursor, places);
        }
      }
    }
  });
}

std::int64_t BlockCosts::around(std::size_t block) const {
  const int at = static_cast<int>(block), x = at % columns_, y = at / columns_;
  std::int64_t sum = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (x + dx >= 0 && x + dx < columns_ && y + dy >= 0 && y + dy < rows_)
        sum += costs_[std::int64_t{y + dy} * columns_ + x + dx];
    }
  }
  return sum;
}

TexelId BlockCosts::texel_in(std::size_t block) const {
  const int at = static_cast<int>(block), x0 = at % columns_ * kBlock, y0 = at / columns_ * kBlock;
  TexelId best = -1;
  int least = kBlock * kBlock;
  for (int y = y0; y < std::min(y0 + kBlock, map_.height()); ++y) {
    for (int x = x0; x < std::min(x0 + kBlock, map_.width()); ++x) {
      const TexelId t = TexelId{y} * map_.width() + x;
      const int away = std::abs(x - x0 - kBlock / 2) + std::abs(y - y0 - kBlock / 2);
      if (!map_.is_covered(t) || away >= least) continue;
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
