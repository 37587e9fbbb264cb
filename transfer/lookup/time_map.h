/// \file
/// Lookups with a time of its own at every texel: an object of which one side is older.
#pragma once

#include "libcommon/history/history_sampling.h"
#include "libcommon/image/image.h"

namespace patinate {

/// The history's colour at every texel's own time.
///
/// Frames are visited once, in order, and two are in memory at a time: memory does not grow with the number of frames. With one
/// time everywhere the result equals gather() of sample() to the bit.
/// @param coordinates  H x W x 2, whole numbers inside the history's frames, or -1.
/// @param times        H x W x 1, in the history's unit, clamped to its ends; not looked at where coordinates are -1.
/// @returns H x W x 3, linear; 0 where coordinates are -1.
/// @throws InvalidInput if sizes differ or a time is NaN; IoError of the history.
/// Cost: each frame that any texel needs is read once.
[[nodiscard]] ImageF gather_at_times(const HistoryReader& history, const ImageF& coordinates, const ImageF& times, Between between,
                                     const RunControl& control = {});

}  // namespace patinate
