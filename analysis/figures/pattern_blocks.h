/// \file
/// How large blocks of a surface must be to be independent of each other.
#pragma once

#include <optional>

#include "analysis/figures/color_stack.h"

namespace patinate::analysis {

/// Size of the features of what has changed between the first and the last time (of the colors themselves where there
/// is one time), in the channel that varies most: the longer of the 1/e lengths of its correlation as it is, and in
/// means over 4 x 4 pixels, which show no grain. Pixels.
/// @returns nothing when nothing varies; a third of the shorter side when it is coarser than can be seen.
[[nodiscard]] std::optional<double> feature_px(const ColorStack& stack);

/// Blocks per side of at least four features, [3, 8]: coarser patterns leave none that could be told from each other,
/// finer ones need no more.
[[nodiscard]] int pattern_blocks(const ColorStack& stack);

}  // namespace patinate::analysis
