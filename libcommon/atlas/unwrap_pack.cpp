#include "libcommon/atlas/unwrap_pack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "libcommon/atlas/raster.h"
#include "libcommon/atlas/unwrap_bitmap.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr int kCoarseGrid = 256;  ///< Most cells along a side while orders are compared.
constexpr int kFineGrid = 512;    ///< Most cells along a side at the end.
constexpr int kCoarseTries = 4;
constexpr std::uint64_t kNumShuffles = 8;  ///< Orders beside the sorted ones that are compared,
constexpr std::size_t kFewCharts =
    150;  ///< where there are no more charts than this: many fill the gaps by themselves.
constexpr int kFineTries = 3;
constexpr std::size_t kNumFinalists = 3;  ///< Orders, of those compared, that are tried on the fine grid.
constexpr int kMaxTries = 60;             ///< Until all charts find room at all.
constexpr double kScaleStep = 1.003;
constexpr double kFirstFill = 0.75;       ///< Share of the square that the first try hopes to fill.
constexpr std::size_t kManyCharts = 400;  ///< Smaller ones than the largest so many are placed row by row.

/// Counter-clockwise [Andrew 1979, monotone chain].
std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  std::vector<Vec2> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t begin = hull.size();
    for (const Vec2& p : points) {
      while (hull.size() >= begin + 2 && cross2(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0.0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// Turns a chart so that its box is the smallest (one side lies on a side of the hull), lying, its low corner at the
/// origin.
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
  Spot spot;
  int turns = 0;              ///< By 90 degrees, counter-clockwise.
  int width = 0, height = 0;  ///< Cells of the chart's bitmap before it is turned.
};

struct Layout {
  std::vector<Placement> placements;  ///< Per chart.
  int top = 0;                        ///< Rows of cells that all charts need, margins included.
};

/// The square grid of one try.
struct PackGrid {
  int side = 0;  ///< Cells.
  int texels_per_cell = 1;
  int gutter = 1;  ///< Cells.
  [[nodiscard]] int margin() const { return (gutter + 1) / 2; }
};

PackGrid make_grid(int resolution, int most_cells, int gutter_texels) {
  PackGrid grid;
  grid.texels_per_cell = (resolution + most_cells - 1) / most_cells;
  grid.side = resolution / grid.texels_per_cell;
  grid.gutter = (gutter_texels + grid.texels_per_cell - 1) / grid.texels_per_cell;
  return grid;
}

/// Places one chart as low as it goes in any turn; false if there is no room.
bool place_lowest(const ChartBitmap& bitmap, const PackGrid& grid, Occupancy& occupancy, Placement& placement, int& top,
                  const RunControl& control) {
  int limit = std::numeric_limits<int>::max();
  ChartBitmap placed;
  for (int turns = 0; turns < (bitmap.width * bitmap.height == 1 ? 1 : 4); ++turns) {
    control.throw_if_stopped();
    ChartBitmap turned = bitmap.turned(turns);
    const auto spot = occupancy.find(turned, grid.gutter, limit);
    if (!spot) continue;
    limit = spot->y + turned.height;
    placement.spot = *spot;
    placement.turns = turns;
    placed = std::move(turned);
  }
  if (placed.cells.empty()) return false;
  occupancy.add(placed, placement.spot);
  top = std::max(top, limit + grid.margin());
  return true;
}

/// Places one chart after the last; false if there is no room.
bool place_next(const ChartBitmap& bitmap, const PackGrid& grid, Occupancy& occupancy, Placement& placement, Spot& last,
                int& top) {
  const auto spot = occupancy.find(bitmap, grid.gutter, std::numeric_limits<int>::max(), last);
  if (!spot) return false;
  placement.spot = last = *spot;
  occupancy.add(bitmap, *spot);
  top = std::max(top, spot->y + bitmap.height + grid.margin());
  return true;
}

/// Places all charts at one scale on a grid as wide as the atlas and a half higher; nothing if that does not do.
std::optional<Layout> lay_out(const std::vector<FlatChart>& charts, const std::vector<std::size_t>& order,
                              const PackGrid& grid, double cells_per_unit, const RunControl& control) {
  Occupancy occupancy(grid.side, grid.side + grid.side / 2, grid.margin());
  Layout layout{std::vector<Placement>(charts.size()), 0};
  Spot last;
  for (std::size_t n = 0; n < order.size(); ++n) {
    control.throw_if_stopped();
    const ChartBitmap bitmap = rasterize(charts[order[n]], cells_per_unit);
    Placement& placement = layout.placements[order[n]];
    placement.width = bitmap.width;
    placement.height = bitmap.height;
    const bool has_room = n < kManyCharts ? place_lowest(bitmap, grid, occupancy, placement, layout.top, control)
                                          : place_next(bitmap, grid, occupancy, placement, last, layout.top);
    if (!has_room) return std::nullopt;
  }
  return layout;
}

/// The best of a search over scales.
struct Search {
  std::optional<Layout> best;
  double best_scale = 0.0;  ///< Cells per unit.

  void run(const std::vector<FlatChart>& charts, const std::vector<std::size_t>& order, const PackGrid& grid,
           double scale, int tries, const RunControl& control) {
    double too_large = 1e300;
    for (int i = 0; i < tries || (!best && i < kMaxTries); ++i) {
      std::optional<Layout> layout = lay_out(charts, order, grid, scale, control);
      const bool fits = layout && layout->top <= grid.side;
      const double next = layout ? scale * std::sqrt(static_cast<double>(grid.side) / layout->top) : 0.8 * scale;
      if (fits && scale > best_scale) {
        best_scale = scale;
        best = std::move(layout);
      }
      if (!fits) too_large = std::min(too_large, scale);
      // Rows grow with the square of the scale, which says which would just fit; when that is no news, halve the
      // interval that is left.
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

/// Charts exchanged with near ones in the order: other packings of about the same quality, of which one is the best.
std::vector<std::size_t> shuffled(std::vector<std::size_t> order, std::uint64_t seed) {
  for (std::size_t i = 0; i + 1 < order.size(); ++i) {
    const std::size_t reach = std::min(order.size() - i, 2 + order.size() / 30);
    std::swap(order[i], order[i + RandomStream(seed, i).below(static_cast<std::uint32_t>(reach))]);
  }
  return order;
}

double total_area(const std::vector<FlatChart>& charts) {
  double twice = 0.0;
  for (const FlatChart& chart : charts) {
    for (const Triangle& c : chart.corners) {
      const Vec2& a = chart.points[c[0]];
      twice += cross2(chart.points[c[1]] - a, chart.points[c[2]] - a);
    }
  }
  return 0.5 * twice;
}

void place(FlatChart& chart, const Placement& placement, double cells_per_unit, double side_per_cell) {
  for (Vec2& p : chart.points) {
    Vec2 q = p * cells_per_unit;
    for (int turn = 0; turn < placement.turns; ++turn)
      q = Vec2((turn % 2 == 0 ? placement.height : placement.width) - q.y(), q.x());
    p = (q + Vec2(placement.spot.x, placement.spot.y)) * side_per_cell;
  }
}

}  // namespace

PackedCharts pack_charts(std::vector<FlatChart> charts, int resolution, int gutter_texels, const RunControl& control) {
  for (FlatChart& chart : charts) {
    control.throw_if_stopped();
    turn_to_smallest_box(chart);
  }
  const PackGrid coarse = make_grid(resolution, kCoarseGrid, gutter_texels),
                 fine = make_grid(resolution, kFineGrid, gutter_texels);
  const double area = total_area(charts);
  std::vector<std::vector<std::size_t>> orders{order_by(charts, [](const Vec2& box) { return box.maxCoeff(); }),
                                               order_by(charts, [](const Vec2& box) { return box.x() * box.y(); })};
  for (std::uint64_t i = 0; i < kNumShuffles && charts.size() <= kFewCharts; ++i)
    orders.push_back(shuffled(orders[i % 2], i));
  std::vector<std::pair<double, std::size_t>> by_scale;  // Coarse cells per unit that an order reaches, and it.
  if (charts.size() < kManyCharts) {
    for (std::size_t i = 0; i < orders.size(); ++i) {
      Search search;
      search.run(charts, orders[i], coarse, std::sqrt(kFirstFill / area) * coarse.side, kCoarseTries, control);
      control.report(0.6 * static_cast<double>(i + 1) / static_cast<double>(orders.size()));
      by_scale.emplace_back(search.best_scale, i);
    }
    std::stable_sort(by_scale.begin(), by_scale.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    by_scale.resize(std::min(by_scale.size(), kNumFinalists));
  } else {
    by_scale.emplace_back(0.0, 0);
  }
  Search search;
  for (std::size_t n = 0; n < by_scale.size(); ++n) {
    const auto [coarse_scale, i] = by_scale[n];
    const double scale =
        coarse_scale > 0.0 ? 1.02 * coarse_scale * fine.side / coarse.side : std::sqrt(kFirstFill / area) * fine.side;
    search.run(charts, orders[i], fine, scale, kFineTries, control);
    control.report(0.6 + 0.4 * static_cast<double>(n + 1) / static_cast<double>(by_scale.size()));
  }
  if (!search.best) {
    throw InvalidInput("the mesh has " + std::to_string(charts.size()) + " separate pieces, more than an atlas of " +
                       std::to_string(resolution) + " x " + std::to_string(resolution) +
                       " texels has room for; use a larger atlas");
  }
  const double side_per_cell = static_cast<double>(fine.texels_per_cell) / resolution;
  for (std::size_t i = 0; i < charts.size(); ++i)
    place(charts[i], search.best->placements[i], search.best_scale, side_per_cell);
  return {std::move(charts), search.best_scale * side_per_cell};
}

}  // namespace patinate
