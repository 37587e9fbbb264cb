/// \file
/// A glossy piece under a few near lamps, scanned with noise and laid a little beside its place: truth for unlighting
/// with lobes that it has no formula for.
#pragma once

#include <cstdint>
#include <memory>

#include "patinate/capture/unlight.h"

namespace patinate::testing_support {

/// Each as its authors wrote it, not as unlighting does.
enum class LobeModel { None, Blinn, Ggx, Ward, CookTorrance, Phong };
enum class Material {
  Plastic,  ///< Colored, under a white lobe.
  Metal     ///< Copper's color, and its lobe has the same.
};
enum class Piece {
  Mold,   ///< A dome with flutes and dents.
  Saddle  ///< A saddle with ridges across.
};

struct GlossSceneOptions {
  Piece piece = Piece::Mold;
  LobeModel lobe = LobeModel::Blinn;
  Material material = Material::Metal;
  double strength = 0.12;  ///< Reflectance straight from above; of Phong and Blinn, the share of light.
  double width = 0.18;  ///< Slope of the facets (alpha); Blinn's exponent is 2 / width^2 - 2, Phong's a quarter of it.
  bool has_fresnel = false;  ///< Schlick's, from `strength`.
  int size = 112;            ///< Pixels along a side.
  int num_lights = 5;
  double scan_noise_mm = 0.05;
  double scan_spacing_mm = 0.7;
  double pose_mm = 0.03, pose_deg = 0.03;  ///< How far the scan lies beside its place; standard deviations.
  double noise = 0.004;                    ///< Noise of the photographs' sRGB codes / 255.
  std::uint64_t seed = 1;
};

struct GlossScene {
  std::unique_ptr<const Mesh> scan;
  capture::UnlightInput input;  ///< With the scan as blockers.
  ImageF albedo;                ///< The truth.
  ImageF normal;
};
[[nodiscard]] GlossScene gloss_scene(const GlossSceneOptions& options);

/// Errors of determined texels.
struct AlbedoErrors {
  Vec3 bias = Vec3::Zero();  ///< Percent: mean of found / truth - 1, of every channel.
  double rms = 0.0;          ///< Percent: of found / truth - 1 over all channels.
  double z = 0.0;  ///< Standard deviation (by the median of the absolute values) of errors over the stated deviation.
  double determined = 0.0;  ///< Share of the surface.
};
[[nodiscard]] AlbedoErrors albedo_errors(const GlossScene& scene, const capture::UnlightResult& result);

}  // namespace patinate::testing_support
