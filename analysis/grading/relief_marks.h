/// \file
/// Blisters and flakes of a coating, from how its height has changed.
#pragma once

#include <vector>

#include "patinate/image/image.h"

namespace patinate::analysis {

enum class ReliefKind { Blister, Flake };

/// A place that has risen, or whose coating is gone.
struct ReliefMark {
  double area_px = 0.0;
  double uncertain_px = 0.0;  ///< Half the width of the interval of the area.
  double longest_px = 0.0;    ///< Its largest dimension.
};
struct ReliefMarks {
  std::vector<int> labels;  ///< By pixel, -1 = none.
  std::vector<ReliefMark> marks;
};

/// Change of height without what the whole surface has moved and tilted: a plane is fitted to the pixels of the mask,
/// leaving out what lies off by more than 2.5 robust deviations, and taken off.
/// @param before,now  H x W, mm; `before` may be empty. @param mask  0 = not the surface; somewhere not 0.
[[nodiscard]] ImageF height_change(const ImageF& before, const ImageF& now, const ImageU8& mask);

/// Connected pixels that have risen (blisters) or sunk (flakes) by four robust deviations of the noise, and by 10
/// micrometers. The outline of a blister is where a cap of its height and its area at that threshold meets the surface;
/// that of a flake is where half of its depth is lost, with parts of pixels.
/// @param change  height_change(). More than half of the mask must not have changed.
[[nodiscard]] ReliefMarks find_relief_marks(const ImageF& change, const ImageU8& mask, ReliefKind kind);

}  // namespace patinate::analysis
