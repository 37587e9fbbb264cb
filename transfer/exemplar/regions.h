/// \file
/// Regions of a source: patches of one material among another, such as rust on paint or lichen on stone, whose borders
/// a copy must not break.
#pragma once

#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

/// Best division of a picture into two materials.
struct Regions {
  ImageU8 is_second;  ///< H x W, 0 / 255; empty where there are none.
  ImageF value;       ///< H x W: smoothed colors along the axis on which they vary most, about 100 from black to white.
  double threshold = 0.0;   ///< Between the two, of `value`.
  double contrast = 0.0;    ///< Between their means.
  double share = 0.0;       ///< Share of the rarer one.
  double width_px = 0.0;    ///< Width of its patches: twice its area over its border.
  double separation = 0.0;  ///< Share of the variance that the two means explain, [0, 1].
};

/// Two classes by Otsu's threshold [Otsu 1979] on colors averaged over 3, 5 or 9 pixels, the smallest that separates
/// them: their means explain four fifths of the variance (0.64 of a normal, 0.75 of a uniform distribution), both cover
/// at least a twentieth, patches are wider than a neighborhood sees, and their borders are sharp. Same bits for any
/// number of threads.
/// @param colors  H x W x 3, linear. @param mask  0 = outside.
[[nodiscard]] Regions find_regions(const ImageF& colors, const ImageU8& mask, const RunControl& control = {});

}  // namespace patinate::transfer
