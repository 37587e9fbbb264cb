/// \file
/// Albedo and normal of one texel from its samples under several lamps. Inside of unlighting only.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "patinate/capture/unlight.h"

namespace patinate::capture {

/// The highlight of a texel, as its neighborhood has it.
struct TexelHighlight {
  double strength = 0.0;  ///< 0: none.
  double roughness = 0.5;
  SpecularForm form = {};
  std::array<double, 3> tint{};  ///< Tint of each channel; their mean is 1.
  Vec3 to_camera = Vec3(0, 0, 1);
  double freedom = 0.3;  ///< By which the texel's own highlight differs, as a share; standard deviation, > 0.
  double metal = 0.0;    ///< Share of metal, [0, 1]: what is metal has hardly any albedo.

  /// Precision of a channel's albedo being 0. Not of what is half metal or less.
  [[nodiscard]] double black_precision() const {
    constexpr double kLeast = 0.5, kNone = 0.02, kHalf = 0.5;  // Standard deviations: of metal, and beside it.
    if (!(metal > kLeast)) return 0.0;
    const double sigma = kNone + kHalf * (1.0 - metal);
    return 1.0 / (sigma * sigma);
  }
};

/// Samples of one texel under all lamps; arrays of L, or of L x C with the channel running fastest. Reused from texel
/// to texel.
struct TexelSamples {
  int num_lights = 0;
  int num_channels = 0;
  std::vector<Vec3> direction;  ///< Unit, to the lamp.
  std::vector<double>
      irradiance;  ///< That reaches a surface facing the lamp, over pi: times cosine and albedo it is the value.
  std::vector<double>
      ambient;  ///< Irradiance over pi that comes whatever the normal: from everywhere, and from the surface itself.
  std::vector<double> value;     ///< Photographed.
  std::vector<double> variance;  ///< Variance of value, before the noise scale.
  TexelHighlight highlight;
  std::vector<SampleState>
      state;  ///< Clean to begin with where the sample may count; fit_texel() adds Darker and Brighter.
  Vec3 normal = Vec3(0, 0, 1);  ///< Where to begin; the scan's.

  void resize(int lights, int channels);
  [[nodiscard]] std::size_t index(int light, int channel) const {
    return static_cast<std::size_t>(light * num_channels + channel);
  }
};

struct TexelFitOptions {
  bool refine_normal = true;
  double normal_sigma =
      0.0;  ///< Radians, of the angle between `normal` and the truth; infinite: the samples alone decide.
  bool reject = true;
  double rejection_sigma = 3.0;
  double noise_scale = 1.0;  ///< Times sqrt(variance).
  double min_cosine = 0.05;
  int min_lights = 2;
  double small_step = 1e-9;  ///< Turn of the normal plus share of the albedo below which a fit has settled; > 0.

  /// How far off a sample may be before it is rejected, in standard deviations of the noise that was found. The noise
  /// is never taken for less than kMinNoise of what `variance` expects: photographs without noise would else be
  /// rejected wherever the model is a hair off.
  [[nodiscard]] double rejection_width() const { return rejection_sigma * std::max(1.0, kMinNoise / noise_scale); }
  static constexpr double kMinNoise =
      0.3;  ///< Rounding to 8-bit sRGB alone is twice that (of the default floor and share).
};

struct TexelFit {
  bool is_determined = false;
  std::array<double, 3> albedo{};
  std::array<double, 3> stddev{};
  Vec3 normal = Vec3(0, 0, 1);
  double gain = 1.0;  ///< The texel's own highlight over the one that was given.
  int num_clean = 0;
  double chi2 = 0.0;                ///< Chi2 of the clean samples, in noise_scale units.
  double degrees_of_freedom = 0.0;  ///< Degrees of freedom of chi2; the prior's share of the normal is none.
};

/// The highlight in one channel's value under a normal.
[[nodiscard]] double highlight_value(const TexelSamples& samples, int light, int channel, const Vec3& normal);

/// Excess of a fitted albedo's channel, over itself, if its clean samples were left with their highlight.
[[nodiscard]] double highlight_share(const TexelSamples& samples, const TexelFit& fit, int channel);

/// Least squares of value = albedo (irradiance max(0, n . l) + ambient) + highlight over albedos, the normal that both
/// share, and the highlight's gain (about 1, by its freedom), by Gauss-Newton steps with the albedos eliminated. With
/// `reject`, from the median of value / light under the starting normal, first with Geman and McClure's weights whose
/// width shrinks to rejection_sigma (graduated non-convexity [Blake and Zisserman 1987]), then with those samples only
/// that are nearer than it. Sets samples.state.
[[nodiscard]] TexelFit fit_texel(TexelSamples& samples, const TexelFitOptions& options);

}  // namespace patinate::capture
