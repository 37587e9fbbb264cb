#include "capture/chart/find_chart.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "capture/chart/chart_quads.h"
#include "capture/chart/unclamped_lab.h"
#include "libcommon/core/median.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/metrics/difference.h"

namespace patinate::capture {

namespace {

constexpr std::array<int, 2> kSides{1000, 2000};  ///< Longer side at which a photograph is looked at; then finer.
constexpr double kBrightShare = 0.99;             ///< Share of the values, below what becomes code 230.
/// Linear value that the bright patches are scaled to before colors are compared.
constexpr double kBright = 0.8;
constexpr std::size_t kMinQuads = 10;  ///< That are seen; dark ones vanish in the frame.
/// CIEDE2000 of the middle patch: wrong turns of the chart leave more than twice as much, whatever matrix is fitted.
constexpr double kMaxError = 9.0;
constexpr double kSampleRadius = 0.22;  ///< Share of the distance of two patches: half of a patch.
constexpr double kMaxBend = 0.1;        ///< Share of the same: from there on samples may leave the patch.
constexpr int kNumFits = 8;             ///< Rounds with less weight on outliers (docs/algorithms/chart.md).

using Grid3 = Eigen::Matrix3d;

/// A picture as find_quads() wants it, and its light.
struct SmallPhoto {
  ImageF linear, codes;
  double scale = 1.0;  ///< Its pixels for one of the photograph.
};

SmallPhoto small_photo(const ImageF& linear, int side) {
  const double scale = std::min(1.0, static_cast<double>(side) / std::max(linear.width(), linear.height()));
  const auto reduced = [&](int v) { return std::max(1, static_cast<int>(std::lround(scale * v))); };
  RunControl one_thread;  // Photographs are looked at side by side.
  one_thread.num_threads = 1;
  SmallPhoto small{downscale_area(linear, reduced(linear.width()), reduced(linear.height()), one_thread), {}, scale};
  std::vector<float> values(small.linear.values().begin(), small.linear.values().end());
  const float bright =
      value_at_rank(values, static_cast<std::size_t>(kBrightShare * static_cast<double>(values.size() - 1)));
  const float gain = bright > 0.0f ? static_cast<float>(kBright) / bright : 1.0f;
  small.codes = small.linear;
  for (float& v : small.codes.values()) v = srgb_from_linear(std::clamp(gain * v, 0.0f, 1.0f));
  return small;
}

Eigen::Vector2d mapped(const Grid3& h, double x, double y) { return (h * Eigen::Vector3d(x, y, 1.0)).hnormalized(); }

/// Photograph's pixels from columns and rows of the grid. Nothing where the quads do not span a plane.
std::optional<Grid3> plane_of(const QuadGrid& grid) {
  std::vector<cv::Point2d> cells, pixels;
  for (const auto& [cell, quad] : grid) {
    cells.emplace_back(cell.first, cell.second);
    pixels.emplace_back(quad.middle.x(), quad.middle.y());
  }
  const cv::Mat h = cv::findHomography(cells, pixels, 0);
  if (h.empty()) return std::nullopt;
  Grid3 plane;
  for (int i = 0; i < 9; ++i) plane(i / 3, i % 3) = h.at<double>(i / 3, i % 3);
  return plane.allFinite() && std::abs(plane.determinant()) > 1e-12 ? std::optional(plane) : std::nullopt;
}

/// Largest distance of a quad from where the plane has it, in steps of the grid.
double bend_of(const QuadGrid& grid, const Grid3& plane) {
  double bend = 0.0;
  for (const auto& [cell, quad] : grid) {
    const Eigen::Vector2d at = mapped(plane, cell.first, cell.second);
    const double step = (mapped(plane, cell.first + 1, cell.second) - at).norm();
    bend = std::max(bend, (quad.middle - at).norm() / step);
  }
  return bend;
}

/// Mean light around a pixel; nothing where that leaves the picture.
std::optional<Eigen::Vector3d> light_at(const ImageF& linear, const Eigen::Vector2d& at, double radius) {
  const int left = static_cast<int>(std::ceil(at.x() - radius)), right = static_cast<int>(std::floor(at.x() + radius));
  const int top = static_cast<int>(std::ceil(at.y() - radius)), bottom = static_cast<int>(std::floor(at.y() + radius));
  if (left < 0 || top < 0 || right >= linear.width() || bottom >= linear.height() || left > right || top > bottom)
    return std::nullopt;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(linear.at(x, y, c));
    }
  }
  return sum / ((right - left + 1.0) * (bottom - top + 1.0));
}

/// The chart in one of its turns over the grid.
struct Turn {
  Grid3 photo_from_cell = Grid3::Identity();  ///< From columns and rows of the chart.
  bool is_mirrored = false;
  double error = std::numeric_limits<double>::infinity();  ///< CIEDE2000 of the middle patch.
  int num_outside = 0;                                     ///< Patches that the picture does not show.
};

/// How far colors are from the table's when the best matrix is found for most of them: weighted least squares, again
/// and again with less weight on what fits badly.
double color_error(const std::vector<Eigen::Vector3d>& seen, const std::vector<const ChartPatch*>& patches) {
  std::vector<double> weights(seen.size(), 1.0), errors(seen.size(), 0.0);
  for (int fit = 0; fit < kNumFits; ++fit) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero(), right = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Eigen::Vector3d truth(patches[i]->linear.data());
      constexpr double kDark = 0.05;  // About as the eye, relative differences count.
      const double weight = weights[i] / std::pow(std::max(0.0, truth.mean()) + kDark, 2.0);
      normal += weight * seen[i] * seen[i].transpose();
      right += weight * seen[i] * truth.transpose();
    }
    normal.diagonal().array() += 1e-9 * normal.trace();
    const Eigen::Matrix3d matrix = normal.ldlt().solve(right).transpose();
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Eigen::Vector3d rgb = matrix * seen[i];
      errors[i] = ciede2000(unclamped_lab<double>({rgb[0], rgb[1], rgb[2]}), patches[i]->lab);
      constexpr double kScale = 5.0;  // Delta E at which a patch's weight in the match is halved (Cauchy).
      weights[i] = 1.0 / (1.0 + (errors[i] / kScale) * (errors[i] / kScale));
    }
  }
  return median(errors);
}

/// @param cell_from_chart  Columns and rows of the grid from those of the chart.
Turn try_turn(const SmallPhoto& photo, const Grid3& plane, const Grid3& cell_from_chart, const ChartTable& table) {
  Turn turn{.photo_from_cell = plane * cell_from_chart,
            .is_mirrored = (plane * cell_from_chart).determinant() * (plane * cell_from_chart)(2, 2) < 0.0};
  std::vector<Eigen::Vector3d> seen;
  std::vector<const ChartPatch*> patches;
  for (int row = 0; row < kChartRows; ++row) {
    for (int column = 0; column < kChartColumns; ++column) {
      const Eigen::Vector2d at = mapped(turn.photo_from_cell, column, row);
      const double step = std::min((mapped(turn.photo_from_cell, column + 1, row) - at).norm(),
                                   (mapped(turn.photo_from_cell, column, row + 1) - at).norm());
      const std::optional<Eigen::Vector3d> light = light_at(photo.linear, at, kSampleRadius * step);
      if (!light) {
        ++turn.num_outside;
        continue;
      }
      seen.push_back(*light);
      patches.push_back(&table[static_cast<std::size_t>(row * kChartColumns + column)]);
    }
  }
  if (seen.size() >= kMinQuads) turn.error = color_error(seen, patches);
  return turn;
}

/// The best of all ways in which a grid may be a part of the chart.
Turn best_turn(const SmallPhoto& photo, const QuadGrid& grid, const Grid3& plane, const ChartTable& table) {
  int columns = 0, rows = 0;
  for (const auto& [cell, quad] : grid) {
    columns = std::max(columns, cell.first + 1);
    rows = std::max(rows, cell.second + 1);
  }
  Turn best;
  for (int code = 0; code < 8; ++code) {
    const bool is_swapped = (code & 1) != 0, flips_columns = (code & 2) != 0, flips_rows = (code & 4) != 0;
    const int wide = is_swapped ? rows : columns, high = is_swapped ? columns : rows;
    for (int left = 0; left + wide <= kChartColumns; ++left) {
      for (int top = 0; top + high <= kChartRows; ++top) {
        // Chart's cell (u, v) is (u - left, v - top) of the turned grid.
        Grid3 turned;
        turned << (flips_columns ? -1 : 1), 0, (flips_columns ? wide - 1 + left : -left), 0, (flips_rows ? -1 : 1),
            (flips_rows ? high - 1 + top : -top), 0, 0, 1;
        Grid3 swap = Grid3::Identity();
        if (is_swapped) swap << 0, 1, 0, 1, 0, 0, 0, 0, 1;
        const Turn turn = try_turn(photo, plane, swap * turned, table);
        if (turn.error < best.error) best = turn;
      }
    }
  }
  return best;
}

/// Pixel centers of the photograph from places across the chart.
Eigen::Matrix3d photo_from_chart(const Turn& turn, double scale) {
  const double columns = kChartColumns - 1 + kPatchSide, rows = kChartRows - 1 + kPatchSide;
  Eigen::Matrix3d cell_from_chart, photo_from_small;
  cell_from_chart << columns, 0, -0.5 * kPatchSide, 0, rows, -0.5 * kPatchSide, 0, 0, 1;
  photo_from_small << 1.0 / scale, 0, 0.5 / scale - 0.5, 0, 1.0 / scale, 0.5 / scale - 0.5, 0, 0, 1;
  return photo_from_small * turn.photo_from_cell * cell_from_chart;
}

struct Candidate {
  Turn turn;
  double bend = 0.0;
};

/// The best, be it bad. Nothing where no grid is seen.
std::optional<Candidate> best_candidate(const SmallPhoto& photo, const ChartTable& table) {
  std::optional<Candidate> best;
  for (const QuadGrid& grid : find_grids(find_quads(photo.codes))) {
    if (grid.size() < kMinQuads) continue;
    const std::optional<Grid3> plane = plane_of(grid);
    if (!plane) continue;
    const Turn turn = best_turn(photo, grid, *plane, table);
    if (best && turn.error >= best->turn.error) continue;
    best = {turn, bend_of(grid, *plane)};
  }
  return best;
}

}  // namespace

ChartPlace find_chart(const ImageF& linear, const ChartTable& table) {
  if (linear.channels() != 3 || linear.empty()) throw InvalidInput("find_chart: an image of 3 channels is needed");
  if (!is_classic_layout(table)) throw InvalidInput("find_chart: a table of 6 x 4 patches is needed");
  int last = 0;
  double least_error = std::numeric_limits<double>::infinity();
  for (const int side : kSides) {
    const int used = std::min(side, std::max(linear.width(), linear.height()));
    if (used == last) break;
    last = used;
    const SmallPhoto photo = small_photo(linear, side);
    const std::optional<Candidate> found = best_candidate(photo, table);
    if (found) least_error = std::min(least_error, found->turn.error);
    if (!found || found->turn.error > kMaxError) continue;
    if (found->turn.is_mirrored) return {.problem = "shows its chart mirrored; flip it back"};
    if (found->turn.num_outside > 0)
      return {.problem = "shows only a part of its chart: " + std::to_string(found->turn.num_outside) +
                         " patches lie outside of the picture"};
    if (found->bend > kMaxBend)
      return {.problem = "shows its chart bent or partly hidden: its patches do not lie as those of a plane do"};
    return {.photo_from_chart = photo_from_chart(found->turn, photo.scale)};
  }
  if (std::isfinite(least_error))
    return {.problem =
                "shows no chart of the table's colors; patches in rows that it shows differ from them by CIEDE2000 " +
                short_number_text(rounded(least_error, 2)) + ": another make, or too little light"};
  return {.problem = "shows no chart of 6 x 4 patches that can be found"};
}

ChartPlace place_chart(const std::array<Eigen::Vector2d, 4>& corners) {
  double area = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % 4];
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  if (area < 0.0) return {.problem = "has the corners of its chart in the order of a mirrored one"};
  const std::vector<cv::Point2d> from{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  std::vector<cv::Point2d> to;
  for (const Eigen::Vector2d& corner : corners) to.emplace_back(corner.x(), corner.y());
  const cv::Mat h = cv::findHomography(from, to, 0);
  Eigen::Matrix3d place;
  for (int i = 0; i < 9; ++i) place(i / 3, i % 3) = h.at<double>(i / 3, i % 3);
  return {.photo_from_chart = place};
}

}  // namespace patinate::capture
