#include "libcommon/atlas/unwrap_bitmap.h"

#include <algorithm>
#include <cmath>

namespace patinate {

namespace {

constexpr double kTouch = 1e-7;  ///< Cells; rounding never leaves a touched cell out.

struct Span {
  double low = 1e300, high = -1e300;
  void add(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
};

/// x range of a triangle within low <= y <= high.
Span span_between(const std::array<Vec2, 3>& p, double low, double high) {
  Span span;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 &a = p[k], &b = p[(k + 1) % 3];
    if (a.y() >= low && a.y() <= high) span.add(a.x());
    for (double y : {low, high}) {
      if ((a.y() < y) != (b.y() < y)) span.add(a.x() + (b.x() - a.x()) * ((y - a.y()) / (b.y() - a.y())));
    }
  }
  return span;
}

}  // namespace

ChartBitmap ChartBitmap::turned(int turns) const {
  ChartBitmap from = *this;
  for (int turn = 0; turn < turns; ++turn) {
    ChartBitmap to{from.height, from.width, std::vector<std::uint8_t>(from.cells.size())};
    for (int y = 0; y < from.height; ++y) {
      for (int x = 0; x < from.width; ++x) {
        to.cells[static_cast<std::size_t>(x) * static_cast<std::size_t>(to.width) +
                 static_cast<std::size_t>(from.height - 1 - y)] =
            from.cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(from.width) +
                       static_cast<std::size_t>(x)];
      }
    }
    from = std::move(to);
  }
  return from;
}

ChartBitmap rasterize(const FlatChart& chart, double cells_per_unit) {
  Vec2 high(0.0, 0.0);
  for (const Vec2& p : chart.points) high = high.cwiseMax(p);
  ChartBitmap bitmap;
  bitmap.width = static_cast<int>(high.x() * cells_per_unit + kTouch) + 1;
  bitmap.height = static_cast<int>(high.y() * cells_per_unit + kTouch) + 1;
  bitmap.cells.assign(static_cast<std::size_t>(bitmap.width) * static_cast<std::size_t>(bitmap.height), 0);
  for (const Triangle& corners : chart.corners) {
    std::array<Vec2, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = chart.points[corners[k]] * cells_per_unit;
    const double y_low = std::min({p[0].y(), p[1].y(), p[2].y()}) - kTouch,
                 y_high = std::max({p[0].y(), p[1].y(), p[2].y()}) + kTouch;
    const int y0 = std::max(0, static_cast<int>(y_low)), y1 = std::min(bitmap.height - 1, static_cast<int>(y_high));
    for (int y = y0; y <= y1; ++y) {
      const Span span = span_between(p, y - kTouch, y + 1 + kTouch);
      if (span.low > span.high) continue;
      const int x0 = std::max(0, static_cast<int>(span.low - kTouch)),
                x1 = std::min(bitmap.width - 1, static_cast<int>(span.high + kTouch));
      const auto row = bitmap.cells.begin() + static_cast<std::ptrdiff_t>(y) * bitmap.width;
      std::fill(row + x0, row + x1 + 1, std::uint8_t{1});
    }
  }
  return bitmap;
}

Occupancy::Occupancy(int width, int height, int margin)
    : width_(width),
      height_(height),
      margin_(margin),
      next_occupied_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                     static_cast<std::int16_t>(width)) {}

std::vector<Occupancy::Run> Occupancy::grown_runs(const ChartBitmap& bitmap, int gutter) {
  // Rows first, then columns; row and column 0 of the grown bitmap lie `gutter` before the bitmap's.
  const int width = bitmap.width + 2 * gutter, height = bitmap.height + 2 * gutter;
  std::vector<std::uint8_t> wide(static_cast<std::size_t>(width) * static_cast<std::size_t>(bitmap.height), 0);
  for (int y = 0; y < bitmap.height; ++y) {
    const auto from = bitmap.cells.begin() + static_cast<std::ptrdiff_t>(y) * bitmap.width;
    const auto to = wide.begin() + static_cast<std::ptrdiff_t>(y) * width;
    for (int x = 0; x < bitmap.width; ++x) {
      if (from[x] != 0) std::fill(to + x, to + x + 2 * gutter + 1, std::uint8_t{1});
    }
  }
  std::vector<Run> runs;
  std::vector<std::uint8_t> row(static_cast<std::size_t>(width));
  for (int y = 0; y < height; ++y) {
    std::fill(row.begin(), row.end(), std::uint8_t{0});
    for (int from = std::max(0, y - 2 * gutter); from <= std::min(bitmap.height - 1, y); ++from) {
      const auto source = wide.begin() + static_cast<std::ptrdiff_t>(from) * width;
      for (int x = 0; x < width; ++x) row[x] |= source[x];
    }
    for (int x = 0; x < width;) {
      if (row[x] == 0) {
        ++x;
        continue;
      }
      const int begin = x;
      while (x < width && row[x] != 0) ++x;
      runs.push_back({y, begin, x});
    }
  }
  // Long runs meet something first.
  std::stable_sort(runs.begin(), runs.end(),
                   [](const Run& a, const Run& b) { return a.end - a.begin > b.end - b.begin; });
  return runs;
}

int Occupancy::first_free_x(const std::vector<Run>& runs, int gutter, int y, int from, int last_x) const {
  int x = from;
  for (std::size_t free_runs = 0, i = 0; x <= last_x && free_runs < runs.size(); i = i + 1 < runs.size() ? i + 1 : 0) {
    const Run& run = runs[i];
    const int row = y + run.row - gutter;
    const int begin = std::max(0, x + run.begin - gutter), end = x + run.end - gutter;
    const int occupied = row < 0 || row >= height_ || begin >= width_
                             ? width_
                             : next_occupied_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                                              static_cast<std::size_t>(begin)];
    if (occupied >= std::min(end, width_)) {
      ++free_runs;
    } else {
      x = occupied + 1 - run.begin + gutter;  // Past this cell, with all runs to be looked at again.
      free_runs = 0;
    }
  }
  return x;
}

std::optional<Spot> Occupancy::find(const ChartBitmap& bitmap, int gutter, int limit, Spot from) const {
  const std::vector<Run> runs = grown_runs(bitmap, gutter);
  const int last_x = width_ - margin_ - bitmap.width, last_y = std::min(height_ - margin_, limit - 1) - bitmap.height;
  if (last_x < margin_) return std::nullopt;
  for (int y = std::max(margin_, from.y); y <= last_y; ++y) {
    const int x = first_free_x(runs, gutter, y, y == from.y ? std::max(margin_, from.x) : margin_, last_x);
    if (x <= last_x) return Spot{x, y};
  }
  return std::nullopt;
}

void Occupancy::add(const ChartBitmap& bitmap, Spot spot) {
  for (int y = 0; y < bitmap.height; ++y) {
    const auto row = next_occupied_.begin() + static_cast<std::ptrdiff_t>(spot.y + y) * width_;
    const auto cells = bitmap.cells.begin() + static_cast<std::ptrdiff_t>(y) * bitmap.width;
    for (int x = 0; x < bitmap.width; ++x) {
      if (cells[x] != 0) row[spot.x + x] = static_cast<std::int16_t>(spot.x + x);
    }
    std::int16_t next = static_cast<std::int16_t>(width_);
    for (int x = width_ - 1; x >= 0; --x) {
      if (row[x] == x) next = static_cast<std::int16_t>(x);
      row[x] = next;
    }
  }
}

}  // namespace patinate
