/// \file
/// Where a panel was scratched on purpose.
#pragma once

#include <vector>

#include "analysis/grading/graded_surface.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// The straight lines of even width and contrast, such as a cutter leaves, from the longest on: those at least half as
/// long as it. All are darker than the paint, or all are brighter.
///
/// Lines up to 2 mm wide answer a closing or an opening of the lightness. The longest straight run of these pixels
/// [Matas, Galambos and Kittler 2000, "Robust detection of lines using the progressive probabilistic Hough transform"]
/// gives a direction, which a robust fit improves. A line ends where half of its contrast is lost; its width is the
/// contrast summed across it over its highest contrast, which blur does not change.
/// @param color  H x W x 3, linear: the panel after it was scratched, before it was exposed.
/// @param mask  H x W, 0 = not the panel. Lines within 2 mm of the outside are edges and not looked at.
[[nodiscard]] std::vector<Scribe> find_scribes(const ImageF& color, const ImageU8& mask, double pixel_mm);

}  // namespace patinate::analysis
