/// \file
/// How far a made texture's statistics are from its source's. All in sRGB codes, [0, 255].
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "analysis/evaluation/synthesized_map.h"
#include "analysis/evaluation/value_counts.h"

namespace patinate::analysis {

struct TextureDistanceOptions {
  int num_samples = 20000;  ///< Patches, or texels, drawn from either side; >= 1.
  int num_directions = 64;  ///< >= 1.
  std::uint64_t seed = 1;
};

/// Draws from a map: source pixels of patches row by row, and of texels with their controls, by the number of
/// the draw. Those that lie in a part are told by it.
struct TextureDraws {
  std::vector<std::int64_t> patch_numbers, texel_numbers;
  std::vector<std::int32_t> patches, texels;  ///< 49 pixels a patch; one a texel.
  std::vector<float> controls;                ///< One a texel; none without a control.

  void add(const TextureDraws& other);
};
/// @param before  In earlier parts. @param all  In all parts.
/// @param source_control  What stands for the part's control where it has none; may be empty.
[[nodiscard]] TextureDraws draw_texture(const MapPart& part, const ImageF& source_control, const PartCounts& before,
                                        const PartCounts& all, const TextureDistanceOptions& options);

/// Sliced 1-Wasserstein distance of 7 x 7 color patches [Rabin et al. 2012; patches as in Elnekave and Weiss 2022]:
/// mean over directions of R^147 of the distance of projections, in codes. Nothing where a side has no whole patch.
/// @param frame  Of the source's. @param made  Nothing: the source itself, drawn again.
[[nodiscard]] std::optional<double> patch_distance(const SynthesisSource& source, const ImageF& frame,
                                                   const TextureDraws* made, const TextureDistanceOptions& options,
                                                   const RunControl& control = {});
/// Joint distance of (R, G, B, 255 P): whether color and control still go together. @throws InvalidInput without
/// controls.
[[nodiscard]] std::optional<double> joint_distance(const SynthesisSource& source, const ImageF& frame,
                                                   const TextureDraws* made, const TextureDistanceOptions& options,
                                                   const RunControl& control = {});

/// Lengths of luma gradients (forward differences inside charts), codes per pixel, in bins of 2^-10.
[[nodiscard]] ValueCounts count_gradients(const SynthesisSource& source, const ImageF& frame);
[[nodiscard]] ValueCounts count_gradients(const MapPart& part, const ImageF& frame);
/// 1-Wasserstein distance of the two: blur and noise both show. Nothing where one is empty.
[[nodiscard]] std::optional<double> gradient_distance(const ValueCounts& a, const ValueCounts& b);

/// Power of L* in half-octave rings of frequency, summed over tiles of up to 64 pixels that are covered.
struct SpectrumSums {
  double num_tiles = 0.0;
  std::vector<double> frequencies, power;

  void add(const SpectrumSums& other);
};
[[nodiscard]] SpectrumSums measure_spectrum(const SynthesisSource& source, const ImageF& frame);
[[nodiscard]] SpectrumSums measure_spectrum(const MapPart& part, const ImageF& frame);
/// Mean |log10| of the ratio of the mean power.
[[nodiscard]] std::optional<double> spectrum_distance(const SpectrumSums& a, const SpectrumSums& b);

}  // namespace patinate::analysis
