/// \file
/// Squares of an atlas that are worked on at once: each texel belongs to one of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// Blocks of whole pages, so many along each side at most, whatever the atlas's size: few splats lie across their
/// borders.
class Regions {
 public:
  Regions(const TileGrid& grid, std::uint32_t most_columns);
  /// Along each side: enough for so many threads to be done at the same time, and no more.
  [[nodiscard]] static std::uint32_t columns_for(int num_threads) { return num_threads <= 2 ? 8 : 16; }

  [[nodiscard]] const TileGrid& grid() const { return grid_; }
  [[nodiscard]] std::uint32_t most_columns() const { return most_columns_; }
  [[nodiscard]] std::uint32_t size() const { return columns_ * rows_; }
  [[nodiscard]] std::uint32_t region_of(TexelIndex texel) const { return region_of_page_[TileGrid::page_of(texel)]; }
  /// Number of a texel's page among those of its region, less than pages_each().
  [[nodiscard]] std::uint32_t place_of_page(std::uint32_t page) const { return place_of_page_[page]; }
  [[nodiscard]] std::uint32_t pages_each() const { return side_ * side_; }
  /// Whether the square of `reach` texels around a place lies in one region.
  [[nodiscard]] bool holds(int x, int y, int reach) const {
    const auto block = static_cast<std::uint32_t>(x - reach) >> shift_,
               other = static_cast<std::uint32_t>(x + reach) >> shift_;
    return block == other &&
           static_cast<std::uint32_t>(y - reach) >> shift_ == static_cast<std::uint32_t>(y + reach) >> shift_;
  }

 private:
  TileGrid grid_;
  std::uint32_t most_columns_;
  std::uint32_t side_ = 1;  ///< Pages.
  int shift_ = 6;           ///< A region is 2^shift_ texels wide.
  std::uint32_t columns_ = 1, rows_ = 1;
  std::vector<std::uint16_t> region_of_page_, place_of_page_;
};

/// Numbers of things by the region that they are in, rising in each.
class RegionLists {
 public:
  static constexpr std::uint16_t kNone = 0xFFFF;  ///< In no list.

  /// @param region_of  By thing. @param num_regions  Less than kNone.
  void fill(std::span<const std::uint16_t> region_of, std::uint32_t num_regions, const RunControl& control);
  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t region) const {
    return std::span(things_).subspan(begin_[region], begin_[region + 1] - begin_[region]);
  }

 private:
  std::vector<std::uint32_t> things_, begin_, counts_;
};

}  // namespace patinate::simulation
