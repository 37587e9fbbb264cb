/// \file
/// What a surface is made of beside its color, at the texels and times of a color stack, and how it reflects.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "analysis/figures/color_stack.h"

namespace patinate::analysis {

/// The metallic-roughness model, at some of a stack's times: times x texels.
struct MaterialStack {
  std::size_t num_texels = 0;
  std::vector<float> roughness, metalness;  ///< [0, 1]
  std::vector<float> base, specular;        ///< x 3, linear: color, and reflectance at normal incidence of no metal.
  std::vector<float> height;                ///< mm; empty where the history knows none.

  /// Reflectance at normal incidence, mean of the channels. @param at  time * num_texels + texel.
  [[nodiscard]] float reflectance(std::size_t at) const;
};

/// The history says something of its material, beside color and deviation.
[[nodiscard]] bool states_material(const HistoryFacts& facts);

/// Maps that nobody states hold what `render` takes: a dull dielectric.
/// @param times  Indices of the stack's times. @throws IoError. Memory: 32 B a texel and time.
[[nodiscard]] MaterialStack load_materials(const TextureSeries& series, const ColorStack& stack,
                                           std::span<const std::size_t> times, const RunControl& control = {});

/// Directions of light and view at which a BRDF is told, times three channels.
inline constexpr std::size_t kNumReflections = std::size_t{3} * 16 * 3;
/// log(1 + f cos) [Low et al. 2012], f the BRDF in 1/sr and cos that of the light, for views 15, 45 and 60 degrees off
/// the normal and light from 0 to 75 degrees at 0, 90 and 180 degrees around it.
using Reflections = std::array<float, kNumReflections>;
[[nodiscard]] Reflections reflections_of(const MaterialStack& stack, std::size_t at);
/// Root mean square difference.
[[nodiscard]] double reflection_distance(std::span<const double, kNumReflections> a,
                                         std::span<const double, kNumReflections> b);

}  // namespace patinate::analysis
