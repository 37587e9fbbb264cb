/// \file
/// How far a made texture's statistics are from its source's. All in sRGB codes, [0, 255].
#pragma once

#include <cstdint>
#include <optional>

#include "analysis/evaluation/synthesized_map.h"

namespace patinate::analysis {

struct TextureDistanceOptions {
  int num_samples = 20000;  ///< Patches, or texels, drawn from either side; >= 1.
  int num_directions = 64;  ///< >= 1.
  std::uint64_t seed = 1;
};

/// A picture and where it holds.
struct TextureView {
  const ImageF& codes;  ///< H x W x 3.
  const ImageU8& mask;  ///< May be empty.
  std::span<const int>
      chart{};  ///< Of every pixel; empty: one chart. What is compared never reaches over a chart's border.
  const ImageF* control = nullptr;  ///< H x W x 1, for joint_distance().
};

/// Sliced 1-Wasserstein distance of 7 x 7 color patches [Rabin et al. 2012; patches as in Elnekave and Weiss 2022]:
/// mean over directions of R^147 of the distance of projections, in codes. Nothing where a side has no whole patch.
[[nodiscard]] std::optional<double> patch_distance(const TextureView& a, const TextureView& b,
                                                   const TextureDistanceOptions& options,
                                                   const RunControl& control = {});
/// The same of (R, G, B, 255 P): whether color and control still go together. @throws InvalidInput without controls.
[[nodiscard]] std::optional<double> joint_distance(const TextureView& a, const TextureView& b,
                                                   const TextureDistanceOptions& options,
                                                   const RunControl& control = {});
/// 1-Wasserstein distance of the lengths of luma gradients (forward differences), codes per pixel: blur and noise both
/// show.
[[nodiscard]] std::optional<double> gradient_distance(const TextureView& a, const TextureView& b);
/// Mean |log10| of the ratio of the power in half-octave rings of frequency, of L* in tiles of up to 64 pixels.
[[nodiscard]] std::optional<double> spectrum_distance(const TextureView& a, const TextureView& b);

}  // namespace patinate::analysis
