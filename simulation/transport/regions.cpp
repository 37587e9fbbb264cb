#include "simulation/transport/regions.h"

#include <utility>

#include "libcommon/core/parallel.h"

namespace patinate::simulation {

namespace {
constexpr std::int64_t kChunk = 32768;  ///< Things, for counting.
}  // namespace

Regions::Regions(const TileGrid& grid, std::uint32_t most_columns) : grid_(grid), most_columns_(most_columns) {
  const auto pages_x = static_cast<std::uint32_t>(grid.pages_x()), pages_y = static_cast<std::uint32_t>(grid.pages_y());
  while (std::max(pages_x, pages_y) > side_ * most_columns) {
    side_ *= 2;
    ++shift_;
  }
  columns_ = (pages_x + side_ - 1) / side_;
  rows_ = (pages_y + side_ - 1) / side_;
  for (std::uint32_t y = 0; y < pages_y; ++y) {
    for (std::uint32_t x = 0; x < pages_x; ++x) {
      region_of_page_.push_back(static_cast<std::uint16_t>(y / side_ * columns_ + x / side_));
      place_of_page_.push_back(static_cast<std::uint16_t>(y % side_ * side_ + x % side_));
    }
  }
}

void RegionLists::fill(std::span<const std::uint16_t> region_of, std::uint32_t num_regions, const RunControl& control) {
  const auto n = static_cast<std::int64_t>(region_of.size());
  const auto num_chunks = static_cast<std::size_t>((n + kChunk - 1) / kChunk);
  const std::size_t row = num_regions + std::size_t{1};  // the last counts what is in none
  const auto column = [&](std::int64_t i) {
    const std::uint16_t region = region_of[i];
    return region == kNone ? std::size_t{num_regions} : std::size_t{region};
  };
  counts_.assign(row * num_chunks, 0);
  parallel_for(n, kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    std::uint32_t* counts = counts_.data() + row * static_cast<std::size_t>(begin / kChunk);
    for (std::int64_t i = begin; i < end; ++i) ++counts[column(i)];
  });
  begin_.clear();
  std::uint32_t sum = 0;
  for (std::size_t r = 0; r <= num_regions; ++r) {
    begin_.push_back(sum);
    for (std::size_t c = 0; c < num_chunks; ++c) sum += std::exchange(counts_[c * row + r], sum);
  }
  things_.resize(region_of.size());
  parallel_for(n, kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    std::uint32_t* at = counts_.data() + row * static_cast<std::size_t>(begin / kChunk);
    for (std::int64_t i = begin; i < end; ++i) things_[at[column(i)]++] = static_cast<std::uint32_t>(i);
  });
}

}  // namespace patinate::simulation
