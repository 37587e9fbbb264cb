#include "libcommon/atlas/unwrap_pack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "libcommon/atlas/unwrap_bitmap.h"
#include "libcommon/core/error.h"

namespace patinate {

namespace {

constexpr int kCoarseGrid = 256;   ///< Most cells along a side while orders are compared.
constexpr int kFineGrid = 1024;    ///< Most cells along a side at the end.
constexpr int kCoarseTries = 5;
constexpr int kFineTries = 4;
constexpr int kMaxTries = 60;      ///< Until all charts find room at all.
constexpr double kScaleStep = 1.003;
constexpr double kFirstFill = 0.75;          ///< Share of the square that the first try hopes to fill.
constexpr std::size_t kManyCharts = 3000;    ///< Smaller ones than the largest so many are placed row by row.

double cross2(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Counter-clockwise [Andrew 1979, monotone chain].
std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(), [](const Vec2& a, const Vec2& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  std::vector<Vec2> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t begin = hull.size();
    for (const Vec2& p : points) {
      while (hull.size() >= begin + 2 && cross2(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0.0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// Turns a chart so that its box is the smallest (one side lies on a side of the hull), lying, its low corner at the origin.
void turn_to_smallest_box(FlatChart& chart) {
  const std::vector<Vec2> hull = convex_hull(chart.points);
  double smallest = -1.0;
  Vec2 best(1.0, 0.0);
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2 along = hull[(i + 1) % hull.size()] - hull[i];
    if (!(along.norm() > 0.0)) continue;
    const Vec2 x = along.normalized(), y(-x.y(), x.x());
    Vec2 low(1e300, 1e300), high(-1e300, -1e300);
    for (const Vec2& p : hull) {
      const Vec2 q(x.dot(p), y.dot(p));
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
    const Vec2 size = high - low;
    if (smallest >= 0.0 && !(size.x() * size.y() < smallest * (1.0 - 1e-9))) continue;
    smallest = size.x() * size.y();
    best = size.x() >= size.y() ? x : Vec2(y.x(), y.y());
  }
  Vec2 low(1e300, 1e300);
  for (Vec2& p : chart.points) {
    p = Vec2(best.dot(p), -best.y() * p.x() + best.x() * p.y());
    low = low.cwiseMin(p);
  }
  for (Vec2& p : chart.points) p -= low;
}

struct Placement {
  Occupancy::Spot spot;
  int turns = 0;   ///< By 90 degrees, counter-clockwise.
  int width = 0, height = 0;  ///< Cells of the chart's bitmap before it is turned.
};

struct Layout {
  std::vector<Placement> placements;  ///< Per chart.
  int reach = 0;                      ///< Cells that the square of all charts needs, its margin included.
};

/// The square grid of one try.
struct PackGrid {
  int side = 0;             ///< Cells.
  int texels_per_cell = 1;
  int gutter = 1;           ///< Cells.
  [[nodiscard]] int margin() const { return (gutter + 1) / 2; }
};

PackGrid make_grid(int resolution, int most_cells, int gutter_texels) {
  PackGrid grid;
  grid.texels_per_cell = (resolution + most_cells - 1) / most_cells;
  grid.side = resolution / grid.texels_per_cell;
  grid.gutter = (gutter_texels + grid.texels_per_cell - 1) / grid.texels_per_cell;
  return grid;
}

/// Places all charts at one scale on a square a third larger than the grid; nothing if that does not do.
std::optional<Layout> lay_out(const std::vector<FlatChart>& charts, const std::vector<std::size_t>& order, const PackGrid& grid,
                              double cells_per_unit, const RunControl& control) {
  const int side = grid.side + grid.side / 3;
  Occupancy occupancy(side, grid.margin());
  Layout layout{std::vector<Placement>(charts.size()), 0};
  Occupancy::Spot cursor;
  for (std::size_t n = 0; n < order.size(); ++n) {
    control.throw_if_stopped();
    const FlatChart& chart = charts[order[n]];
    Placement& placement = layout.placements[order[n]];
    const ChartBitmap bitmap = rasterize(chart, cells_per_unit);
    placement.width = bitmap.width;
    placement.height = bitmap.height;
    ChartBitmap placed;
    if (n < kManyCharts) {
      int limit = side + 1;
      for (int turns = 0; turns < (bitmap.width * bitmap.height == 1 ? 1 : 4); ++turns) {
        ChartBitmap turned = bitmap.turned(turns);
        const auto spot = occupancy.find(turned, grid.gutter, limit);
        if (!spot) continue;
        limit = std::max(spot->x + turned.width, spot->y + turned.height);
        placement.spot = *spot;
        placement.turns = turns;
        placed = std::move(turned);
      }
      if (placed.cells.empty()) return std::nullopt;
    } else {
      const auto spot = occupancy.find_next(bitmap, grid.gutter, grid.side - grid.margin() + 1, cursor);
      if (!spot) return std::nullopt;
      placement.spot = cursor = *spot;
      placed = bitmap;
    }
    occupancy.add(placed, placement.spot);
    layout.reach = std::max({layout.reach, placement.spot.x + placed.width + grid.margin(), placement.spot.y + placed.height + grid.margin()});
  }
  return layout;
}

/// The best of a search over scales.
struct Search {
  std::optional<Layout> best;
  double best_scale = 0.0;  ///< Cells per unit.

  void run(const std::vector<FlatChart>& charts, const std::vector<std::size_t>& order, const PackGrid& grid, double scale, int tries,
           const RunControl& control) {
    double too_large = 1e300;
    for (int i = 0; i < tries || (!best && i < kMaxTries); ++i) {
      std::optional<Layout> layout = lay_out(charts, order, grid, scale, control);
      const bool fits = layout && layout->reach <= grid.side;
      const double next = layout ? scale * grid.side / layout->reach : 0.8 * scale;
      if (fits && scale > best_scale) {
        best_scale = scale;
        best = std::move(layout);
      }
      if (!fits) too_large = std::min(too_large, scale);
      // What was reached says which scale would just fit; when that is no news, halve the interval that is left.
      const double upper = std::min(too_large, best_scale > 0.0 ? 1.05 * best_scale : too_large);
      scale = next > best_scale && next < upper ? next : (best_scale > 0.0 ? 0.5 * (best_scale + upper) : 0.97 * next);
      if (best && upper < best_scale * kScaleStep) return;
    }
  }
};

std::vector<std::size_t> order_by(const std::vector<FlatChart>& charts, double (*size)(const Vec2& box)) {
  std::vector<double> sizes(charts.size());
  for (std::size_t i = 0; i < charts.size(); ++i) {
    Vec2 high(0.0, 0.0);
    for (const Vec2& p : charts[i].points) high = high.cwiseMax(p);
    sizes[i] = size(high);
  }
  std::vector<std::size_t> order(charts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sizes[a] > sizes[b]; });
  return order;
}

double total_area(const std::vector<FlatChart>& charts) {
  double twice = 0.0;
  for (const FlatChart& chart : charts) {
    for (const Triangle& c : chart.corners) {
      const Vec2& a = chart.points[static_cast<std::size_t>(c[0])];
      twice += cross2(chart.points[static_cast<std::size_t>(c[1])] - a, chart.points[static_cast<std::size_t>(c[2])] - a);
    }
  }
  return 0.5 * twice;
}

void place(FlatChart& chart, const Placement& placement, double cells_per_unit, double side_per_cell) {
  for (Vec2& p : chart.points) {
    Vec2 q = p * cells_per_unit;
    for (int turn = 0; turn < placement.turns; ++turn) q = Vec2((turn % 2 == 0 ? placement.height : placement.width) - q.y(), q.x());
    p = (q + Vec2(placement.spot.x, placement.spot.y)) * side_per_cell;
  }
}

}  // namespace

PackedCharts pack_charts(std::vector<FlatChart> charts, int resolution, int gutter_texels, const RunControl& control) {
  for (FlatChart& chart : charts) turn_to_smallest_box(chart);
  const PackGrid coarse = make_grid(resolution, kCoarseGrid, gutter_texels), fine = make_grid(resolution, kFineGrid, gutter_texels);
  const double area = total_area(charts);
  const std::array orders{order_by(charts, [](const Vec2& box) { return box.maxCoeff(); }),
                          order_by(charts, [](const Vec2& box) { return box.x() * box.y(); })};
  std::size_t best_order = 0;
  double scale = std::sqrt(kFirstFill / area) * fine.side;
  if (charts.size() < kManyCharts && coarse.side < fine.side) {
    double best = 0.0;
    for (std::size_t i = 0; i < orders.size(); ++i) {
      Search search;
      search.run(charts, orders[i], coarse, std::sqrt(kFirstFill / area) * coarse.side, kCoarseTries, control);
      control.report(0.25 * static_cast<double>(i + 1));
      if (search.best_scale > best) best = search.best_scale, best_order = i;
    }
    if (best > 0.0) scale = 1.02 * best * fine.side / coarse.side;  // Finer cells waste less.
  }
  Search search;
  search.run(charts, orders[best_order], fine, scale, kFineTries, control);
  if (!search.best) {
    throw InvalidInput("the mesh has " + std::to_string(charts.size()) + " separate pieces, more than an atlas of " +
                       std::to_string(resolution) + " x " + std::to_string(resolution) + " texels has room for; use a larger atlas");
  }
  const double side_per_cell = static_cast<double>(fine.texels_per_cell) / resolution;
  for (std::size_t i = 0; i < charts.size(); ++i) place(charts[i], search.best->placements[i], search.best_scale, side_per_cell);
  control.report(1.0);
  return {std::move(charts), search.best_scale * side_per_cell};
}

}  // namespace patinate
