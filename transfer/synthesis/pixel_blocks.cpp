#include "transfer/synthesis/pixel_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>

#include "libcommon/core/parallel.h"

namespace patinate::transfer {

namespace {

constexpr std::size_t kNumValues = std::tuple_size_v<ProjectedNeighborhood> + 1;  // And the first control.
constexpr int kGroupsPerBlock = PixelBlock::kSize / kGroupSize;

constexpr SearchWindow kNothing{std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), 0, 0};

void include(SearchWindow& extent, const SearchWindow& other) {
  extent = {std::min(extent.x0, other.x0), std::min(extent.y0, other.y0), std::max(extent.x1, other.x1),
            std::max(extent.y1, other.y1)};
}

void set(ProjectedGroup& group, std::size_t i, const ProjectedNeighborhood& p) {
  for (std::size_t j = 0; j < p.size(); ++j) group.values[j / 2][i][j % 2] = p[j];
}

/// Fills the tiles.
class Builder {
 public:
  Builder(const SourceLevel& source, const NeighborhoodProjection& projection, const RunControl& control)
      : source_(source), projections_(source.usable.size()) {
    parallel_for(static_cast<std::int64_t>(projections_.size()), 4096, control,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
                     projections_[i] = projection.of_pixel(source.usable[i]);
                 });
    // A difference in control is as far as one in looks that costs as much, at a coherence share of 3/4 and a
    // neighborhood of radius 3: only speed depends on it.
    constexpr double kShare = 0.75, kWeights = 308.0;
    control_scale_ =
        std::sqrt((1.0 - kShare) / kShare * kWeights * source.appearance_variance / source.control_variances[0]) /
        NeighborhoodProjection::kUnit;
  }

  /// By place: a list for each square of the tiles' side, row by row.
  void fill_squares(PixelBlocks& out) const {
    out.tiles_x = (source_.width() + PixelTile::kSide - 1) / PixelTile::kSide;
    const int tiles_y = (source_.height() + PixelTile::kSide - 1) / PixelTile::kSide;
    std::vector<std::vector<std::int32_t>> ranks(static_cast<std::size_t>(out.tiles_x) *
                                                 static_cast<std::size_t>(tiles_y));
    for (std::size_t i = 0; i < source_.usable.size(); ++i) {
      const int x = source_.usable[i] % source_.width(), y = source_.usable[i] / source_.width();
      ranks[y / PixelTile::kSide * out.tiles_x + x / PixelTile::kSide].push_back(static_cast<std::int32_t>(i));
    }
    for (std::vector<std::int32_t>& tile : ranks) add_tile(tile, out);
  }
  void fill_anywhere(PixelBlocks& out) const {
    std::vector<std::int32_t> ranks(source_.usable.size());
    for (std::size_t i = 0; i < ranks.size(); ++i) ranks[i] = static_cast<std::int32_t>(i);
    split(ranks, std::size_t{PixelTile::kSide} * PixelTile::kSide,
          [&](std::span<std::int32_t> tile) { add_tile(tile, out); });
  }

 private:
  /// Halves the places among the usable pixels by the value that varies most, until no more than `size` are left; parts
  /// are multiples of it, but for the last.
  template <class Each>
  void split(std::span<std::int32_t> ranks, std::size_t size, const Each& each) const {
    if (ranks.size() <= size) return each(ranks);
    const std::size_t by = widest(ranks), half = (ranks.size() / 2 + size - 1) / size * size;
    std::nth_element(
        ranks.begin(), ranks.begin() + static_cast<std::ptrdiff_t>(half), ranks.end(),
        [&](std::int32_t a, std::int32_t b) { return std::pair(value(a, by), a) < std::pair(value(b, by), b); });
    split(ranks.first(half), size, each);
    split(ranks.subspan(half), size, each);
  }
  [[nodiscard]] double value(std::int32_t rank, std::size_t by) const {
    return by + 1 < kNumValues ? double{static_cast<double>(projections_[rank][by])}
                               : control_scale_ * first_control(rank);
  }
  /// By the variance of about a thousand of them.
  [[nodiscard]] std::size_t widest(std::span<const std::int32_t> ranks) const {
    constexpr std::size_t kEnough = 1024;  // Ranks that are looked at, evenly picked.
    std::array<double, kNumValues> sums{}, squares{};
    double count = 0.0;
    for (std::size_t i = 0; i < ranks.size(); i += std::max<std::size_t>(1, ranks.size() / kEnough)) {
      count += 1.0;
      for (std::size_t by = 0; by < kNumValues; ++by) {
        const double v = value(ranks[i], by);
        sums[by] += v;
        squares[by] += v * v;
      }
    }
    for (std::size_t by = 0; by < kNumValues; ++by) squares[by] -= sums[by] * sums[by] / count;
    return static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  }
  [[nodiscard]] std::uint16_t first_control(std::int32_t rank) const {
    return source_.controls.data()[std::int64_t{source_.usable[rank]} * source_.controls.channels()];
  }

  void add_tile(std::span<std::int32_t> ranks, PixelBlocks& out) const {
    PixelTile tile{.extent = kNothing, .first_block = static_cast<std::int32_t>(out.blocks.size())};
    out.boxes.emplace_back();
    if (!ranks.empty())
      split(ranks, PixelBlock::kSize, [&](std::span<std::int32_t> block) {
        add_block(block, out.blocks.size() - static_cast<std::size_t>(tile.first_block), out);
      });
    tile.last_block = static_cast<std::int32_t>(out.blocks.size());
    for (auto b = static_cast<std::size_t>(tile.first_block); b < out.blocks.size(); ++b)
      include(tile.extent, out.blocks[b].extent);
    out.tiles.push_back(tile);
  }
  void add_block(std::span<std::int32_t> ranks, std::size_t in_tile, PixelBlocks& out) const {
    std::sort(ranks.begin(), ranks.end());  // Sort as the usable pixels: by first control, then by index.
    PixelBlock block{.extent = kNothing,
                     .low_control = first_control(ranks.front()),
                     .high_control = first_control(ranks.back()),
                     .begin = static_cast<std::int32_t>(out.pixels.size())};
    const std::size_t first_group = out.groups.size();
    out.groups.resize(first_group + kGroupsPerBlock);
    ProjectedNeighborhood low, high;
    low.fill(std::numeric_limits<std::int16_t>::max());
    high.fill(std::numeric_limits<std::int16_t>::min());
    for (std::size_t i = 0; i < ranks.size(); ++i) {
      const std::int32_t pixel = source_.usable[ranks[i]];
      const int x = pixel % source_.width(), y = pixel / source_.width();
      include(block.extent, {x, y, x + 1, y + 1});
      out.pixels.push_back(pixel);
      out.controls.push_back(first_control(ranks[i]));
      const ProjectedNeighborhood& p = projections_[ranks[i]];
      set(out.groups[first_group + i / kGroupSize], i % kGroupSize, p);
      for (std::size_t j = 0; j < p.size(); ++j) {
        low[j] = std::min(low[j], p[j]);
        high[j] = std::max(high[j], p[j]);
      }
    }
    set(out.boxes.back().low, in_tile, low);
    set(out.boxes.back().high, in_tile, high);
    block.end = static_cast<std::int32_t>(out.pixels.size());
    out.blocks.push_back(block);
  }

  const SourceLevel& source_;
  std::vector<ProjectedNeighborhood> projections_;  ///< Projections of the usable pixels.
  double control_scale_ = 0.0;
};

}  // namespace

PixelSquares::PixelSquares(const SourceLevel& source) : squares_x((source.width() + kSide - 1) / kSide) {
  const auto num_squares =
      static_cast<std::size_t>(squares_x) * static_cast<std::size_t>((source.height() + kSide - 1) / kSide);
  const auto square_of = [&](std::int32_t p) {
    return static_cast<std::size_t>(p / source.width() / kSide * squares_x + p % source.width() / kSide);
  };
  begin.assign(num_squares + 1, 0);
  for (std::int32_t p : source.usable) ++begin[square_of(p) + 1];
  for (std::size_t s = 1; s < begin.size(); ++s) begin[s] += begin[s - 1];
  std::vector<std::int32_t> next(begin.begin(), begin.end() - 1);
  pixels.resize(source.usable.size());
  controls.resize(source.usable.size());
  for (std::int32_t p : source.usable) {  // By first control, then by index.
    const auto at = static_cast<std::size_t>(next[square_of(p)]++);
    pixels[at] = p;
    controls[at] = source.controls.data()[std::int64_t{p} * source.controls.channels()];
  }
}

PixelBlocks PixelBlocks::make(const SourceLevel& source, const NeighborhoodProjection& projection, Tiles tiles,
                              const RunControl& control) {
  PixelBlocks result;
  const Builder builder(source, projection, control);
  if (tiles == Tiles::Squares) {
    builder.fill_squares(result);
  } else {
    builder.fill_anywhere(result);
  }
  return result;
}

}  // namespace patinate::transfer
