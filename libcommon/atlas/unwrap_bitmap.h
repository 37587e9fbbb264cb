/// \file
/// Charts as cells of a square grid, and the grid that they are placed on.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libcommon/atlas/unwrap_flatten.h"

namespace patinate {

/// The cells that a chart touches. x right, y up, as UVs.
struct ChartBitmap {
  int width = 0, height = 0;
  std::vector<std::uint8_t> cells;  ///< 0 / 1; y * width + x.

  /// By 90 degrees counter-clockwise, `turns` times; cell (x, y) goes to (height - 1 - y, x).
  [[nodiscard]] ChartBitmap turned(int turns) const;
};

/// Every cell that a triangle of the chart touches. @param chart  Points >= 0.
[[nodiscard]] ChartBitmap rasterize(const FlatChart& chart, double cells_per_unit);

struct Spot {
  int x = 0, y = 0;  ///< Cells.
};

/// A rectangle of cells, `margin` of them along its edges never used.
class Occupancy {
 public:
  Occupancy(int width, int height, int margin);

  /// The lowest, then leftmost spot at or after `from` where a bitmap keeps `gutter` cells from all others and its top,
  /// y + height, stays below `limit`.
  [[nodiscard]] std::optional<Spot> find(const ChartBitmap& bitmap, int gutter, int limit, Spot from = {}) const;
  void add(const ChartBitmap& bitmap, Spot spot);

 private:
  struct Run {
    int row, begin, end;
  };
  [[nodiscard]] static std::vector<Run> grown_runs(const ChartBitmap& bitmap, int gutter);
  /// First x >= from in row y where all runs are free; > last_x if none.
  [[nodiscard]] int first_free_x(const std::vector<Run>& runs, int gutter, int y, int from, int last_x) const;

  int width_;
  int height_;
  int margin_;
  std::vector<std::int16_t> next_occupied_;  ///< Per cell, the nearest occupied x at or right of it; width if none.
};

}  // namespace patinate
