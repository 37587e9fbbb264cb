/// \file
/// A photograph's camera: where a point of the world is seen, and where a pixel looks. OpenCV's conventions: pinhole
/// with Brown distortion, x right, y down, z forward, pixel centers at integers.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// The numbers of a calibration.
struct CameraParameters {
  int width = 0;  ///< Of the photographs, pixels; [1, 65536].
  int height = 0;
  double fx = 0.0;  ///< Focal lengths, pixels; 0.001 to 1e6 longer sides of the picture.
  double fy = 0.0;
  double cx = 0.0;  ///< Principal point, pixels; at most 1e4 longer sides from the first one.
  double cy = 0.0;
  std::array<double, 5> distortion{};  ///< k1 k2 p1 p2 k3 [Brown 1971].
  Eigen::Matrix3d rotation =
      Eigen::Matrix3d::Identity();  ///< x_in_camera = rotation x_in_world + translation; orthonormal to 1e-6, det +1.
  Vec3 translation = Vec3::Zero();  ///< In the world's unit.
};

/// Points origin + s direction, s > 0, in the world.
struct CameraRay {
  Vec3 origin;
  Vec3 direction;  ///< Unit.
};

/// With x = X / Z, y = Y / Z of a point in the camera and r^2 = x^2 + y^2, it is seen at
///
///     u = fx (x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)) + cx
///     v = fy (y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y) + cy
///
/// Only where the radial part rises with r: beyond, the polynomial folds back into the picture, which no lens does.
/// Immutable; safe to use from several threads.
class Camera {
 public:
  /// The rotation is brought to the nearest exactly orthonormal one.
  /// @throws InvalidInput naming the parameter that is out of range.
  explicit Camera(const CameraParameters& parameters);

  [[nodiscard]] const CameraParameters& parameters() const { return parameters_; }
  /// Position of the camera in the world.
  [[nodiscard]] const Vec3& center() const { return center_; }
  /// Pixel at which a point is seen, in the picture or not; nothing behind the camera or beyond the lens model's reach.
  [[nodiscard]] std::optional<Vec2> project(const Vec3& in_world) const;
  /// The ray of a pixel; project() of its points is the pixel to 1e-9 px (damped Newton). Nothing if the pixel shows no
  /// direction.
  [[nodiscard]] std::optional<CameraRay> ray(const Vec2& pixel) const;
  /// The same camera in a world of another unit. @param factor  New units per old unit; > 0.
  [[nodiscard]] Camera scaled(double factor) const;
  /// Every parameter, for content keys; equal cameras give equal text.
  [[nodiscard]] std::string text() const;

 private:
  [[nodiscard]] Vec2 distort(const Vec2& x) const;
  [[nodiscard]] Eigen::Matrix2d distort_slope(const Vec2& x) const;

  CameraParameters parameters_;
  Vec3 center_;
  double max_radius2_;  ///< Of x, y in front of the lens; infinite when the radial part always rises.
};

}  // namespace patinate
