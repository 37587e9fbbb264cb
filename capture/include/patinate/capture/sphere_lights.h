/// \file
/// Lights from their reflections in mirror spheres: directions from one sphere, positions from two or more.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "patinate/capture/mirror_sphere.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/light.h"

namespace patinate::capture {

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
  Light light;                                           ///< Near or Directional; its strength is not known.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of the position, mm^2; or of the unit direction.
  double direction_sd_deg = 0.0;                         ///< Seen from the spheres, the worst direction.
  double position_sd_mm = 0.0;                           ///< Near: the worst direction.
  int num_spheres = 0;                                   ///< That show it.
  double rms_px = 0.0;                                   ///< Of the highlights around where the solution puts them.
  double distance_sd = 0.0;  ///< Standard deviation of the distance over the distance; 0 for one sphere.
};

struct SphereLightResult {
  std::vector<SphereLight> lights;
  std::vector<SphereFit> spheres;  ///< As the joint solution has them.
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
