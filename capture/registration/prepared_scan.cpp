#include "capture/registration/prepared_scan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr double kRadius = 2.5;     ///< Radius of a fine surfel, in their distances.
constexpr double kSightCell = 2.0;  ///< In fine distances.
constexpr double kMinSurface =
    0.5;  ///< Share of places with a surfel, below which the points are noisier than they are apart:
constexpr double kCoarser = 1.6;     ///< all scans are then made so much coarser,
constexpr int kMaxCoarser = 6;       ///< so many times at most.
constexpr double kTakenShare = 0.7;  ///< Share of points that lie one spacing apart.

Vec3 mean_of(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p - points.front();
  return points.front() + sum / static_cast<double>(points.size());
}

double radius_of(const PointCloud& cloud) {
  const Vec3 middle = mean_of(cloud.points);
  double sum = 0.0;
  for (const Vec3& p : cloud.points) sum += (p - middle).squaredNorm();
  return std::sqrt(sum / static_cast<double>(cloud.points.size()));
}

}  // namespace

LinesOfSight::LinesOfSight(std::span<const Vec3> points, const std::optional<Vec3>& scanner, const Vec3& toward_scanner,
                           double cell)
    : scanner_(scanner), cell_(cell) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : points) middle += p;
  middle /= static_cast<double>(std::max<std::size_t>(1, points.size()));
  w_ = scanner ? Vec3(*scanner - middle) : toward_scanner;
  distance_ = scanner ? w_.norm() : 1.0;
  w_.normalize();
  u_ = w_.unitOrthogonal();
  v_ = w_.cross(u_);
  cells_.reserve(points.size());
  for (const Vec3& p : points) {
    const Vec3 at = across_and_depth(p);
    if (!at.allFinite()) continue;
    const std::uint64_t k = key(static_cast<std::int64_t>(std::floor(at.x() / cell_)),
                                static_cast<std::int64_t>(std::floor(at.y() / cell_)));
    const auto [found, is_new] = cells_.try_emplace(k, Depths{at.z(), at.z()});
    if (is_new) continue;
    found->second.nearest = std::max(found->second.nearest, at.z());
    found->second.farthest = std::min(found->second.farthest, at.z());
  }
}

Vec3 LinesOfSight::across_and_depth(const Vec3& p) const {
  if (!scanner_) return {p.dot(u_), p.dot(v_), p.dot(w_)};
  const Vec3 from = p - *scanner_;
  const double depth = -from.dot(w_);
  if (!(depth > 1e-6 * distance_)) return Vec3::Constant(std::nan(""));
  return {from.dot(u_) * distance_ / depth, from.dot(v_) * distance_ / depth, -from.norm()};
}

LinesOfSight::Seen LinesOfSight::look_at(const Vec3& p, double tolerance) const {
  const Vec3 at = across_and_depth(p);
  if (!at.allFinite()) return Seen::Nothing;
  const auto x = static_cast<std::int64_t>(std::floor(at.x() / cell_)),
             y = static_cast<std::int64_t>(std::floor(at.y() / cell_));
  bool is_empty = true, is_front = true, is_behind = true;
  for (std::int64_t dy = -1; dy <= 1; ++dy) {
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      const auto found = cells_.find(key(x + dx, y + dy));
      if (found == cells_.end()) {
        if (dx == 0 && dy == 0) return Seen::Nothing;
        continue;
      }
      is_empty = false;
      is_front = is_front && at.z() > found->second.nearest + tolerance;
      is_behind = is_behind && at.z() < found->second.farthest - tolerance;
    }
  }
  if (is_empty) return Seen::Nothing;
  return is_front ? Seen::Front : is_behind ? Seen::Behind : Seen::Surface;
}

void SightCounts::add(const LinesOfSight& lines, std::span<const Vec3> points, const RigidTransform& lines_from_points,
                      double tolerance, std::size_t stride) {
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const LinesOfSight::Seen seen = lines.look_at(lines_from_points.apply(points[i]), tolerance);
    front += seen == LinesOfSight::Seen::Front ? 1 : 0;
    surface += seen == LinesOfSight::Seen::Surface ? 1 : 0;
  }
}

PreparedScan::PreparedScan(const PointCloud& cloud, double scale, double fine_distance, const RunControl& control)
    : middle_(mean_of(cloud.points)), scale_(scale) {
  std::vector<Vec3> points, toward;
  points.reserve(cloud.points.size());
  const bool knows_scanner = cloud.scanner || cloud.toward_scanner;
  for (const Vec3& p : cloud.points) {
    points.push_back((p - middle_) / scale);
    if (knows_scanner) toward.push_back(direction_to_scanner(cloud, p).value_or(Vec3::Zero()));
  }
  const bool has_normals = cloud.normals.size() == cloud.points.size();
  if (!knows_scanner && has_normals) toward = cloud.normals;
  Surfels fine = make_surfels(points, toward, fine_distance, kRadius * fine_distance, control);
  surface_share_ = fine.num_places > 0 ? static_cast<double>(fine.surfels.size()) / fine.num_places : 0.0;
  points_per_surfel_ = static_cast<double>(points.size()) / std::max<double>(1.0, static_cast<double>(fine.num_places));
  auto positions = std::make_shared<std::vector<Vec3>>();
  for (const Surfel& s : fine.surfels) positions->push_back(s.position);
  positions_ = std::move(positions);
  fine_ = std::make_shared<const SurfelSet>(std::move(fine.surfels), fine_distance, !toward.empty());
  const double coarse = std::max(kCoarseDistance, fine_distance);
  coarse_ = std::make_shared<const SurfelSet>(
      make_surfels(points, toward, coarse, std::max(coarse, kRadius * fine_distance), control).surfels, coarse,
      !toward.empty());
  if (!knows_scanner) return;
  const std::optional<Vec3> scanner =
      cloud.scanner ? std::optional<Vec3>((*cloud.scanner - middle_) / scale) : std::nullopt;
  lines_ = std::make_shared<const LinesOfSight>(points, scanner, cloud.toward_scanner.value_or(Vec3(0, 0, 1)),
                                                kSightCell * fine_distance);
}

std::vector<PreparedScan> prepare_scans(std::span<const PointCloud> scans, const RegistrationOptions& options,
                                        const RunControl& control) {
  check_ranges(options);
  double scale = 0.0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const double radius = scans[i].points.empty() ? 0.0 : radius_of(scans[i]);
    if (!(radius > 0.0)) throw InvalidInput("registration: scan " + std::to_string(i) + " has no extent");
    scale += radius / static_cast<double>(scans.size());
  }
  double spacing = 0.0, most_points = 0.0;
  for (const PointCloud& cloud : scans) {
    std::vector<Vec3> points;
    const Vec3 middle = mean_of(cloud.points);
    for (const Vec3& p : cloud.points) points.push_back((p - middle) / scale);
    spacing = std::max(spacing, point_spacing(points));
    most_points = std::max(most_points, static_cast<double>(points.size()));
  }
  double distance = spacing * std::max(1.0, std::sqrt(kTakenShare * most_points / options.max_surfels));
  for (int tries = 0;; ++tries) {
    std::vector<PreparedScan> prepared;
    double least = 1.0;
    for (const PointCloud& cloud : scans) {
      prepared.emplace_back(cloud, scale, distance, control);
      least = std::min(least, prepared.back().surface_share());
      if (least < kMinSurface && tries < kMaxCoarser) break;
    }
    if (least >= kMinSurface || tries == kMaxCoarser) {
      for (std::size_t i = 0; i < prepared.size(); ++i) {
        if (prepared[i].fine().size() == 0)
          throw InvalidInput("registration: the points of scan " + std::to_string(i) + " are no surface");
      }
      return prepared;
    }
    distance *= kCoarser;
  }
}

RigidTransform normalized(const RigidTransform& t, const PreparedScan& target, const PreparedScan& source) {
  return {t.rotation, (t.rotation * source.middle() + (t.translation - target.middle())) / target.scale()};
}

RigidTransform in_unit(const RigidTransform& pose, const PreparedScan& target, const PreparedScan& source) {
  return {pose.rotation, target.scale() * pose.translation + target.middle() - pose.rotation * source.middle()};
}

std::optional<double> share_in_front(const PreparedScan& target, const PreparedScan& source, const RigidTransform& pose,
                                     double tolerance, int num_looked) {
  SightCounts counts;
  const auto stride = [&](const PreparedScan& scan) {
    return std::max<std::size_t>(1, scan.positions().size() / static_cast<std::size_t>(num_looked));
  };
  if (target.lines_of_sight())
    counts.add(*target.lines_of_sight(), source.positions(), pose, tolerance, stride(source));
  if (source.lines_of_sight())
    counts.add(*source.lines_of_sight(), target.positions(), pose.inverse(), tolerance, stride(target));
  if (!target.lines_of_sight() && !source.lines_of_sight()) return std::nullopt;
  return counts.front + counts.surface == 0 ? 1.0 : static_cast<double>(counts.front) / (counts.front + counts.surface);
}

double overlap_of(const PairSums& sums) {
  const std::size_t smaller = sums.num_looked[0] <= sums.num_looked[1] ? 0 : 1;
  return sums.num_looked[smaller] == 0 ? 0.0
                                       : static_cast<double>(sums.num_fitting[smaller]) / sums.num_looked[smaller];
}

}  // namespace patinate::capture
