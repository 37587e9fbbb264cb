#include "capture/chart/chart_quads.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>

#include "capture/chart/chart_table.h"

namespace patinate::capture {

namespace {

constexpr double kBlur_px = 1.2;                                     ///< Takes a camera's grain to a fifth.
constexpr std::array<double, 5> kEdges{4.0, 8.0, 16.0, 32.0, 64.0};  ///< Codes of 255 by two pixels that bound a patch.
constexpr double kMinSide_px = 6.0;                                  ///< Side of a patch, without its blurred border.
constexpr double kLargestShare = 0.03;  ///< Share of the picture: 24 patches fill three quarters of it.
constexpr double kMinFilled = 0.8;      ///< Share of the quad around a patch.
constexpr double kLargestAspect = 1.8;  ///< A patch is a square, tilted by up to 55 degrees.
constexpr double kSame = 0.35;          ///< Share of a side: two quads of one patch.
/// Distance of two middles over the side that is found: patches fill 0.87 of it, less the border that is blurred.
constexpr double kMinStep = 1.02, kLargestStep = 2.2;
constexpr double kSizeRatio = 1.6;       ///< Ratio of neighbors' sizes.
constexpr double kOffPlace = 0.25;       ///< Share of a step that the next quad may lie beside where it is looked for.
constexpr int kFarthest = 12;            ///< Columns or rows from the first quad.
constexpr std::size_t kMaxQuads = 1000;  ///< The largest: texture of a surface has thousands of small ones.
constexpr std::size_t kMaxGrids = 8;
constexpr std::size_t kMinInGrid = 6;

/// Largest change of any channel by two pixels, in codes of 255.
cv::Mat edge_strength(const ImageF& codes) {
  const cv::Mat all(codes.height(), codes.width(), CV_32FC3, const_cast<float*>(codes.data()));
  cv::Mat smooth, dx, dy;
  cv::GaussianBlur(all, smooth, {}, kBlur_px);
  cv::Sobel(smooth, dx, CV_32F, 1, 0, 3, 255.0 / 4.0);
  cv::Sobel(smooth, dy, CV_32F, 0, 1, 3, 255.0 / 4.0);
  cv::Mat strength(codes.height(), codes.width(), CV_32F);
  for (int y = 0; y < strength.rows; ++y) {
    for (int x = 0; x < strength.cols; ++x) {
      const auto& a = dx.at<cv::Vec3f>(y, x);
      const auto& b = dy.at<cv::Vec3f>(y, x);
      float largest = 0.0f;
      for (int c = 0; c < 3; ++c) largest = std::max(largest, std::hypot(a[c], b[c]));
      strength.at<float>(y, x) = largest;
    }
  }
  return strength;
}

std::optional<ChartQuad> quad_of(const std::vector<cv::Point>& contour, double most_area) {
  const double area = cv::contourArea(contour);
  if (area < kMinSide_px * kMinSide_px || area > most_area) return std::nullopt;
  std::vector<cv::Point> hull, corners;
  cv::convexHull(contour, hull);
  constexpr std::array<double, 4> kTolerances{0.06, 0.1, 0.15, 0.2};  // Shares of a side.
  for (const double tolerance : kTolerances) {
    cv::approxPolyDP(hull, corners, tolerance * std::sqrt(area), true);
    if (corners.size() <= 4) break;
  }
  if (corners.size() != 4 || area < kMinFilled * cv::contourArea(corners)) return std::nullopt;
  std::array<Eigen::Vector2d, 4> at;
  for (std::size_t i = 0; i < 4; ++i) at[i] = {corners[i].x, corners[i].y};
  ChartQuad quad;
  quad.along = 0.5 * (at[1] - at[0] + at[2] - at[3]);
  quad.across = 0.5 * (at[3] - at[0] + at[2] - at[1]);
  const double a = quad.along.norm(), b = quad.across.norm();
  if (!(std::min(a, b) > 0.0) || std::max(a, b) > kLargestAspect * std::min(a, b)) return std::nullopt;
  for (std::size_t i = 0; i < 4; ++i) {  // A trapezoid of perspective, but no kite.
    const double side = (at[(i + 1) % 4] - at[i]).norm(), mean = i % 2 == 0 ? a : b;
    if (side < 0.7 * mean || side > 1.4 * mean) return std::nullopt;
  }
  const cv::Moments moments = cv::moments(contour);
  quad.middle = {moments.m10 / moments.m00, moments.m01 / moments.m00};
  return quad;
}

double size_of(const ChartQuad& quad) { return std::sqrt(quad.along.norm() * quad.across.norm()); }

bool are_alike(const ChartQuad& a, const ChartQuad& b) {
  const double ratio = size_of(a) / size_of(b);
  return ratio < kSizeRatio && ratio > 1.0 / kSizeRatio;
}

/// Nearest quad of `like`'s size within `reach` of a place; -1 = none.
int nearest(const std::vector<ChartQuad>& quads, const Eigen::Vector2d& place, double reach, const ChartQuad& like) {
  int best = -1;
  for (std::size_t i = 0; i < quads.size(); ++i) {
    const double distance = (quads[i].middle - place).norm();
    if (distance >= reach || !are_alike(quads[i], like)) continue;
    reach = distance;
    best = static_cast<int>(i);
  }
  return best;
}

/// Step to the next quad in the direction of a side; nothing when none is there, to either side.
std::optional<Eigen::Vector2d> step_along(const std::vector<ChartQuad>& quads, const ChartQuad& from,
                                          const Eigen::Vector2d& side) {
  std::optional<Eigen::Vector2d> best;
  for (const ChartQuad& quad : quads) {
    Eigen::Vector2d step = quad.middle - from.middle;
    const double forward = step.dot(side) / side.squaredNorm();
    const double beside = std::abs(step.x() * side.y() - step.y() * side.x()) / side.squaredNorm();
    if (std::abs(forward) < kMinStep || std::abs(forward) > kLargestStep || beside > kOffPlace * std::abs(forward) ||
        !are_alike(quad, from))
      continue;
    if (forward < 0.0) step = -step;
    if (!best || step.norm() < best->norm()) best = step;
  }
  return best;
}

/// Quads that follow one another from one of them, column by column and row by row.
QuadGrid grow(const std::vector<ChartQuad>& quads, const ChartQuad& first) {
  const std::optional<Eigen::Vector2d> along = step_along(quads, first, first.along);
  const std::optional<Eigen::Vector2d> across = step_along(quads, first, first.across);
  if (!along || !across) return {};
  QuadGrid grid{{{0, 0}, first}};
  std::set<int> used;
  std::deque<std::pair<int, int>> open{{0, 0}};
  constexpr std::array<std::pair<int, int>, 4> kSteps{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  while (!open.empty()) {
    const auto cell = open.front();
    open.pop_front();
    const ChartQuad quad = grid.at(cell);
    for (const auto& [dx, dy] : kSteps) {
      const std::pair<int, int> next{cell.first + dx, cell.second + dy};
      if (grid.contains(next) || std::abs(next.first) > kFarthest || std::abs(next.second) > kFarthest) continue;
      Eigen::Vector2d step = dx != 0 ? Eigen::Vector2d(dx * *along) : Eigen::Vector2d(dy * *across);
      // Perspective changes steps slowly: the one before is the better guess.
      if (const auto before = grid.find({cell.first - dx, cell.second - dy}); before != grid.end())
        step = quad.middle - before->second.middle;
      const int found = nearest(quads, quad.middle + step, kOffPlace * step.norm(), quad);
      if (found < 0 || !used.insert(found).second) continue;
      grid.emplace(next, quads[static_cast<std::size_t>(found)]);
      open.push_back(next);
    }
  }
  return grid;
}

/// Without outer columns and rows, that of fewest quads first, until it may be a part of the chart: a spot beside the
/// chart may stand where a patch would.
QuadGrid trimmed(QuadGrid grid) {
  while (!grid.empty()) {
    std::map<int, int> columns, rows;  // How many quads each has.
    for (const auto& [cell, quad] : grid) {
      ++columns[cell.first];
      ++rows[cell.second];
    }
    const int wide = columns.rbegin()->first - columns.begin()->first + 1;
    const int high = rows.rbegin()->first - rows.begin()->first + 1;
    if (std::max(wide, high) <= kChartColumns && std::min(wide, high) <= kChartRows) break;
    const int fewest_column = std::min(columns.begin()->second, columns.rbegin()->second);
    const int fewest_row = std::min(rows.begin()->second, rows.rbegin()->second);
    const bool is_column =
        std::max(wide, high) > kChartColumns ? wide >= high : fewest_column <= fewest_row;  // By the longer side.
    const std::map<int, int>& counts = is_column ? columns : rows;
    const int gone = counts.begin()->second <= counts.rbegin()->second ? counts.begin()->first : counts.rbegin()->first;
    std::erase_if(grid, [&](const auto& at) { return (is_column ? at.first.first : at.first.second) == gone; });
  }
  return grid;
}

/// Grid with columns and rows from 0.
QuadGrid from_zero(const QuadGrid& grid) {
  if (grid.empty()) return {};
  int left = grid.begin()->first.first, top = grid.begin()->first.second;
  for (const auto& [cell, quad] : grid) {
    left = std::min(left, cell.first);
    top = std::min(top, cell.second);
  }
  QuadGrid moved;
  for (const auto& [cell, quad] : grid) moved.emplace(std::pair(cell.first - left, cell.second - top), quad);
  return moved;
}

bool share_quads(const QuadGrid& a, const QuadGrid& b) {
  for (const auto& [cell, quad] : a) {
    for (const auto& [other_cell, other] : b) {
      if (quad.middle == other.middle) return true;
    }
  }
  return false;
}

}  // namespace

std::vector<ChartQuad> find_quads(const ImageF& codes) {
  const cv::Mat strength = edge_strength(codes);
  const double most_area = kLargestShare * static_cast<double>(codes.num_pixels());
  std::vector<ChartQuad> quads;
  for (const double edge : kEdges) {
    const cv::Mat even = strength < edge;
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(even, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    for (const std::vector<cv::Point>& contour : contours) {
      const std::optional<ChartQuad> quad = quad_of(contour, most_area);
      if (!quad) continue;
      const auto known = std::find_if(quads.begin(), quads.end(), [&](const ChartQuad& other) {
        return (other.middle - quad->middle).norm() < kSame * std::min(size_of(other), size_of(*quad));
      });
      // The larger quad of one patch has more of its pixels.
      if (known == quads.end())
        quads.push_back(*quad);
      else if (size_of(*quad) > size_of(*known))
        *known = *quad;
    }
  }
  std::stable_sort(quads.begin(), quads.end(),
                   [](const ChartQuad& a, const ChartQuad& b) { return size_of(a) > size_of(b); });
  if (quads.size() > kMaxQuads) quads.resize(kMaxQuads);
  return quads;
}

std::vector<QuadGrid> find_grids(const std::vector<ChartQuad>& quads) {
  std::vector<QuadGrid> grids;
  for (const ChartQuad& quad : quads) {
    const QuadGrid grid = from_zero(trimmed(grow(quads, quad)));
    if (grid.size() >= kMinInGrid) grids.push_back(grid);
  }
  std::stable_sort(grids.begin(), grids.end(),
                   [](const QuadGrid& a, const QuadGrid& b) { return a.size() > b.size(); });
  std::vector<QuadGrid> different;
  for (const QuadGrid& grid : grids) {
    const bool is_known = std::any_of(different.begin(), different.end(),
                                      [&](const QuadGrid& other) { return share_quads(grid, other); });
    if (!is_known) different.push_back(grid);
    if (different.size() == kMaxGrids) break;
  }
  return different;
}

}  // namespace patinate::capture
