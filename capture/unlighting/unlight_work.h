/// \file
/// What the stages of unlighting share. Inside of unlighting only.
#pragma once

#include <array>
#include <vector>

#include "capture/unlighting/texel_fit.h"

namespace patinate::capture {

inline constexpr int kHighlightStep = 4;  ///< One of so many texels tells of highlights.

struct UnlightWork {
  /// Checks the input, and says of every sample whether it may count (Clean), or is Outside, Unlit, CastShadow or
  /// Invalid.
  /// @throws InvalidInput
  UnlightWork(const UnlightInput& input, const UnlightOptions& options, const RunControl& control);
  /// State at the end of unlight(); samples that were rejected may count again.
  UnlightWork(const UnlightInput& input, const UnlightOptions& options, const UnlightResult& result);

  /// One texel of every `step` x `step` of another's. @param thin  thinned_input() of its input; outlives this.
  UnlightWork(const UnlightInput& thin, const UnlightWork& whole, int step);

  const UnlightInput& input;
  const UnlightOptions& options;
  int width = 0;
  int height = 0;
  int num_lights = 0;
  int num_channels = 0;
  ImageF normal;                ///< H x W x 3, unit; where fits begin.
  ImageU8 samples;              ///< H x W x L, SampleState before any fit.
  ImageF indirect;              ///< H x W x L C, as UnlightResult's; load() gives it to the fit once it is there.
  std::vector<Vec3> strengths;  ///< L, times the given intensities.
  Vec3 ambient = Vec3::Zero();
  double noise_scale = 1.0;
  SpecularForm form = {};
  double highlight_freedom = 0.1;  ///< By which texels' highlights differ from their neighborhood's, as a share.
  double highlight_off = 0.05;     ///< By which highlights are off the form, as a share of them.
  double form_deviation =
      0.0;  ///< Deviation of all highlights together, for the form is not known for sure; a share of them.
  int highlight_step = kHighlightStep;  ///< One of so many texels tells of highlights: neighbors tell much the same.
  ImageF specular;                      ///< H x W x 2, as UnlightResult's; load() gives it to the fit once it is there.
  ImageF highlight_normal;              ///< H x W x 3, of the last fit.
  ImageF highlight_base;                ///< H x W x C, its albedo.
  ImageF highlight_tint;                ///< H x W x 3, mean 1: of materials. Empty: by the form.
  ImageF highlight_metal;               ///< H x W x 2, of materials: shares of metal, which has no albedo, and of what
                                        ///< is mixed.

  [[nodiscard]] bool is_surface(int x, int y) const { return is_inside(input.mask, x, y); }
  [[nodiscard]] Vec3 position(int x, int y) const;
  /// Variance of a photographed value, before the noise scale.
  [[nodiscard]] double variance_of(double value) const {
    return options.noise_floor * options.noise_floor + options.noise_share * options.noise_share * value * value;
  }
  [[nodiscard]] TexelFitOptions fit_options() const;
  /// Unit, from a texel to the camera.
  [[nodiscard]] Vec3 to_camera(int x, int y) const;
  /// Everything that fit_texel() needs of a texel; its highlight makes the samples less certain.
  void load(int x, int y, TexelSamples& texel) const;
  /// Loads a texel without its highlight.
  void load_raw(int x, int y, TexelSamples& texel) const;
  /// Its highlight under this normal makes the samples less certain.
  void add_highlight_variance(TexelSamples& texel, const Vec3& normal) const;
  /// Tint of a texel's highlight: the mean over channels is 1.
  [[nodiscard]] std::array<double, 3> tint(SpecularTint kind, int x, int y) const;
  /// At most `max_count` texels of the surface, spread evenly over it, as y * width + x.
  [[nodiscard]] std::vector<std::int64_t> spread_texels(std::int64_t max_count) const;
};

/// Median over texels of how much larger residuals are than expected; iterated, since what counts as clean depends on
/// it. Not below 1e-4.
/// @param max_rounds  1: of fits to every sample, shadows and highlights included.
[[nodiscard]] double estimate_noise_scale(const UnlightWork& work, const RunControl& control, int max_rounds = 8);

/// Photographs and maps of one texel of every `step` x `step`; without blockers.
[[nodiscard]] UnlightInput thinned_input(const UnlightInput& input, int step);

/// Images for fit_surface(), all 0; without highlights.
[[nodiscard]] UnlightResult empty_result(const UnlightWork& work);
/// Fits every texel of the surface with the highlights that work has: albedo, stddev, normal, specular, mask and
/// samples of the result.
void fit_surface(const UnlightWork& work, UnlightResult& result, const RunControl& control);

[[nodiscard]] inline Vec3 vector_of(const ImageF& image, int x, int y) {
  const auto p = image.pixel(x, y);
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

}  // namespace patinate::capture
