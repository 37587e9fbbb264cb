/// \file
/// How certain a layer's thickness is: what two halves of its pixels say of it.
#pragma once

#include "patinate/capture/thickness.h"

namespace patinate::capture {

/// The layer's light is filled in twice, from the white and from the black squares of a chess board, and compared: half
/// the difference is what all pixels together are off by. Squares of a quarter of the window, at least 2 px: grain that
/// neighbors share counts. Pooled over the window. What both halves have wrong (a slope within the window, light that
/// the layer did not pass) is not in it.
/// @param transmittance  T, H x W x 1, finite inside `known`. @param known  Not empty.
/// @returns H x W x 1, standard deviation of T; 0 outside. Cost: that of two fill_cracks().
[[nodiscard]] ImageF layer_deviation(const ImageF& transmittance, const ImageU8& known, const ThicknessOptions& options,
                                     const RunControl& control = {});

}  // namespace patinate::capture
