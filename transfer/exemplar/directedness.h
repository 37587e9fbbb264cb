/// \file
/// Whether a history looks the same however it is turned.
#pragma once

#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

/// Nets of cracks have 0.1 to 0.3 (drawn and photographed), straight streaks, grain and bricks 0.6 and more.
inline constexpr double kDirected = 0.4;

/// How much a picture prefers one direction, or two that cross at right angles: of the directions of its gradients,
/// weighted by their squares, the length of the mean at double or at fourfold angle, whichever is longer [Bigun and
/// Granlund 1987]. What varies over 1 to 8 pixels counts. 0: none; 1: straight parallel lines, or a grid.
/// @param lightness  H x W. @param mask  0 = outside; may be empty.
[[nodiscard]] double directedness(const ImageF& lightness, const ImageU8& mask, const RunControl& control = {});
/// Directedness of a history's last frame; of a library, the most of its histories. @param mask  Of the history's size.
[[nodiscard]] double directedness(const History& history, const ImageU8& mask, const RunControl& control = {});

}  // namespace patinate::transfer
