/// \file
/// A relief of Gaussian bumps under near or distant lamps, rendered by formula: truth for unlighting.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "patinate/capture/unlight.h"

namespace patinate::testing_support {

enum class Coding { Float, Srgb8 };
enum class Gloss { BlinnPhong, Ggx };

struct LitReliefOptions {
  int size = 96;  ///< Pixels along a side.
  double side_mm = 100.0;
  double height_mm = 20.0;  ///< Height of the highest bump; 0 = a plane.
  int num_lights = 8;
  Light::Kind kind = Light::Kind::Near;
  double lamp_distance_mm = 350.0;
  bool cast_shadows = true;
  double gloss = 0.0;  ///< F0 of the lobe; of Blinn-Phong's, the share of the light.
  Gloss lobe = Gloss::BlinnPhong;
  double roughness = 0.45;        ///< Roughness of GGX.
  double gloss_exponent = 40.0;   ///< Exponent of Blinn-Phong.
  bool gloss_varies = false;      ///< From 0 at the left to `gloss` at the right.
  double normal_noise_deg = 0.0;  ///< Root mean square angle of the scan's normals.
  double scan_noise_mm = 0.0;     ///< Noise of the blockers' vertices.
  double noise_share = 0.0;       ///< Noise of the photographs.
  double saturated = 0.0;         ///< Share of the lit samples above white.
  Coding coding = Coding::Float;
  Vec3 ambient = Vec3::Zero();  ///< Irradiance from everywhere.
  bool is_gray = false;
  std::uint64_t seed = 1;
};

struct LitRelief {
  capture::UnlightInput input;  ///< Without blockers: point it at `scan` where wanted.
  Mesh scan;
  ImageF albedo;  ///< The truth; scaled as the photographs are (exposure is in the lamps' intensities).
  ImageF normal;
  ImageU8 shadow;  ///< H x W x L, 255 = in a cast shadow, found by marching over the formula.
};
[[nodiscard]] LitRelief lit_relief(const LitReliefOptions& options = {});

/// 100 times the root mean square of (found - truth) / truth over determined pixels.
[[nodiscard]] double relative_error_percent(const capture::UnlightResult& result, const ImageF& truth);
/// Median angle between two normal maps inside a mask, degrees.
[[nodiscard]] double median_angle_deg(const ImageF& a, const ImageF& b, const ImageU8& mask);

}  // namespace patinate::testing_support
