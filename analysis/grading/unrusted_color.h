/// \file
/// The color that a surface would have without rust.
#pragma once

#include <array>
#include <cstddef>

#include "patinate/image/image.h"

namespace patinate::analysis {

/// The color of a pixel, by its index. @param image  H x W x 3.
[[nodiscard]] inline std::array<double, 3> pixel_of(const ImageF& image, std::size_t i) {
  const float* c = image.data() + 3 * i;
  return {static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
}

/// The unexposed surface times the drift of clean places around each pixel: medians over blocks, bilinear between them.
/// @param unexposed, color  H x W x 3, linear. @param mask  0 = outside. @param is_rust  Not 0 = no clean place.
[[nodiscard]] ImageF unrusted_color(const ImageF& unexposed, const ImageF& color, const ImageU8& mask,
                                    const ImageU8& is_rust);
/// Paint's color without an unexposed surface: the commonest color around each pixel.
[[nodiscard]] ImageF common_color(const ImageF& color, const ImageU8& mask, const ImageU8& is_rust);

}  // namespace patinate::analysis
