/// \file
/// How uneven the light lies over the picture, and whether it is the light at all.
#pragma once

#include <vector>

#include "patinate/image/image.h"

namespace patinate::capture {

/// Longer side of the images that find_uneven_light() needs, px.
inline constexpr int kUnevenLightSide = 64;
inline constexpr float kNearBlack = 0.002f, kNearWhite = 0.96f;  ///< Linear; between them pixels tell of the light.
inline constexpr double kLeftOutEnd = 0.02;  ///< Share of the picture at either end that no ratio of light counts.

enum class LightEvidence {
  None,      ///< Even, or the surface's own: it changes with the surface, or has a color of its own.
  Possible,  ///< A slow fall-off that the surface may have as well: nothing tells them apart.
  Clear,     ///< The fall-off stayed where the surface was replaced.
};

struct UnevenLight {
  double ratio = 1.0;  ///< Brightest to darkest, without the 2 % of the picture at either end; >= 1.
  LightEvidence evidence = LightEvidence::None;
  bool is_inside_mask = false;  ///< Judged inside the mask, given or found; else over the whole picture.
};

/// From how much on uneven light is warned of: a quarter, 13 of 255 codes in mid-gray, is seen as a gradient in a
/// transfer that puts patches of both ends side by side.
inline constexpr double kUnevenRatio = 1.25;

/// Fits the polynomial of estimate_flat_field() (degree 4) to the median over time of each pixel's log luminance.
///
/// Whether it is light is judged by the series itself, from the first and the last third of its frames. Where a pixel
/// changed by more than a fifth it is another surface; a quarter of the picture must be, and its detail must not be the
/// old one's (correlation at most 0.5). A quadratic is fitted there to the first and to the last third: what both share
/// (1 - variance of the difference / sum of the variances) is 0.7 or more for light that stayed, and below 0.5 for a
/// slow course of the surface, which went with it. Without such pixels a fall-off is Possible where it stayed, or where
/// it is one of red and blue alike (0.8 by the same measure) and makes up 0.3 of the picture's variance (robustly: what
/// stands out does not count).
/// @param frames  Evenly spread over the series, h x w x 3, linear; all of one size, at most kUnevenLightSide wide and
/// high; one or more. @param mask  0 = ignored, and no part of any share; may be empty.
/// @returns ratio 1 where less than a quarter of what is inside, or less than 60 pixels, can be used. @throws
/// InvalidInput if there is no frame or sizes differ.
[[nodiscard]] UnevenLight find_uneven_light(const std::vector<ImageF>& frames, const ImageU8& mask);

/// Whether a quarter of the picture or more is another surface in the last third of the frames than in the first:
/// changed by a fifth or more there, with other detail than before (correlation at most 0.5).
/// @param frames,mask  As above, two frames or more. @throws InvalidInput likewise.
[[nodiscard]] bool is_surface_replaced(const std::vector<ImageF>& frames, const ImageU8& mask);

}  // namespace patinate::capture
