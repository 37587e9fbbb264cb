#include "capture/relief/height_probe.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "libcommon/core/median.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::capture {

namespace {

constexpr std::size_t kFewestSamples = 10;
constexpr double kMostAside = 0.35;  ///< Of the radius: the points' middle from the axis; a half disk's is at 0.42.
constexpr double kMostOff = 3.5;     ///< Robust standard deviations off the plane.
constexpr double kSteepest = 2.5;    ///< Slope against the direction: 68 degrees.

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

/// Of samples in order along the direction, those between two gaps, nearest to 0.
std::vector<Sample> nearest_layer(std::vector<Sample> samples, double gap) {
  std::sort(samples.begin(), samples.end(),
            [](const Sample& a, const Sample& b) { return std::tie(a.along, a.s, a.t) < std::tie(b.along, b.s, b.t); });
  std::vector<Sample> best;
  double best_distance = 0.0;
  for (std::size_t begin = 0, k = 1; k <= samples.size(); ++k) {
    if (k < samples.size() && samples[k].along - samples[k - 1].along <= gap) continue;
    double distance = std::abs(samples[begin].along);
    for (std::size_t i = begin; i < k; ++i) distance = std::min(distance, std::abs(samples[i].along));
    if (k - begin >= kFewestSamples && (best.empty() || distance < best_distance)) {
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
  return samples.size() >= kFewestSamples &&
         std::hypot(s, t) <= kMostAside * radius * static_cast<double>(samples.size());
}

void drop_outliers(std::vector<Sample>& samples) {
  const Plane plane = plane_of(samples);
  std::vector<double> sizes;
  sizes.reserve(samples.size());
  for (const Sample& p : samples) sizes.push_back(std::abs(off(plane, p)));
  const double most = kMostOff * kSigmaOfMad * median(std::move(sizes));
  std::erase_if(samples, [&](const Sample& p) { return std::abs(off(plane, p)) > most; });
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

}  // namespace patinate::capture
