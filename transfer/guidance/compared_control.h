/// \file
/// A history's control as synthesis compares it: without what is finer than a surface ever asks for.
#pragma once

#include <string>

#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

/// A control is often a texture itself: half of the variance of a rusty sheet's height lies within 15 pixels. What a
/// surface asks for is smooth, so that inside a copied piece the two differ from pixel to pixel, and the search tears
/// pieces apart to make up for it. Such a control is blurred by the least Gaussian, of 2, 2.8, 4 ... 16 pixels, that
/// leaves at most a tenth of the variance within 15 pixels, and gets its distribution back by rank. Others stay as they
/// are, to the bit, and so does kLibraryControl. In a library each history is looked at by itself.
/// @param mask  Of the history's size: what counts, and what is blurred.
/// @returns the control, [0, 1].
[[nodiscard]] ImageF compared_control(const History& history, const std::string& name, const ImageU8& mask,
                                      const RunControl& control = {});

/// Compared form of an image. @param blur_px  Set to the Gaussian's sigma; 0: none.
[[nodiscard]] ImageF without_fine_texture(const ImageF& values, const ImageU8& mask, double& blur_px,
                                          const RunControl& control = {});

}  // namespace patinate::transfer
