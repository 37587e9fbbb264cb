/// \file
/// Lights from their reflections in mirror spheres: where a sphere is in space, where a light's reflection in it is
/// seen, and what that says of the light, its direction from one sphere, its position from two or more.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/camera.h"
#include "patinate/geometry/light.h"
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

/// A mirrored ray: the point where it meets the sphere, and the direction to the light.
struct MirroredRay {
  Vec3 point;
  Vec3 direction;  ///< Unit, from the point.
};
/// The ray that a pixel sees mirrored in the sphere; nothing for a pixel beside it.
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

struct SphereLightOptions {
  double outline_sigma_px = 0.1;    ///< Noise of the outlines' points; > 0. Only the ratio to the next weighs.
  double highlight_sigma_px = 0.1;  ///< Noise of the highlights; > 0.
  double max_distance_sd =
      0.2;  ///< A light whose distance is known worse than this share of it is given as a direction; > 0.
};
void describe(OptionVisitor& v, SphereLightOptions& o);

enum class SphereLightStatus {
  Position,       ///< Two or more spheres fix where it stands.
  DirectionOnly,  ///< One sphere, or the light is too far for its distance to show.
  NoHighlight,    ///< No sphere shows it.
};
[[nodiscard]] std::string sphere_light_status_text(SphereLightStatus status);

/// One light, and how well it is known.
struct SphereLight {
  SphereLightStatus status = SphereLightStatus::NoHighlight;
  Light light;  ///< Near or Directional; its strength is not known.
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();    ///< Covariance of the position, mm^2, or of the unit direction.
  double direction_sd_deg = 0.0;  ///< Seen from the spheres, the worst direction.
  double position_sd_mm = 0.0;    ///< Near: the worst direction.
  int num_spheres = 0;            ///< Number of spheres that show the light.
  double rms_px = 0.0;            ///< Root mean square distance of the highlights from their predicted positions.
  double distance_sd = 0.0;       ///< Standard deviation of the distance over the distance; 0 for one sphere.
};

struct SphereLightResult {
  std::vector<SphereLight> lights;
  std::vector<SphereFit> spheres;  ///< Spheres of the joint solution.
  bool has_converged = false;
};

/// highlights[light][sphere]: the pixel, or nothing where that sphere does not show the light.
using Highlights = std::vector<std::vector<std::optional<Vec2>>>;

/// Spheres from their outlines; each highlight's ray is mirrored in its sphere, and a light is where its rays meet
/// (least squares), then all centers and lights are refined together: Ceres on the distances in pixels of outlines and
/// highlights, full perspective, highlights beyond three sigma weighing less (Huber). The covariance is that of the
/// noise given in the options, times the ratio of the residuals' variance to it where that is above 1 (at least ten
/// residuals left over). It does not contain the camera's.
/// @throws InvalidInput naming the sphere that is out of the picture or no sphere, if there is none, sizes do not fit,
/// a highlight lies beside its sphere, or an option is out of range.
[[nodiscard]] SphereLightResult lights_from_spheres(const Camera& camera_mm, const std::vector<MirrorSphere>& spheres,
                                                    const Highlights& highlights,
                                                    const SphereLightOptions& options = {},
                                                    const RunControl& control = {});

/// A camera far away, for pictures without a calibration: directions then come out in the camera's frame, to about 1e-2
/// degrees of what an orthographic camera would see.
[[nodiscard]] Camera distant_camera(int width, int height);

}  // namespace patinate::capture
