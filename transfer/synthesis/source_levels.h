/// \file
/// The history scaled to the texels that it is laid on: halved until its pixels are as large, its controls as integers.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "patinate/transfer/appearance_space.h"
#include "transfer/synthesis/levels.h"

namespace patinate::transfer {

inline constexpr int kSmallestSide = 12;  ///< Nothing is halved below it.

/// The shorter side of the history; of a library the shortest of any of its histories, so that each is there on every
/// level.
[[nodiscard]] int smallest_side(const History& history);

/// How often the history is halved before its pixels are as large as texels, to a factor of sqrt 2, or as small as it
/// can be.
[[nodiscard]] int source_halvings(double texel_mm, double pixel_mm, int smallest_side);

/// Where a history of pixels of `pixel_mm` comes to lie once it is halved `halvings` times. Neighbors are a whole texel
/// apart, unless texels are much smaller than the history's pixels.
/// @param frames  None: as the UVs run.
[[nodiscard]] SourcePlacement place_source(const TexelMap& map, std::shared_ptr<const FlowFrames> frames,
                                           double pixel_mm, int halvings);

/// C images of H x W in [0, 1] as one of integers. @param controls  At least one, of equal sizes.
[[nodiscard]] ControlImage interleave(std::span<const ImageF> controls, const RunControl& control = {});

/// Mean of the 2 x 2 finer pixels that count. 0 where none does.
[[nodiscard]] ControlImage halve(const ControlImage& fine, int width, int height,
                                 const std::function<bool(int x, int y)>& counts, const RunControl& control = {});

/// Controls of the history at every level of its appearance, finest first.
[[nodiscard]] std::vector<ControlImage> source_control_levels(const AppearanceSpace& appearance,
                                                              std::span<const ImageF> controls,
                                                              const RunControl& control = {});

}  // namespace patinate::transfer
