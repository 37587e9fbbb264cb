#include "transfer/synthesis/window_search.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "libcommon/core/instruction_set.h"

namespace patinate::transfer {

namespace {

constexpr std::int64_t kUnbounded = std::numeric_limits<std::int64_t>::max();

const ReachKernel& reach_kernel() {
#if defined(__x86_64__)
  const InstructionSet set = instruction_set();
  if (set == InstructionSet::Avx512) return reach_avx512::kKernel;
  if (set == InstructionSet::Avx2) return reach_avx2::kKernel;
#endif
  return reach_baseline::kKernel;
}

/// How far a projection may be from a texel's when the pixel's cost does not exceed a bound.
class Reach {
 public:
  /// @param cost  With a coherence scale > 0.
  explicit Reach(const TexelCost& cost)
      : reach_(window_kernel::reach_of(cost.coherence_scale(), cost.first_control_scale(), cost.first_target())) {}
  /// Limits the search to pixels that cost at most `bound`.
  void tighten(std::int64_t bound) { limit_ = window_kernel::reach_within(&reach_, bound); }
  /// Part of the squared distance that the difference of controls in [low, high] alone takes.
  [[nodiscard]] std::int64_t taken(int low, int high) const { return window_kernel::reach_taken(&reach_, low, high); }
  [[nodiscard]] std::int64_t limit() const { return limit_; }

 private:
  window_kernel::ProjectionReach reach_;
  std::int64_t limit_ = 0;
};

bool meets(const SearchWindow& extent, const SearchWindow& window) {
  return extent.x0 < window.x1 && extent.x1 > window.x0 && extent.y0 < window.y1 && extent.y1 > window.y0;
}
bool is_in_window(const SearchWindow& extent, const SearchWindow& window) {
  return extent.x0 >= window.x0 && extent.x1 <= window.x1 && extent.y0 >= window.y0 && extent.y1 <= window.y1;
}

/// Calls each(tile) for the tiles that have pixels in the window.
template <class Each>
void for_tiles(const PixelBlocks& blocks, const SearchWindow& window, const Each& each) {
  const auto look = [&](std::size_t t) {
    if (meets(blocks.tiles[t].extent, window)) each(blocks.tiles[t]);
  };
  if (blocks.tiles_x == 0) {
    for (std::size_t t = 0; t < blocks.tiles.size(); ++t) look(t);
    return;
  }
  constexpr int kSide = PixelTile::kSide;
  for (int ty = window.y0 / kSide; ty * kSide < window.y1; ++ty) {
    for (int tx = window.x0 / kSide; tx * kSide < window.x1; ++tx)
      look(static_cast<std::size_t>(ty * blocks.tiles_x + tx));
  }
}

}  // namespace

/// Least so far; the lower index among equals, as a search row by row finds it.
struct WindowSearch::Best {
  WindowOptimum optimum{-1, kUnbounded};
  std::vector<std::int32_t>* within = nullptr;  ///< Takes all that cost no more than the optimum, which then stays.

  /// Bound that a cost must stay below for `pixel` to win.
  [[nodiscard]] std::int64_t bound(std::int32_t pixel) const {
    return optimum.pixel < 0 ? kUnbounded : optimum.cost + (pixel < optimum.pixel ? 1 : 0);
  }
  void offer(const TexelCost& cost, std::int32_t pixel) {
    if (within != nullptr) {
      if (cost.total(pixel, optimum.cost + 1) <= optimum.cost) within->push_back(pixel);
      return;
    }
    const std::int64_t limit = bound(pixel);
    const std::int64_t c = cost.total(pixel, limit);
    if (c < limit) optimum = {pixel, c};
  }
};

/// A texel's projected neighborhood, and which pixels can be as near to it as they must be.
class WindowSearch::Query {
 public:
  /// @param quarters  Whose values count.
  Query(const NeighborhoodProjection& projection, const TexelCost& cost, unsigned quarters, std::size_t size)
      : reach_(cost) {
    std::array<std::int16_t, NeighborhoodProjection::kMaxAppearances> appearances;
    const std::span<std::int16_t> around = std::span(appearances).first(size);
    cost.appearances(around);
    values_ = projection.of(around);
    for (std::size_t j = 0; j < counts_.size(); ++j) counts_[j] = (quarters >> (j / kNumQuarters) & 1U) != 0 ? -1 : 0;
  }
  /// Limits the search to pixels that cost at most `bound`.
  void tighten(std::int64_t bound) { reach_.tighten(bound); }
  [[nodiscard]] const Reach& reach() const { return reach_; }
  /// Limit of squared distances.
  [[nodiscard]] std::int32_t limit() const {
    return static_cast<std::int32_t>(std::min<std::int64_t>(reach_.limit(), std::numeric_limits<std::int32_t>::max()));
  }
  [[nodiscard]] const std::int16_t* values() const { return values_.data(); }
  [[nodiscard]] const std::int16_t* counts() const { return counts_.data(); }

 private:
  Reach reach_;
  ProjectedNeighborhood values_{}, counts_{};
};

WindowSearch::Table WindowSearch::make_table(const Neighborhood& neighborhood, NeighborhoodProjection::Parts parts,
                                             int side, const RunControl& control) const {
  NeighborhoodProjection projection(source_, neighborhood, parts);
  PixelBlocks blocks = PixelBlocks::make(source_, projection,
                                         2 * std::int64_t{side} < std::max(source_.width(), source_.height())
                                             ? PixelBlocks::Tiles::Squares
                                             : PixelBlocks::Tiles::Anywhere,
                                         control);
  return {std::move(projection), std::move(blocks)};
}

WindowSearch::WindowSearch(const SourceLevel& source, const Neighborhood& neighborhood, int side,
                           const RunControl& control)
    : source_(source),
      squares_(source),
      whole_(make_table(neighborhood, NeighborhoodProjection::Parts::Whole, side, control)),
      quarters_(make_table(neighborhood, NeighborhoodProjection::Parts::Quarters, side, control)),
      num_appearances_(neighborhood.offsets.size() * kAppearanceSize),
      kernel_(reach_kernel()) {}

SearchWindow WindowSearch::window(std::int64_t x, std::int64_t y, int side) const {
  return window_kernel::window_around(x, y, side, source_.width(), source_.height());
}

bool WindowSearch::is_in(const SearchWindow& window, std::int32_t pixel) const {
  return window_kernel::window_holds(window, pixel, source_.width());
}

WindowOptimum WindowSearch::find(const TexelCost& cost, const SearchWindow& window,
                                 std::span<const std::int32_t> likely) const {
  Best best;
  for (std::int32_t p : likely) {
    if (p >= 0 && source_.is_usable[p] != 0 && is_in(window, p)) best.offer(cost, p);
  }
  search(cost, window, best);
  return best.optimum;
}

std::vector<std::int32_t> WindowSearch::find_within(const TexelCost& cost, const SearchWindow& window,
                                                    std::int64_t bound) const {
  std::vector<std::int32_t> pixels;
  Best best{.optimum = {-1, bound}, .within = &pixels};
  search(cost, window, best);
  std::sort(pixels.begin(), pixels.end());
  return pixels;
}

void WindowSearch::search(const TexelCost& cost, const SearchWindow& window, Best& best) const {
  const unsigned quarters = cost.whole_quarters();
  if (!window_kernel::compares_projections(cost.coherence_scale(), quarters, cost.num_known(),
                                           static_cast<std::int32_t>(num_appearances_ / kAppearanceSize))) {
    search_by_control(cost, window, best);
  } else {
    search_by_projection(quarters == kAllQuarters ? whole_ : quarters_, cost, quarters, window, best);
  }
}

void WindowSearch::search_by_control(const TexelCost& cost, const SearchWindow& window, Best& best) const {
  constexpr int kSide = PixelSquares::kSide;
  for (int sy = window.y0 / kSide; sy * kSide < window.y1; ++sy) {
    for (int sx = window.x0 / kSide; sx * kSide < window.x1; ++sx) {
      const auto square = static_cast<std::size_t>(sy * squares_.squares_x + sx);
      const bool is_whole = is_in_window({sx * kSide, sy * kSide, (sx + 1) * kSide, (sy + 1) * kSide}, window);
      const auto first = squares_.controls.begin() + squares_.begin[square],
                 last = squares_.controls.begin() + squares_.begin[square + 1];
      const ControlInterval allowed = cost.first_control_within(best.optimum.cost);
      for (auto at = std::lower_bound(first, last, allowed.low); at != last && *at <= allowed.high; ++at) {
        const std::int32_t p = squares_.pixels[at - squares_.controls.begin()];
        if (is_whole || is_in(window, p)) best.offer(cost, p);
      }
    }
  }
}

void WindowSearch::search_by_projection(const Table& table, const TexelCost& cost, unsigned quarters,
                                        const SearchWindow& window, Best& best) const {
  const PixelBlocks& all = table.blocks;
  Query query(table.projection, cost, quarters, num_appearances_);
  query.tighten(best.optimum.cost);

  struct Near {
    std::int64_t distance;
    std::int32_t index;  ///< Index of a block, or a pixel.
  };
  const auto is_nearer = [](const Near& a, const Near& b) { return a.distance < b.distance; };
  std::vector<Near> blocks, pixels;
  blocks.reserve(256);
  alignas(64) std::array<std::int32_t, PixelBlock::kSize> distances;
  for_tiles(all, window, [&](const PixelTile& tile) {
    const std::int32_t limit = query.limit();
    const unsigned in_use = (1U << (tile.last_block - tile.first_block)) - 1U;
    for (unsigned mask = in_use & kernel_.boxes(all.boxes.data() + (&tile - all.tiles.data()), query.values(),
                                                query.counts(), limit, distances.data());
         mask != 0; mask &= mask - 1) {
      const int i = std::countr_zero(mask);
      const PixelBlock& block = all.blocks[tile.first_block + i];
      const std::int64_t distance = distances[i] + query.reach().taken(block.low_control, block.high_control);
      if (distance <= query.reach().limit() && meets(block.extent, window))
        blocks.push_back({distance, tile.first_block + i});
    }
  });

  // The nearest blocks first, a few at a time: what is found in them leaves less to look at in the others.
  constexpr int kGroupsPerBlock = PixelBlock::kSize / kGroupSize;
  std::array<std::uint16_t, kGroupsPerBlock> masks{};
  std::size_t batch = 4;
  for (std::size_t begin = 0; begin < blocks.size(); begin += batch, batch *= 4) {
    const std::size_t end = std::min(blocks.size(), begin + batch);
    if (end < blocks.size())
      std::nth_element(blocks.begin() + static_cast<std::ptrdiff_t>(begin),
                       blocks.begin() + static_cast<std::ptrdiff_t>(end), blocks.end(), is_nearer);
    pixels.clear();
    // Memory that is far costs more than all else here.
    const auto fetch_block = [&](std::size_t n) {
      if (n >= end) return;
      const ProjectedGroup* groups = all.groups.data() + std::ptrdiff_t{blocks[n].index} * kGroupsPerBlock;
      const auto first = static_cast<std::size_t>(all.blocks[blocks[n].index].begin);
      for (int g = 0; g < kGroupsPerBlock; ++g) {
        for (int pair = 0; pair < 4; ++pair) __builtin_prefetch(groups[g].values[pair]);
        __builtin_prefetch(all.pixels.data() + first + static_cast<std::size_t>(g * kGroupSize));
      }
      __builtin_prefetch(all.controls.data() + first);
    };
    for (std::size_t n = begin; n < begin + 3; ++n) fetch_block(n);
    for (std::size_t n = begin; n < end; ++n) {
      fetch_block(n + 3);
      if (blocks[n].distance > query.reach().limit()) continue;
      const PixelBlock& block = all.blocks[blocks[n].index];
      const bool is_whole = is_in_window(block.extent, window);
      const int size = block.end - block.begin, num_groups = (size + kGroupSize - 1) / kGroupSize;
      kernel_.points(all.groups.data() + std::ptrdiff_t{blocks[n].index} * kGroupsPerBlock, num_groups, query.values(),
                     query.counts(), query.limit(), distances.data(), masks.data());
      for (int g = 0; g < num_groups; ++g) {
        for (unsigned mask = masks[g]; mask != 0; mask &= mask - 1) {
          const int i = g * kGroupSize + std::countr_zero(mask);
          if (i >= size) break;
          const int known = all.controls[block.begin + i];
          const std::int64_t distance = distances[i] + query.reach().taken(known, known);
          const std::int32_t pixel = all.pixels[block.begin + i];
          if (distance <= query.reach().limit() && (is_whole || is_in(window, pixel))) {
            pixels.push_back({distance, pixel});
            __builtin_prefetch(source_.controls.data() + std::int64_t{pixel} * source_.controls.channels());
            for (int dy = -1; dy <= 1; ++dy)
              __builtin_prefetch(source_.appearance.data() +
                                 (std::int64_t{pixel} + std::int64_t{dy} * source_.width()) * kAppearanceSize);
          }
        }
      }
    }
    std::sort(pixels.begin(), pixels.end(), is_nearer);
    for (const Near& n : pixels) {
      if (n.distance > query.reach().limit()) break;
      const std::int64_t before = best.optimum.cost;
      best.offer(cost, n.index);
      if (best.optimum.cost < before) query.tighten(best.optimum.cost);
    }
  }
}

WindowOptimum WindowSearch::find_exhaustively(const TexelCost& cost, const SearchWindow& window) const {
  Best best;
  for (int y = window.y0; y < window.y1; ++y) {
    for (int x = window.x0; x < window.x1; ++x) {
      const std::int32_t p = y * source_.width() + x;
      if (source_.is_usable[p] != 0) best.offer(cost, p);
    }
  }
  return best.optimum;
}

}  // namespace patinate::transfer
