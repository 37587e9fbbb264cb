#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "libcommon/core/median.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/capture/sphere_lights.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

/// A sphere's cone: the direction of its axis, as a turn from `axis`, and its half angle.
struct Cone {
  Vec3 axis;
  double angle = 0.0;
};

/// Two directions across `axis`.
Eigen::Matrix<double, 3, 2> across(const Vec3& axis) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = axis.unitOrthogonal();
  basis.col(1) = axis.cross(basis.col(0));
  return basis;
}

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// Pixels that the picture moves by when `ray` turns away from `axis`, per radian.
double px_per_radian(const Camera& camera, const Vec3& ray, const Vec3& axis, double step) {
  const Vec3 turn = axis.cross(ray).normalized();
  const auto at = [&](double angle) { return camera.project(camera.center() + Eigen::AngleAxisd(angle, turn) * ray); };
  const auto inner = at(-step), outer = at(step);
  return inner && outer ? (*outer - *inner).norm() / (2.0 * step) : 0.0;
}

bool is_in_picture(const Camera& camera, const Vec2& pixel) {
  const CameraParameters& p = camera.parameters();
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() <= p.width - 0.5 && pixel.y() <= p.height - 0.5;
}

float value_of(const ImageF& photo, int x, int y) {
  float sum = 0.0f;
  for (const float v : photo.pixel(x, y)) sum += v;
  return sum / static_cast<float>(photo.channels());
}

/// Centroid of the light above what is around, in a disc that is twice as wide as a piece and a little more: for pieces
/// of a few pixels as exact as for large ones. Outside of the sphere (values < 0) nothing counts.
Vec2 centroid_around(const ImageF& values, const Vec2& middle, double area) {
  const double inner = 2.0 * std::sqrt(area / std::numbers::pi) + 2.0, outer = inner + 3.0;
  std::vector<float> around;
  const auto each = [&](const auto& visit) {
    for (int y = static_cast<int>(std::floor(middle.y() - outer)); y <= static_cast<int>(std::ceil(middle.y() + outer));
         ++y) {
      for (int x = static_cast<int>(std::floor(middle.x() - outer));
           x <= static_cast<int>(std::ceil(middle.x() + outer)); ++x) {
        if (values.contains(x, y) && values.at(x, y) >= 0.0f)
          visit(Vec2(x, y), values.at(x, y), (Vec2(x, y) - middle).norm());
      }
    }
  };
  each([&](const Vec2&, float v, double distance) {
    if (distance > inner && distance <= outer) around.push_back(v);
  });
  if (around.empty()) return middle;
  const float floor = median(std::move(around));
  double weight = 0.0;
  Vec2 sum = Vec2::Zero();
  each([&](const Vec2& at, float v, double distance) {
    if (distance > inner) return;
    const double above = static_cast<double>(v - floor);
    weight += above, sum += above * at;
  });
  const Vec2 centroid = sum / weight;
  return weight > 0 && (centroid - middle).norm() < inner ? centroid : middle;
}

/// Pieces of `bright` pixels that touch, with the light above `threshold` and its centroid.
struct Piece {
  double weight = 0.0;
  double area = 0.0;
  Vec2 centroid = Vec2::Zero();
  Vec2 middle = Vec2::Zero();  ///< Every pixel counting the same.
};
std::vector<Piece> pieces_of(const ImageF& values, float threshold) {
  std::vector<Piece> pieces;
  ImageU8 seen(values.width(), values.height());
  std::vector<std::pair<int, int>> open;
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      if (seen.at(x, y) != 0 || !(values.at(x, y) > threshold)) continue;
      Piece piece;
      open.assign(1, {x, y});
      seen.at(x, y) = 1;
      while (!open.empty()) {
        const auto [px, py] = open.back();
        open.pop_back();
        const double above = static_cast<double>(values.at(px, py) - threshold);
        piece.weight += above;
        piece.area += 1.0;
        piece.centroid += above * Vec2(px, py);
        piece.middle += Vec2(px, py);
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            const int qx = px + dx, qy = py + dy;
            if (!values.contains(qx, qy) || seen.at(qx, qy) != 0 || !(values.at(qx, qy) > threshold)) continue;
            seen.at(qx, qy) = 1;
            open.emplace_back(qx, qy);
          }
        }
      }
      piece.centroid /= piece.weight;
      piece.middle /= piece.area;
      pieces.push_back(piece);
    }
  }
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.weight > b.weight; });
  return pieces;
}

}  // namespace

SphereFit fit_sphere(const Camera& camera, const MirrorSphere& sphere) {
  if (!(sphere.radius_mm > 0) || !std::isfinite(sphere.radius_mm))
    throw InvalidInput("a sphere's radius must be > 0 mm");
  if (sphere.outline_px.size() < 5) throw InvalidInput("a sphere's outline needs at least 5 points");
  SphereFit fit;
  Vec2 middle = Vec2::Zero();
  std::vector<Vec3> rays;
  for (const Vec2& p : sphere.outline_px) {
    if (!p.allFinite()) throw InvalidInput("a point of a sphere's outline is not finite");
    middle += p / static_cast<double>(sphere.outline_px.size());
    if (const auto ray = camera.ray(p)) rays.push_back(ray->direction);
  }
  double extent_px = 0.0;
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  for (const Vec2& p : sphere.outline_px) {
    extent_px += (p - middle).norm() / static_cast<double>(sphere.outline_px.size());
    moments += (p - middle) * (p - middle).transpose();
  }
  const Vec2 widths = symmetric_eigen(moments).values;
  constexpr double kLine = 1e-6;  // For an arc of 13 degrees.
  if (rays.size() < sphere.outline_px.size()) {
    if (!is_in_picture(camera, middle)) fit.status = SphereFitStatus::OutOfPicture;
    return fit;
  }
  // A first cone: the plane through the rays' tips; exact without noise, for an arc too.
  Vec3 mean = Vec3::Zero();
  for (const Vec3& ray : rays) mean += ray / static_cast<double>(rays.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3& ray : rays) spread += (ray - mean) * (ray - mean).transpose();
  const SymmetricEigen<Eigen::Matrix3d> plane = symmetric_eigen(spread);
  if (!(widths[0] > kLine * widths[1]) || !(extent_px > 1e-3)) return fit;
  Cone cone{plane.vectors.col(0), 0.0};
  if (cone.axis.dot(mean) < 0) cone.axis = -cone.axis;
  for (const Vec3& ray : rays) cone.angle += angle_between(ray, cone.axis) / static_cast<double>(rays.size());
  for (int round = 0; round < 30; ++round) {
    const Eigen::Matrix<double, 3, 2> basis = across(cone.axis);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Vec3 gradient = Vec3::Zero();
    double sum = 0.0;
    for (const Vec3& ray : rays) {
      const double scale = px_per_radian(camera, ray, cone.axis, 0.01 * cone.angle);
      const double residual = scale * (angle_between(ray, cone.axis) - cone.angle);
      const Vec2 toward = (basis.transpose() * ray).normalized();
      const Vec3 slope(-scale * toward.x(), -scale * toward.y(), -scale);
      normal += slope * slope.transpose();
      gradient += slope * residual;
      sum += residual * residual;
    }
    fit.rms_px = std::sqrt(sum / static_cast<double>(rays.size()));
    const SymmetricEigen<Eigen::Matrix3d> eigen = symmetric_eigen(normal);
    if (!eigen.is_converged || !(eigen.values[0] > 1e-12 * eigen.values[2])) return fit;
    const Vec3 step = -eigen.vectors * (eigen.vectors.transpose() * gradient).cwiseQuotient(eigen.values);
    cone.axis = (cone.axis + basis * step.head<2>()).normalized();
    cone.angle += step[2];
    if (!(cone.angle > 0 && cone.angle < 0.5 * std::numbers::pi)) return fit;
    if (step.norm() < 1e-13 * cone.angle) break;
  }
  fit.center = camera.center() + sphere.radius_mm / std::sin(cone.angle) * cone.axis;
  const auto seen = camera.project(fit.center);
  if (!seen) return fit;
  for (const Vec2& p : sphere.outline_px) fit.radius_px += (p - *seen).norm() / static_cast<double>(rays.size());
  if (fit.rms_px > 0.1 * extent_px) return fit;
  fit.status = is_in_picture(camera, *seen) ? SphereFitStatus::Converged : SphereFitStatus::OutOfPicture;
  return fit;
}

std::vector<Vec2> outline_of_mask(const ImageU8& mask) {
  std::vector<Vec2> points;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask.at(x, y) == 0) continue;
      if (x == 0 || y == 0 || x + 1 == mask.width() || y + 1 == mask.height()) {
        throw InvalidInput("the sphere's mask touches the border of the picture; the whole sphere must be seen");
      }
      if (mask.at(x - 1, y) == 0) points.emplace_back(x - 0.5, y);
      if (mask.at(x + 1, y) == 0) points.emplace_back(x + 0.5, y);
      if (mask.at(x, y - 1) == 0) points.emplace_back(x, y - 0.5);
      if (mask.at(x, y + 1) == 0) points.emplace_back(x, y + 0.5);
    }
  }
  if (points.empty()) throw InvalidInput("the sphere's mask covers nothing");
  return points;
}

std::vector<Vec2> outline_of_circle(const Vec2& center, double radius, int count) {
  if (!(radius > 0) || !std::isfinite(radius)) throw InvalidInput("a circle's radius must be > 0 pixels");
  std::vector<Vec2> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / count;
    points.push_back(center + radius * Vec2(std::cos(angle), std::sin(angle)));
  }
  return points;
}

std::optional<MirroredRay> mirrored_ray(const Camera& camera, const Vec3& center, double radius, const Vec2& pixel) {
  const auto ray = camera.ray(pixel);
  if (!ray) return std::nullopt;
  // Distances from the point of the ray next to the center: no cancellation where the camera is far.
  const Vec3 to_center = center - ray->origin;
  const double along = to_center.dot(ray->direction);
  const double half = radius * radius - (to_center - along * ray->direction).squaredNorm();
  if (!(half >= 0) || !(along > 0)) return std::nullopt;
  const Vec3 point = ray->origin + (along - std::sqrt(half)) * ray->direction;
  const Vec3 normal = (along * ray->direction - to_center - std::sqrt(half) * ray->direction) / radius;
  return MirroredRay{point, (ray->direction - 2.0 * ray->direction.dot(normal) * normal).normalized()};
}

std::string highlight_status_text(HighlightStatus status) {
  switch (status) {
    case HighlightStatus::Found:
      return "found";
    case HighlightStatus::OutOfPicture:
      return "the sphere is not wholly in the picture";
    case HighlightStatus::None:
      return "no highlight: nothing on the sphere is much brighter than the rest";
    case HighlightStatus::Several:
      return "several highlights of similar strength";
    case HighlightStatus::TooLarge:
      return "the highlight covers too much of the sphere: overexposed";
  }
  return "";
}

Highlight find_highlight(const ImageF& photo, const Camera& camera, const Vec3& center, double radius) {
  constexpr double kRim = 0.97;          // Share of the sphere's radius: its outline is mixed with what is behind.
  constexpr float kMinContrast = 0.02f;  // Linear, of full scale: less is noise of an 8-bit picture.
  // A second highlight of this share of the first one's light makes the first ambiguous.
  constexpr double kSimilar = 0.4;
  constexpr double kMaxShare = 0.05;     // A highlight covers at most this share of its sphere.
  constexpr float kPlateau = 0.9f;       // From the median to the peak: a saturated lamp is flat above it.
  constexpr double kMinPlateau = 50.0;   // Least pixels of a saturated lamp.
  constexpr double kOverexposed = 0.25;  // Less contrast over much of the sphere is the room, not a light.
  Highlight result;
  const auto seen = camera.project(center);
  if (!seen) {
    result.status = HighlightStatus::OutOfPicture;
    return result;
  }
  // The outline's bounding box, by rays that touch the sphere.
  const Vec3 axis = (center - camera.center()).normalized();
  const double distance = (center - camera.center()).norm();
  if (!(distance > radius)) throw InvalidInput("the camera is inside a sphere");
  const double slope = kRim * std::tan(std::asin(radius / distance));
  const Eigen::Matrix<double, 3, 2> basis = across(axis);
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (int i = 0; i < 64; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 64;
    const auto p = camera.project(camera.center() + axis + slope * (basis * Vec2(std::cos(angle), std::sin(angle))));
    if (!p || p->x() < -0.5 || p->y() < -0.5 || p->x() > photo.width() - 0.5 || p->y() > photo.height() - 0.5) {
      result.status = HighlightStatus::OutOfPicture;
      return result;
    }
    low = low.cwiseMin(*p), high = high.cwiseMax(*p);
  }
  const int x0 = std::max(0, static_cast<int>(std::floor(low.x()))),
            y0 = std::max(0, static_cast<int>(std::floor(low.y())));
  const int x1 = std::min(photo.width() - 1, static_cast<int>(std::ceil(high.x()))),
            y1 = std::min(photo.height() - 1, static_cast<int>(std::ceil(high.y())));
  constexpr float kOutside = -1.0f;
  ImageF values(x1 - x0 + 1, y1 - y0 + 1, 1, kOutside);
  std::vector<float> inside;
  const double max_angle = std::atan(slope);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const auto ray = camera.ray(Vec2(x, y));
      if (!ray || angle_between(ray->direction, axis) > max_angle) continue;
      const float v = value_of(photo, x, y);
      values.at(x - x0, y - y0) = v;
      inside.push_back(v);
    }
  }
  if (inside.size() < 20) return result;
  const float peak = *std::max_element(inside.begin(), inside.end()), middle = median(inside);
  result.contrast = static_cast<double>(peak - middle);
  if (!(peak - middle > kMinContrast)) return result;
  const std::vector<Piece> pieces = pieces_of(values, middle + 0.5f * (peak - middle));
  // A plateau is the lamp itself, saturated; what is dimmer around it is flare and scattered light, which may lie to
  // one side.
  const std::vector<Piece> plateaus = pieces_of(values, middle + kPlateau * (peak - middle));
  const bool has_plateau = plateaus[0].area >= kMinPlateau;
  result.pixel =
      (has_plateau ? plateaus[0].middle : centroid_around(values, pieces[0].centroid, pieces[0].area)) + Vec2(x0, y0);
  result.area_px = pieces[0].area;
  if (pieces[0].area > kMaxShare * static_cast<double>(inside.size())) {
    result.status = result.contrast > kOverexposed ? HighlightStatus::TooLarge : HighlightStatus::None;
  } else if (pieces.size() > 1 && pieces[1].weight > kSimilar * pieces[0].weight) {
    result.status = HighlightStatus::Several;
  } else {
    result.status = HighlightStatus::Found;
  }
  return result;
}

}  // namespace patinate::capture
