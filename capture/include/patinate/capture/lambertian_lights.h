/// \file
/// Lights from how they shade a diffuse object of known shape: positions, strengths in each channel, ambient light and
/// the lens's vignetting.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "patinate/capture/camera_calibration.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/light.h"

namespace patinate::capture {

/// The sample of one pixel of the object under one light.
struct ShadedSample {
  Vec3 point_mm;  ///< On the object, scanner coordinates.
  Vec3 normal;    ///< Unit, toward the camera.
  Vec2 pixel;     ///< Where in the photograph.
  Vec3 value;     ///< Red, green, blue, linear; finite.
};

struct LambertianLightOptions {
  double albedo = 1.0;           ///< Of the object; > 0. Strengths are in proportion to 1 / albedo.
  bool has_ambient = false;      ///< Fit a constant that every light's photographs share, in each channel.
  bool has_vignetting = false;   ///< Fit 1 + v1 r^2 + v2 r^4, r = 1 at the picture's corners, shared by all lights.
  double saturated = 0.98;       ///< Samples with a channel from here on are excluded; > 0.
  double huber_sigmas = 3.0;     ///< Samples farther off weigh less; > 0.
  double max_distance_sd = 0.1;  ///< A distance known worse than this share of it counts as not determined; > 0.
};
void describe(OptionVisitor& v, LambertianLightOptions& o);

/// One light. value = albedo / pi * intensity * max(0, n . l) / d^2 * vignetting + ambient.
struct LambertianLight {
  CalibrationStatus status = CalibrationStatus::Undetermined;
  Light light;                                                                   ///< Near.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  ///< Position (mm), then intensity.
  double distance_sd = 0.0;  ///< Standard deviation of the distance from the samples' middle, relative to it; infinite
                             ///< when undetermined.
  double rms = 0.0;          ///< Root mean square of the residuals, linear.
  int num_samples = 0;       ///< Number of samples that were used: neither saturated nor facing away.
};

struct LambertianLightResult {
  std::vector<LambertianLight> lights;
  Vec3 ambient = Vec3::Zero();
  Vec2 vignetting = Vec2::Zero();  ///< v1, v2.
  double sigma = 0.0;              ///< Standard deviation of one value, from the residuals' median.
};

/// Each light starts at the best of a grid of directions and distances, at each of which strengths are linear least
/// squares; then Ceres refines all lights, ambient and vignetting together (Huber, its scale from the residuals'
/// median, three rounds). A single flat pose leaves distance against strength open when the light is far or the values
/// are noisy: the status and distance_sd say so.
/// @param given  Samples [light]: at least 20 each; for a target, all its poses together.
/// @param camera_mm  For the picture's middle and corners (vignetting).
/// @throws InvalidInput naming the light: too few samples, numbers that are not finite, normals of another length than
/// 1, nothing but black or saturated samples.
[[nodiscard]] LambertianLightResult lights_from_lambertian(const Camera& camera_mm,
                                                           const std::vector<std::vector<ShadedSample>>& given,
                                                           const LambertianLightOptions& options = {},
                                                           const RunControl& control = {});

}  // namespace patinate::capture
