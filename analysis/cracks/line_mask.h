/// \file
/// Masks of lines that are darker, or brighter, than what surrounds them. Same bits for any number of threads.
#pragma once

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

enum class LineKind { Dark, Bright };

/// Contrast that a closing by a square of 2 reach_px + 1 adds to dark lines narrower than it, or an opening takes from
/// bright ones: lightness by which they differ from what surrounds them, >= 0; 0 outside.
/// @param lightness  H x W, L*. @param mask  H x W, 0 = outside, which has no influence; may be empty.
/// @param reach_px   [1, 100]. @throws InvalidInput if sizes differ or the reach is out of range.
[[nodiscard]] ImageF line_contrast(const ImageF& lightness, const ImageU8& mask, LineKind kind, int reach_px,
                                   const RunControl& control = {});

/// Parts with a contrast of at least `threshold` (> 0), 8-connected, of at least `least_area_px`. 0 / 255.
[[nodiscard]] ImageU8 lines_at(const ImageF& contrast, double threshold, int least_area_px);

/// Settings of find_cracks().
struct CrackFinder {
  int reach_px = 5;           ///< Half the width of the widest crack, [1, 100].
  double least_contrast = 4;  ///< Lightness by which a crack is darker than what surrounds it, L*; > 0.
  int least_area_px = 30;     ///< Smaller dark spots are no cracks.
};
/// Dark lines: what a closing by a square of 2 reach_px + 1 fills by more than Otsu's threshold [Otsu 1979] of all that
/// it fills, or by more than least_contrast if that is more. @param lightness  H x W, L*. @returns 0 / 255.
/// @throws InvalidInput if sizes differ or a setting is out of range.
[[nodiscard]] ImageU8 find_cracks(const ImageF& lightness, const ImageU8& mask, const CrackFinder& settings = {});

}  // namespace patinate::analysis
