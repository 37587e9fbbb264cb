#include "capture/relief/relief_places.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

namespace {

constexpr std::size_t kMinSamples = 10;  ///< Points that a layer needs in a window.
constexpr double kMaxAside =
    0.35;                          ///< Share of the radius: the points' middle from the axis; a half disk's is at 0.42.
constexpr double kMaxOff = 3.5;    ///< Robust standard deviations off the plane.
constexpr double kSteepest = 2.5;  ///< Slope against the direction: 68 degrees.

struct Sample {
  double along, s, t;
};

struct Plane {
  Eigen::Vector3d coefficients;  ///< Height on the axis, slopes.
  double axis_factor;            ///< Variance of the height over that of a point.
};

Plane plane_of(const std::vector<Sample>& samples) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Sample& p : samples) {
    const Eigen::Vector3d row(1.0, p.s, p.t);
    normal += row * row.transpose();
    right += row * p.along;
  }
  return {solve_ldlt(normal, right), solve_ldlt(normal, Eigen::Vector3d(Eigen::Vector3d::UnitX())).x()};
}

double off(const Plane& plane, const Sample& p) {
  return p.along - plane.coefficients.dot(Eigen::Vector3d(1.0, p.s, p.t));
}

/// Layer of samples in order along the direction, between two gaps, nearest to 0.
std::vector<Sample> nearest_layer(std::vector<Sample> samples, double gap) {
  std::sort(samples.begin(), samples.end(),
            [](const Sample& a, const Sample& b) { return std::tie(a.along, a.s, a.t) < std::tie(b.along, b.s, b.t); });
  std::vector<Sample> best;
  double best_distance = 0.0;
  for (std::size_t begin = 0, k = 1; k <= samples.size(); ++k) {
    if (k < samples.size() && samples[k].along - samples[k - 1].along <= gap) continue;
    double distance = std::abs(samples[begin].along);
    for (std::size_t i = begin; i < k; ++i) distance = std::min(distance, std::abs(samples[i].along));
    if (k - begin >= kMinSamples && (best.empty() || distance < best_distance)) {
      best.assign(samples.begin() + static_cast<std::ptrdiff_t>(begin),
                  samples.begin() + static_cast<std::ptrdiff_t>(k));
      best_distance = distance;
    }
    begin = k;
  }
  return best;
}

bool lies_around(const std::vector<Sample>& samples, double radius) {
  double s = 0.0, t = 0.0;
  for (const Sample& p : samples) s += p.s, t += p.t;
  return samples.size() >= kMinSamples && std::hypot(s, t) <= kMaxAside * radius * static_cast<double>(samples.size());
}

void drop_outliers(std::vector<Sample>& samples) {
  const Plane plane = plane_of(samples);
  std::vector<double> sizes;
  sizes.reserve(samples.size());
  for (const Sample& p : samples) sizes.push_back(std::abs(off(plane, p)));
  const double most = kMaxOff * kSigmaOfMad * median(std::move(sizes));
  std::erase_if(samples, [&](const Sample& p) { return std::abs(off(plane, p)) > most; });
}

constexpr std::size_t kMinInLayer = 10;
constexpr double kMinFacing = 0.25;  ///< Cosine of a normal to the viewer: 75 degrees.

Vec3 mean_of(std::span<const Vec3> points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

Vec3 across_best_plane(std::span<const Vec3> points) {
  const Vec3 mean = mean_of(points);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3& p : points) spread += (p - mean) * (p - mean).transpose();
  return symmetric_eigen(spread).vectors.col(0);
}

/// Towards the outside, on the whole; nothing when the file does not say.
std::optional<Vec3> outside_of(const PointCloud& scan) {
  if (const std::optional<Vec3> d = direction_to_scanner(scan, mean_of(scan.points))) return d;
  Vec3 sum = Vec3::Zero();
  for (const Vec3& n : scan.normals) sum += n;
  for (const Triangle& t : scan.triangles) {
    const Vec3& a = scan.points[t[0]];
    sum += (scan.points[t[1]] - a).cross(scan.points[t[2]] - a);
  }
  return sum.norm() > 0.0 ? std::optional(Vec3(sum.normalized())) : std::nullopt;
}

/// Height of the topmost layer of the points over a pixel, in the mean; nothing where there are too few.
std::optional<double> top_of(std::vector<double> depths, double gap) {
  std::sort(depths.begin(), depths.end(), std::greater<>());
  for (std::size_t begin = 0, k = 1; k <= depths.size(); ++k) {
    if (k < depths.size() && depths[k - 1] - depths[k] <= gap) continue;
    if (k - begin >= kMinInLayer) {
      double sum = 0.0;
      for (std::size_t i = begin; i < k; ++i) sum += depths[i];
      return sum / static_cast<double>(k - begin);
    }
    begin = k;
  }
  return std::nullopt;
}

}  // namespace

HeightProbe::HeightProbe(std::span<const Vec3> points, double radius, double reach)
    : points_(points), radius_(radius), reach_(std::max(reach, radius)), cells_(points, radius) {}

std::optional<LocalHeight> HeightProbe::over(const Vec3& place, const Vec3& direction) const {
  const Vec3 u = direction.unitOrthogonal(), v = direction.cross(u);
  const auto samples_within = [&](double reach) {
    std::vector<Sample> samples;
    cells_.near(place, std::hypot(radius_, reach), [&](int index, double) {
      const Vec3 d = points_[index] - place;
      const Sample p{d.dot(direction), d.dot(u), d.dot(v)};
      if (std::abs(p.along) <= reach && p.s * p.s + p.t * p.t <= radius_ * radius_) samples.push_back(p);
    });
    return nearest_layer(std::move(samples), radius_);
  };
  // Mostly the surface is near: half of the way is looked at first, and all of it where the layer goes on.
  const double near_reach = std::min(radius_, reach_);
  std::vector<Sample> samples = samples_within(near_reach);
  const bool is_cut = samples.empty() || std::max(-samples.front().along, samples.back().along) > 0.75 * near_reach;
  if (is_cut && reach_ > near_reach) samples = samples_within(reach_);
  if (!lies_around(samples, radius_)) return std::nullopt;
  drop_outliers(samples);
  if (!lies_around(samples, radius_)) return std::nullopt;
  const Plane plane = plane_of(samples);
  const double s = plane.coefficients[1], t = plane.coefficients[2];
  if (!plane.coefficients.allFinite() || std::hypot(s, t) > kSteepest) return std::nullopt;
  double squares = 0.0;
  for (const Sample& p : samples) squares += off(plane, p) * off(plane, p);
  const double of_point = squares / static_cast<double>(samples.size() - 3);
  LocalHeight found;
  found.height = plane.coefficients[0];
  // A surface without noise, as test data is, is known to what doubles hold of its size.
  found.variance = std::max(of_point * plane.axis_factor, 1e-24 * radius_ * radius_);
  found.normal = (direction - s * u - t * v).normalized();
  found.num_points = static_cast<int>(samples.size());
  return found;
}

ReliefView relief_view(const PointCloud& scan, const Vec3& toward, double texel, double margin) {
  ReliefView view;
  view.texel = texel;
  if (toward.norm() > 0.0) {
    view.toward = toward.normalized();
  } else {
    view.toward = across_best_plane(scan.points);
    const std::optional<Vec3> outside = outside_of(scan);
    view.is_side_known = outside.has_value();
    if (view.toward.dot(outside.value_or(Vec3::UnitZ())) < 0.0) view.toward = -view.toward;
  }
  // Right is x and up is y as nearly as the view allows.
  const Vec3 up = std::abs(view.toward.y()) < 0.9 ? Vec3::UnitY() : Vec3(-Vec3::UnitZ() * view.toward.y());
  view.right = up.cross(view.toward).normalized();
  view.up = view.toward.cross(view.right);
  double left = std::numeric_limits<double>::infinity(), bottom = left, rightmost = -left, top = -left;
  for (const Vec3& p : scan.points) {
    left = std::min(left, p.dot(view.right)), rightmost = std::max(rightmost, p.dot(view.right));
    bottom = std::min(bottom, p.dot(view.up)), top = std::max(top, p.dot(view.up));
  }
  const double columns = std::floor((rightmost - left + 2.0 * margin) / texel) + 1.0;
  const double rows = std::floor((top - bottom + 2.0 * margin) / texel) + 1.0;
  if (!(columns >= 1.0 && rows >= 1.0)) throw InvalidInput("relief: the scan is smaller than the window");
  if (columns > kMaxHistorySide_px || rows > kMaxHistorySide_px)
    throw InvalidInput("relief: texel_mm " + short_number_text(texel) + " makes more than " +
                       std::to_string(kMaxHistorySide_px) + " pixels along a side");
  view.width = static_cast<int>(columns), view.height = static_cast<int>(rows);
  const double x = 0.5 * (left + rightmost - (columns - 1.0) * texel);
  const double y = 0.5 * (top + bottom + (rows - 1.0) * texel);
  view.corner = x * view.right + y * view.up;
  return view;
}

std::vector<ReliefPlace> relief_places(std::span<const Vec3> points, const HeightProbe& probe, const ReliefView& view,
                                       double radius, const RunControl& control) {
  std::vector<Vec3> flat(points.size());
  std::vector<double> depth(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    flat[i] = {points[i].dot(view.right), points[i].dot(view.up), 0.0};
    depth[i] = points[i].dot(view.toward);
  }
  const PointCells cells(flat, radius);
  const double pixel_area = view.texel * view.texel;
  std::vector<std::vector<ReliefPlace>> rows(static_cast<std::size_t>(view.height));
  parallel_for(view.height, 1, control, [&](std::int64_t begin, std::int64_t) {
    const int y = static_cast<int>(begin);
    for (int x = 0; x < view.width; ++x) {
      const Vec3 p = view.at(x, y);
      std::vector<double> depths;
      cells.near({p.dot(view.right), p.dot(view.up), 0.0}, radius,
                 [&](int index, double) { depths.push_back(depth[index]); });
      const std::optional<double> top = top_of(std::move(depths), radius);
      if (!top) continue;
      const Vec3 over = p + *top * view.toward;
      const std::optional<LocalHeight> found = probe.over(over, view.toward);
      if (!found) continue;
      const double facing = found->normal.dot(view.toward);
      if (facing < kMinFacing) continue;
      rows[y].push_back({x, y, over + found->height * view.toward, found->normal, pixel_area / facing});
    }
  });
  std::vector<ReliefPlace> places;
  for (const std::vector<ReliefPlace>& row : rows) places.insert(places.end(), row.begin(), row.end());
  return places;
}

}  // namespace patinate::capture
