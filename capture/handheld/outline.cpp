#include "capture/handheld/outline.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "libcommon/geometry/dense_solve.h"

namespace patinate::capture {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr std::size_t kNumPoints = 400;             ///< Points along an outline (docs/algorithms/handheld.md).
constexpr int kNumTurns = 72;                       ///< Starts, every 5 degrees (docs/algorithms/handheld.md).
constexpr int kCoarseRounds = 6, kFineRounds = 40;  ///< Rounds of a start, and of the best one.
constexpr std::size_t kNumRefined = 8;              ///< Distinct turns that are refined, those that fit best first.
constexpr double kKept = 0.8;                       ///< Share of the points that count.
constexpr double kNear = 0.015;                     ///< Share of the object's size.
constexpr double kMinNear = 0.7;                    ///< Share of the points.
constexpr double kOtherTurn_deg = 15.0;             ///< Beyond which it is another one.
constexpr double kClearly = 2.0;                    ///< Times worse the next turn must be.
constexpr double kMaxCut = 0.4;                     ///< Share of an outline that may lie on the photograph's border.
constexpr double kHoleNear =
    0.04;  ///< Share of the object's size. These three: chosen on a rusting plate in four photographs.
constexpr double kHoleSize = 1.5;   ///< Times as large, at most: a label next to where a hole should be is no hole.
constexpr double kMinHole = 0.001;  ///< Share of the object's area: less is grain.
constexpr double kRound =
    0.6;  ///< Area over that of a circle of the same perimeter; a square has 0.785, and pixels cost some.

/// Points every so far along a closed line of pixels, smoothed over what pixels are ragged by.
std::vector<Vector2d> spaced(const std::vector<cv::Point>& line) {
  const std::size_t n = line.size();
  std::vector<Vector2d> smooth(n);
  constexpr int kHalf = 2;  // Points on each side that a point is smoothed over.
  for (std::size_t i = 0; i < n; ++i) {
    Vector2d sum = Vector2d::Zero();
    for (int k = -kHalf; k <= kHalf; ++k) {
      const cv::Point& p = line[(i + n + static_cast<std::size_t>(k + kHalf) - kHalf) % n];
      sum += Vector2d(p.x, p.y);
    }
    smooth[i] = sum / (2 * kHalf + 1);
  }
  double length = 0.0;
  for (std::size_t i = 0; i < n; ++i) length += (smooth[(i + 1) % n] - smooth[i]).norm();
  const double step = length / static_cast<double>(kNumPoints);
  std::vector<Vector2d> points;
  double along = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d from = smooth[i], way = smooth[(i + 1) % n] - from;
    const double piece = way.norm();
    while (points.size() < kNumPoints && static_cast<double>(points.size()) * step < along + piece)
      points.emplace_back(from + (static_cast<double>(points.size()) * step - along) / piece * way);
    along += piece;
  }
  return points;
}

/// Fit of the points of one outline to another, moved there.
struct Fit {
  Matrix3d b_from_a = Matrix3d::Identity();
  double mean_px = std::numeric_limits<double>::infinity();  ///< Distance of those kept, in b.
  int num_holes = 0;                                         ///< In place.
};

struct Match {
  Vector2d in_a;
  std::size_t in_b = 0;
  double distance = 0.0;  ///< In b's pixels.
};

std::vector<Match> matches_of(const PhotoOutline& a, const PhotoOutline& b, const Matrix3d& b_from_a) {
  std::vector<Match> matches;
  for (const Vector2d& p : a.points) {
    const Vector2d q = moved_by(b_from_a, p);
    Match best{.in_a = p, .distance = std::numeric_limits<double>::infinity()};
    for (std::size_t k = 0; k < b.points.size(); ++k) {
      const double d = (b.points[k] - q).squaredNorm();
      if (d < best.distance) best = {p, k, d};
    }
    best.distance = std::sqrt(best.distance);
    matches.push_back(best);
  }
  const auto kept = static_cast<std::ptrdiff_t>(kKept * static_cast<double>(matches.size()));
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match& x, const Match& y) { return x.distance < y.distance; });
  matches.resize(kept);
  return matches;
}

/// Similarity that brings points onto the tangents of those that they matched: linear in its four numbers.
Matrix3d step_of(const std::vector<Match>& matches, const PhotoOutline& b) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (const Match& m : matches) {
    const Vector2d& n = b.normals[m.in_b];
    const Eigen::Vector4d row(n.x() * m.in_a.x() + n.y() * m.in_a.y(), n.y() * m.in_a.x() - n.x() * m.in_a.y(), n.x(),
                              n.y());
    normal += row * row.transpose();
    right += row * n.dot(b.points[m.in_b]);
  }
  const Eigen::Vector4d s = solve_ldlt(normal, right);
  Matrix3d h;
  h << s[0], -s[1], s[2], s[1], s[0], s[3], 0, 0, 1;
  return h;
}

Fit refined(const PhotoOutline& a, const PhotoOutline& b, const Matrix3d& start, int num_rounds) {
  Fit fit{.b_from_a = start};
  const double expected = std::sqrt(std::abs(start.topLeftCorner<2, 2>().determinant()));
  for (int round = 0; round < num_rounds; ++round) {
    const Matrix3d next = step_of(matches_of(a, b, fit.b_from_a), b);
    const double scale = std::sqrt(std::abs(next.topLeftCorner<2, 2>().determinant()));
    // Outlines shrink to a point where nothing holds them.
    if (!next.allFinite() || !(scale > 0.5 * expected && scale < 2.0 * expected)) return {.b_from_a = start};
    fit.b_from_a = next;
  }
  double sum = 0.0;
  const std::vector<Match> matches = matches_of(a, b, fit.b_from_a);
  for (const Match& m : matches) sum += m.distance;
  fit.mean_px = sum / static_cast<double>(matches.size());
  return fit;
}

Vector2d middle_of(const PhotoOutline& outline) {
  Vector2d sum = Vector2d::Zero();
  for (const Vector2d& p : outline.points) sum += p;
  return sum / static_cast<double>(outline.points.size());
}

double turn_deg(const Matrix3d& h) { return std::atan2(h(1, 0), h(0, 0)) * 180.0 / std::numbers::pi; }

bool is_other_turn(const Matrix3d& x, const Matrix3d& y) {
  const double difference = std::abs(std::remainder(turn_deg(x) - turn_deg(y), 360.0));
  return difference > kOtherTurn_deg;
}

double near_share(const PhotoOutline& a, const PhotoOutline& b, const Matrix3d& b_from_a) {
  std::size_t num_near = 0;
  for (const Vector2d& p : a.points) {
    const Vector2d q = moved_by(b_from_a, p);
    const auto is_near = [&](const Vector2d& r) { return (r - q).norm() < kNear * b.size_px; };
    num_near += std::any_of(b.points.begin(), b.points.end(), is_near) ? 1 : 0;
  }
  return static_cast<double>(num_near) / static_cast<double>(a.points.size());
}

/// Holes of `a` that lie on one of `b` of their size.
int num_holes_in_place(const PhotoOutline& a, const PhotoOutline& b, const Matrix3d& b_from_a) {
  const double scale = std::sqrt(std::abs(b_from_a.topLeftCorner<2, 2>().determinant()));
  const auto is_in_place = [&](const PhotoOutline::Hole& hole) {
    const Vector2d moved = moved_by(b_from_a, hole.middle);
    return std::any_of(b.holes.begin(), b.holes.end(), [&](const PhotoOutline::Hole& other) {
      const double ratio = scale * hole.size_px / other.size_px;
      return (other.middle - moved).norm() < kHoleNear * b.size_px && ratio < kHoleSize && ratio > 1.0 / kHoleSize;
    });
  };
  return static_cast<int>(std::count_if(a.holes.begin(), a.holes.end(), is_in_place));
}

/// All turns about the middles, the best first.
std::vector<Fit> fits_of(const PhotoOutline& a, const PhotoOutline& b) {
  const Vector2d from = middle_of(a), to = middle_of(b);
  const double scale = b.size_px / a.size_px;
  std::vector<Fit> fits;
  for (int k = 0; k < kNumTurns; ++k) {
    const double turn = 2.0 * std::numbers::pi * k / kNumTurns;
    const double c = scale * std::cos(turn), s = scale * std::sin(turn);
    Matrix3d start;
    start << c, -s, to.x() - c * from.x() + s * from.y(), s, c, to.y() - s * from.x() - c * from.y(), 0, 0, 1;
    fits.push_back(refined(a, b, start, kCoarseRounds));
  }
  const auto is_better = [](const Fit& x, const Fit& y) { return x.mean_px < y.mean_px; };
  std::stable_sort(fits.begin(), fits.end(), is_better);
  // One of each turn: the neighbors of the best would leave no room for those that may fit as well.
  std::vector<Fit> turns;
  for (const Fit& fit : fits) {
    const auto is_known = [&](const Fit& other) { return !is_other_turn(fit.b_from_a, other.b_from_a); };
    if (turns.size() == kNumRefined || !std::isfinite(fit.mean_px)) break;
    if (std::none_of(turns.begin(), turns.end(), is_known)) turns.push_back(fit);
  }
  for (Fit& fit : turns) {
    fit = refined(a, b, fit.b_from_a, kFineRounds);
    fit.num_holes = num_holes_in_place(a, b, fit.b_from_a);
  }
  std::stable_sort(turns.begin(), turns.end(), is_better);
  // Among those that fit about as well, the one with more holes in place wins.
  const double limit = kClearly * std::max(turns.empty() ? 0.0 : turns.front().mean_px, b.error_px);
  std::stable_sort(turns.begin(), turns.end(), [limit](const Fit& x, const Fit& y) {
    return x.mean_px < limit && y.mean_px < limit && x.num_holes > y.num_holes;
  });
  return turns;
}

/// @param area  Of the object, in the mask's pixels. @param sx,sy  Pixels of the photograph to one of the mask.
std::vector<PhotoOutline::Hole> round_holes(const cv::Mat1b& mask, double area, double sx, double sy) {
  std::vector<std::vector<cv::Point>> lines;
  std::vector<cv::Vec4i> tree;  // Next, before, child, parent; -1 = none.
  cv::Mat1b even;
  cv::medianBlur(mask, even, 5);  // Grains of the background and of the object.
  cv::findContours(even, lines, tree, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  std::vector<PhotoOutline::Hole> holes;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double inside = cv::contourArea(lines[i]), around = cv::arcLength(lines[i], true);
    if (tree[i][3] < 0 || inside < kMinHole * area) continue;
    if (4.0 * std::numbers::pi * inside < kRound * around * around) continue;
    const cv::Moments m = cv::moments(lines[i]);
    holes.push_back(
        {Vector2d((m.m10 / m.m00 + 0.5) * sx - 0.5, (m.m01 / m.m00 + 0.5) * sy - 0.5), std::sqrt(inside * sx * sy)});
  }
  return holes;
}

}  // namespace

PhotoOutline find_outline(const ImageU8& object, int width, int height) {
  PhotoOutline outline{.width = width, .height = height};
  cv::Mat1b mask(object.height(), object.width());
  for (int y = 0; y < object.height(); ++y) {
    for (int x = 0; x < object.width(); ++x) mask(y, x) = object.at(x, y) != 0 ? 255 : 0;
  }
  std::vector<std::vector<cv::Point>> lines;
  cv::findContours(mask, lines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const auto largest = std::max_element(
      lines.begin(), lines.end(), [](const auto& x, const auto& y) { return cv::contourArea(x) < cv::contourArea(y); });
  if (largest == lines.end()) return outline;
  const double area = cv::contourArea(*largest);
  constexpr double kMinArea = 0.005;  // Share of the photograph.
  if (area < kMinArea * object.width() * object.height()) return outline;
  const std::vector<Vector2d> points = spaced(*largest);
  const double sx = static_cast<double>(width) / object.width(), sy = static_cast<double>(height) / object.height();
  outline.size_px = std::sqrt(area * sx * sy);
  outline.error_px = 0.5 * std::max(sx, sy);
  outline.holes = round_holes(mask, area, sx, sy);
  const std::size_t n = points.size();
  std::size_t num_cut = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d& p = points[i];
    constexpr double kBorder_px = 2.0;  // Outline points nearer to the picture's border are cut off by it.
    if (p.x() < kBorder_px || p.y() < kBorder_px || p.x() > object.width() - 1 - kBorder_px ||
        p.y() > object.height() - 1 - kBorder_px) {
      ++num_cut;
      continue;
    }
    const Vector2d along = points[(i + 1) % n] - points[(i + n - 1) % n];
    if (!(along.norm() > 0.0)) continue;
    outline.points.emplace_back((p.x() + 0.5) * sx - 0.5, (p.y() + 0.5) * sy - 0.5);
    outline.normals.push_back(Vector2d(along.y(), -along.x()).normalized());
  }
  if (static_cast<double>(num_cut) > kMaxCut * static_cast<double>(n)) {
    outline.points.clear();
    outline.normals.clear();
  }
  return outline;
}

PhotoPair align_outlines(int a, const PhotoOutline& of_a, int b, const PhotoOutline& of_b) {
  PhotoPair pair{.a = a, .b = b};
  constexpr std::size_t kLeastPoints = 40;  // A tenth of kNumPoints must lie inside the picture.
  if (of_a.points.size() < kLeastPoints || of_b.points.size() < kLeastPoints) return pair;
  const std::vector<Fit> fits = fits_of(of_a, of_b);
  if (fits.empty() || !std::isfinite(fits.front().mean_px)) return pair;
  const Fit& best = fits.front();
  const bool is_clear = std::none_of(fits.begin(), fits.end(), [&](const Fit& other) {
    return is_other_turn(best.b_from_a, other.b_from_a) && other.num_holes >= best.num_holes &&
           other.mean_px < kClearly * std::max(best.mean_px, of_b.error_px);
  });
  const std::vector<Match> matches = matches_of(of_a, of_b, best.b_from_a);
  pair.b_from_a = best.b_from_a;
  pair.num_matches = static_cast<int>(of_a.points.size());
  double square = 0.0;
  const std::size_t stride = std::max<std::size_t>(1, matches.size() / kMaxKept);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Vector2d& n = of_b.normals[matches[i].in_b];
    const Vector2d moved = moved_by(best.b_from_a, matches[i].in_a);
    const double off = n.dot(of_b.points[matches[i].in_b] - moved);
    square += off * off;
    // Along the outline anything goes.
    if (i % stride == 0) pair.matches.push_back({matches[i].in_a, moved + off * n});
  }
  pair.error_px = std::max(of_b.error_px, std::sqrt(square / static_cast<double>(matches.size())));
  const double near = std::min(near_share(of_a, of_b, best.b_from_a), near_share(of_b, of_a, best.b_from_a.inverse()));
  pair.num_agreeing = static_cast<int>(near * static_cast<double>(of_a.points.size()));
  // A view from one side makes a plate's outline fit one turn better than the other, right or wrong.
  const bool has_holes = !of_a.holes.empty() || !of_b.holes.empty();
  pair.is_accepted = is_clear && near >= kMinNear && (!has_holes || best.num_holes > 0);
  return pair;
}

}  // namespace patinate::capture
