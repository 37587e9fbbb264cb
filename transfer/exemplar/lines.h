/// \file
/// Lines of a picture, such as cracks, veins and rims.
#pragma once

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

/// Thresholds of what a square fills, L*: of all lines, and of those that contrast most.
struct LineThresholds {
  double low = 0.0, high = 0.0;
};

/// Lines, dark or bright.
struct Lines {
  ImageF fill;          ///< H x W: how much darker (or brighter) than its surroundings a pixel is, as far as that
                        ///< goes on along a line; L*, >= 0.
  ImageU8 all, strong;  ///< H x W, 0 / 255; empty where there are none.
  LineThresholds thresholds;
  bool is_dark = true;
  double share = 0.0;          ///< Share of the pixels inside the mask.
  double refused_share = 0.0;  ///< Where there are none: what long pieces would cover, if that is too much for
                               ///< lines and at most 35 %.
  [[nodiscard]] bool empty() const { return all.empty(); }
};

/// Lines that a closing (dark) or an opening (bright) of the lightness by a square fills, at the smallest of four sizes
/// that finds most: counted as far as it goes on along the best of twelve segments of 17 px (at the smallest size;
/// longer at the others), above Otsu's threshold [Otsu 1979], and above 0.4 of it or the noise where connected with
/// that. There are lines where most of what is found is much longer than wide, and it covers at most an eighth of the
/// surface, or a quarter where it stands out from the noise. Same bits for any number of threads.
/// @param lightness  H x W, L*. @param mask  H x W, 0 = outside.
[[nodiscard]] Lines find_lines(const ImageF& lightness, const ImageU8& mask, const RunControl& control = {});

}  // namespace patinate::transfer
