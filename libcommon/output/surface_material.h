/// \file
/// How a place of a surface reflects light: a diffuse base, a rough mirror, and a film of water over both.
#pragma once

#include "libcommon/output/microfacet.h"
#include "libcommon/output/surface_scene.h"

namespace patinate {

/// Albedo of a diffuse surface under a film of water: light that it sends up is partly reflected down again inside the
/// film [Angstrom 1925; Lekner and Dorf 1988].
[[nodiscard]] Vec3 wet_albedo(const Vec3& albedo);

/// The material of one place, seen from one direction.
class SurfaceMaterial {
 public:
  explicit SurfaceMaterial(const SeenPoint& point);

  /// Share of diffuse irradiance over pi that is seen.
  [[nodiscard]] const Vec3& diffuse() const { return diffuse_; }
  /// Light that a viewer sees from all around, whichever way it is reflected; for light that met another surface
  /// before.
  [[nodiscard]] Vec3 all() const { return diffuse_ + base_reflected_ + Vec3::Constant(coat_reflected_); }
  /// Light from all around that the mirrors reflect, mean of the channels.
  [[nodiscard]] double reflected() const { return base_share_ + coat_share_; }

  struct Reflection {
    Vec3 value = Vec3::Zero();  ///< BRDF times cosine.
    double pdf = 0.0;           ///< With which sample() gives this direction, per steradian.
  };
  [[nodiscard]] Reflection reflection(const Vec3& light) const;
  /// @param choice  [0, 1): which of the two mirrors.
  [[nodiscard]] Vec3 sample(const Vec2& square, double choice) const;

 private:
  Lobe base_, coat_;
  /// For the base's lobe: factors of 1 and of grazing reflection, with compensated energy and what the film lets
  /// through.
  Vec3 base_level_ = Vec3::Zero(), base_grazing_ = Vec3::Zero();
  Vec3 base_reflected_ = Vec3::Zero();
  double coat_weight_ = 0.0;
  double coat_reflected_ = 0.0;
  double base_share_ = 0.0, coat_share_ = 0.0;  ///< Shares of samples; not normalized.
  Vec3 diffuse_ = Vec3::Zero();
};

}  // namespace patinate
