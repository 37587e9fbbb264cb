/// \file
/// The lamp of RenderOptions: a disc that faces the middle of the scene, so far away that its rays are parallel, or
/// near.
#pragma once

#include <limits>

#include "patinate/geometry/mesh.h"
#include "patinate/output/render.h"

namespace patinate {

class KeyLight {
 public:
  /// @param middle  Of the scene, where there is no RenderOptions::target: what the disc faces.
  KeyLight(const RenderOptions& options, const Vec3& middle);

  /// Unit, from the middle.
  [[nodiscard]] const Vec3& direction() const { return direction_; }
  [[nodiscard]] bool is_near() const { return distance_ > 0.0; }
  /// A point of the disc, from the middle, in units of its distance. @param square  In the unit square.
  [[nodiscard]] Vec3 point(const Vec2& square) const;

  /// Light that a place gets from a point of the disc, or from where a ray meets it.
  struct Ray {
    Vec3 direction = Vec3::UnitZ();  ///< Unit.
    double strength = 1.0;           ///< Light on a surface that faces it, over that at the middle: 1 / distance^2.
    double distance = std::numeric_limits<double>::infinity();
    double density =
        0.0;  ///< With which points of the disc lie in this direction, per steradian; infinite for a point.
  };
  [[nodiscard]] Ray toward(const Vec3& point, const Vec3& place) const;
  /// Density 0 where a ray of this unit direction does not meet the disc, or that is a point.
  [[nodiscard]] Ray along(const Vec3& direction, const Vec3& place) const;

 private:
  [[nodiscard]] double strength_of(const Vec3& from_middle, double distance) const;

  Vec3 middle_, direction_, x_, y_;
  double distance_;
  double radius_;  ///< Over its distance.
};

}  // namespace patinate
