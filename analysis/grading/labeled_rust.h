/// \file
/// What rust looks like on one panel, from a photograph on which somebody marked it.
#pragma once

#include "analysis/grading/grade_rules.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// The rule with the color of the marked pixels: hue, chroma, lightness and change from the unexposed surface within
/// the middle 96 % of the marked pixels whose eight neighbors are marked, too, and a little beyond. Where more than
/// half of them are gray (white rust, chalk), hue and chroma say nothing.
/// @param before  H x W x 3, linear: the unexposed surface; empty: the photograph of the marks alone is known.
/// @param marked  H x W x 3, linear: the photograph. @param labels  H x W, not 0 = corroded; somewhere, and not
/// everywhere. @throws InvalidInput unless the labels have the size of the photograph and 20 inner pixels.
[[nodiscard]] RustRule labeled_rust_rule(RustRule rule, const ImageF& before, const ImageF& marked,
                                         const ImageU8& labels);

}  // namespace patinate::analysis
