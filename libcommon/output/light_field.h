/// \file
/// Where the light of a picture comes from: the lamp and the even light of RenderOptions, or a picture of the
/// surroundings.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "libcommon/output/key_light.h"
#include "patinate/geometry/mesh.h"
#include "patinate/output/render.h"
#include "patinate/output/render_surface.h"

namespace patinate {

/// Surroundings: what is bright in them are lamps, which cast shadows; the rest is smooth light.
class Surroundings {
 public:
  /// @param image  Radiance, width = 360 degrees, first row up; >= 2 x 1 pixels, 3 channels. @param mean  To which it
  /// is scaled; 0 = not.
  /// @throws InvalidInput for another image, or one that is black where it is to be scaled.
  Surroundings(const ImageF& image, double mean);

  /// Directions are given with y up and the middle of the picture at -z.
  /// All light, lamps too. @param solid_angle  Over which to average, steradian.
  [[nodiscard]] Vec3 radiance(const Vec3& direction, double solid_angle) const;
  /// Light of a white surface in the smooth light: irradiance over pi.
  [[nodiscard]] Vec3 smooth_on(const Vec3& normal) const;
  [[nodiscard]] bool has_lamps() const { return lamp_total_ > 0.0; }
  /// Radiance of lamps in a direction, and with what density sample() chooses it, per steradian.
  [[nodiscard]] Vec3 lamps(const Vec3& direction, double& pdf) const;
  [[nodiscard]] Vec3 sample(const Vec2& square) const;

 private:
  std::vector<ImageF> levels_;  ///< Levels of all light, each half as large.
  ImageF lamps_;
  std::array<Vec3, 9> harmonics_;   ///< Irradiance over pi [Ramamoorthi and Hanrahan 2001].
  double lamp_total_ = 0.0;         ///< Luminance times solid angle.
  std::vector<double> row_sums_;    ///< Cumulative, of rows.
  std::vector<double> pixel_sums_;  ///< Cumulative in each row.
};

/// Light on a scene, seen from one azimuth: it turns with the camera.
class LightField {
 public:
  /// @param surroundings  May be null: the studio of the options. Must outlive this.
  /// @param middle  Of the scene: KeyLight.
  LightField(const RenderOptions& options, const SurfaceOptions& surface, const Surroundings* surroundings,
             const Vec3& middle);

  /// Radiance that a ray sees which leaves the scene; of the studio, without its lamp. @param solid_angle  Over which
  /// to average.
  [[nodiscard]] Vec3 around(const Vec3& direction, double solid_angle) const;
  /// Light that a white surface shows of all but lamps where nothing hides it.
  [[nodiscard]] Vec3 smooth_on(const Vec3& normal) const;
  [[nodiscard]] bool has_lamps() const;
  /// Whether around() holds the lamps, so that mirrors need not look for them.
  [[nodiscard]] bool has_lamps_around() const { return surroundings_ != nullptr; }
  struct Sample {
    Vec3 direction = Vec3::UnitZ();
    Vec3 weight = Vec3::Zero();  ///< Radiance over density: a white surface at right angles to it shows weight / pi.
    double pdf = 0.0;            ///< Per steradian; infinite for a point.
    double distance = std::numeric_limits<double>::infinity();
  };
  /// A place of a lamp.
  struct Lamp {
    Sample of_surroundings;
    Vec3 point = Vec3::Zero();  ///< Point of the studio's lamp, as KeyLight has it.
  };
  [[nodiscard]] Lamp lamp(const Vec2& square) const;
  /// Lamp as seen from a place.
  [[nodiscard]] Sample seen(const Lamp& lamp, const Vec3& place) const;
  /// Sample of the lamp that around() does not hold: radiance in `weight`, and the density with which lamp() chooses
  /// the direction; 0 for a point, or beside it.
  [[nodiscard]] Sample lamp_along(const Vec3& direction, const Vec3& place) const;

 private:
  [[nodiscard]] Vec3 local(const Vec3& world) const;
  [[nodiscard]] Vec3 world(const Vec3& local) const;

  RenderOptions options_;
  const Surroundings* surroundings_;
  double turn_ = 0.0;  ///< Radians.
  Vec3 up_;
  KeyLight key_;
};

}  // namespace patinate
