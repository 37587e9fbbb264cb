/// \file
/// A mirror sphere in a photograph: where it is in space, and where a light's reflection in it is seen.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "patinate/geometry/camera.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// A mirror sphere of known size, by points of its outline in the photograph.
struct MirrorSphere {
  double radius_mm = 0.0;        ///< > 0.
  std::vector<Vec2> outline_px;  ///< At least 5, anywhere on the outline; an arc does, less accurately.
  std::string name;
};

enum class SphereFitStatus {
  Converged,
  OutOfPicture,  ///< Its center is not in the picture.
  NoSphere,      ///< The points lie on no outline of a sphere: on a line, in one place, or the rms is above a tenth of
                 ///< their extent.
};

/// Where a sphere is.
struct SphereFit {
  SphereFitStatus status = SphereFitStatus::NoSphere;
  Vec3 center = Vec3::Zero();  ///< In the world, mm.
  double rms_px = 0.0;         ///< Distance of the points from the outline, along the picture.
  double radius_px = 0.0;      ///< Mean distance of the outline from its middle.
};

/// The center from the cone of rays that touch the sphere, full perspective: every such ray has the angle asin(radius /
/// distance) with the ray to the center. Least squares of the points' distances in pixels (Gauss-Newton from the mean
/// ray); outlines of spheres are ellipses in a picture, and the projected center is not the ellipse's.
/// @throws InvalidInput if the radius is not > 0, there are fewer than 5 points, or one is not finite.
[[nodiscard]] SphereFit fit_sphere(const Camera& camera_mm, const MirrorSphere& sphere);

/// Outline of what a mask covers, between pixels inside and outside; @throws InvalidInput if it covers nothing, or
/// touches the border.
[[nodiscard]] std::vector<Vec2> outline_of_mask(const ImageU8& mask);
/// `count` points of a circle in the picture. @throws InvalidInput unless radius_px > 0.
[[nodiscard]] std::vector<Vec2> outline_of_circle(const Vec2& center_px, double radius_px, int count = 64);

/// A mirrored ray: where the sphere is met, and where the light comes from.
struct MirroredRay {
  Vec3 point;
  Vec3 direction;  ///< Unit, from the point.
};
/// What a pixel sees in the sphere; nothing beside it.
[[nodiscard]] std::optional<MirroredRay> mirrored_ray(const Camera& camera_mm, const Vec3& center, double radius_mm,
                                                      const Vec2& pixel);

enum class HighlightStatus {
  Found,
  OutOfPicture,  ///< Part of the sphere lies outside of the photograph.
  None,  ///< Nothing on the sphere is much brighter than the rest: a black photograph, a white one, or a light behind
         ///< the sphere.
  Several,   ///< Two reflections of similar strength.
  TooLarge,  ///< More than a twentieth of the sphere: overexposed.
};
[[nodiscard]] std::string highlight_status_text(HighlightStatus status);

struct Highlight {
  HighlightStatus status = HighlightStatus::None;
  Vec2 pixel = Vec2::Zero();
  double area_px = 0.0;
  double contrast = 0.0;  ///< Peak over the sphere's median, linear.
};
/// The light's reflection: pixels on the sphere above half way from its median to its peak, the piece of them with most
/// light in it; then the middle of its plateau (above 90 %, at least 50 pixels: a lamp that saturates), or the centroid
/// of the light above what is around, in a disc twice as wide as the piece.
/// @param photo  H x W x 1 or 3, linear, finite.
[[nodiscard]] Highlight find_highlight(const ImageF& photo, const Camera& camera_mm, const Vec3& center,
                                       double radius_mm);

}  // namespace patinate::capture
