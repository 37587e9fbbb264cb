/// \file
/// What the stages of unlighting share. Inside of unlighting only.
#pragma once

#include <functional>
#include <vector>

#include "capture/unlighting/texel_fit.h"

namespace patinate::capture {

struct UnlightWork {
  /// Checks the input, and says of every sample whether it may count (Clean), or is Outside, Unlit, CastShadow or
  /// Invalid.
  /// @throws InvalidInput
  UnlightWork(const UnlightInput& input, const UnlightOptions& options, const RunControl& control);
  /// As it was at the end of unlight(); samples that were rejected may count again.
  UnlightWork(const UnlightInput& input, const UnlightOptions& options, const UnlightResult& result);

  const UnlightInput& input;
  const UnlightOptions& options;
  int width = 0;
  int height = 0;
  int num_lights = 0;
  int num_channels = 0;
  ImageF normal;                ///< H x W x 3, unit; where fits begin.
  ImageU8 samples;              ///< H x W x L, SampleState before any fit.
  std::vector<Vec3> strengths;  ///< L, times the given intensities.
  Vec3 ambient = Vec3::Zero();
  double noise_scale = 1.0;
  SpecularLobe lobe = SpecularLobe::Ggx;
  ImageF specular;          ///< H x W x 2, as UnlightResult's; subtracted by load() once it is there.
  ImageF highlight_normal;  ///< H x W x 3, under which it is.

  [[nodiscard]] bool is_surface(int x, int y) const { return is_inside(input.mask, x, y); }
  [[nodiscard]] Vec3 position(int x, int y) const;
  /// Of a photographed value, before the noise scale.
  [[nodiscard]] double variance_of(double value) const {
    return options.noise_floor * options.noise_floor + options.noise_share * options.noise_share * value * value;
  }
  [[nodiscard]] TexelFitOptions fit_options() const;
  /// Unit, from a texel to the camera.
  [[nodiscard]] Vec3 to_camera(int x, int y) const;
  /// Everything that fit_texel() needs of a texel; its highlights are subtracted, and their share of it makes the
  /// samples less certain.
  void load(int x, int y, TexelSamples& texel) const;
  /// The same with highlights.
  void load_raw(int x, int y, TexelSamples& texel) const;
  /// At most `max_count` texels of the surface, spread evenly over it, as y * width + x.
  [[nodiscard]] std::vector<std::int64_t> spread_texels(std::int64_t max_count) const;
};

/// Median over texels of how much larger residuals are than expected; iterated, since what counts as clean depends on
/// it. Not below 1e-4.
/// @param max_rounds  1: of fits to every sample, shadows and highlights included.
[[nodiscard]] double estimate_noise_scale(const UnlightWork& work, const RunControl& control, int max_rounds = 8);

[[nodiscard]] inline Vec3 vector_of(const ImageF& image, int x, int y) {
  const auto p = image.pixel(x, y);
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

}  // namespace patinate::capture
