#include "capture/registration/line_of_sight.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patinate::capture {

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

}  // namespace patinate::capture
