/// \file
/// How much of the picture an ingest's masks take away, as a warning of the history.
#pragma once

#include <vector>

#include "patinate/history/history_value.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Share of the pixels from where on a mask is warned of: what is left may not stand for the surface.
inline constexpr double kMuchMasked = 0.2;

/// Share of `given` that `result` lacks: saturated, in a highlight or out of view. 0 when nothing is given.
/// @param given  H x W, 0 = outside from the start; empty = all inside. @param result  Likewise, of the history.
[[nodiscard]] double outside_share(const ImageU8& given, const ImageU8& result);

/// One warning where kMuchMasked or more is outside, of a single photograph as well.
/// @param num_frames  Of the history; >= 1.
[[nodiscard]] std::vector<HistoryWarning> mask_warnings(const ImageU8& given, const ImageU8& result, int num_frames);

}  // namespace patinate::capture
