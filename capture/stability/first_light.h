/// \file
/// The uneven light of a new, uniform surface that reflects its surroundings, and how it fades while it ages.
#pragma once

#include <array>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Gain that makes the first photograph of a new, uniform surface even: median / light of each channel, the light
/// smoothed by 1/40 of the shorter side.
/// @param first  H x W x 3, linear. @param mask  Of the same view, at any size; 0 = ignored, with a gain of 1. May be
/// empty. @returns H x W x 3, within [1/50, 50].
/// @throws InvalidInput if most of a channel is black inside the mask, or nothing is inside.
[[nodiscard]] ImageF first_light_gain(const ImageF& first, const ImageU8& mask = {}, const RunControl& control = {});

/// Brightest to darkest light of the channel that is least even, without the 2 % of the picture at either end; >= 1.
/// @param gain  H x W x 3.
[[nodiscard]] double light_ratio(const ImageF& gain);
/// A first photograph below this ratio is even already: 5 % of light are 3 of 255 codes in mid-gray.
inline constexpr double kEvenFirstLight = 1.05;

/// Share of the first photograph's uneven light that a later photograph still shows, per channel, in [0, 1]. Steps of
/// log light over 1/40 of the picture are compared by least absolute deviations, so that stains do not decide it.
/// Where fewer than 200 steps can be compared, the share is 1; where the first photograph is even already, it is 0.
/// @param frame  H x W x 3, linear. @param gain  first_light_gain(), of the same size.
/// @throws InvalidInput if sizes differ.
[[nodiscard]] std::array<double, 3> remaining_first_light(const ImageF& frame, const ImageF& gain);

/// Multiplies by the gain to the power of a share, by channel. @throws InvalidInput if sizes differ.
void apply_first_light_gain(ImageF& image, const ImageF& gain, const std::array<double, 3>& shares);

}  // namespace patinate::capture
