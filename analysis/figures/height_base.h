/// \file
/// The base that heights of one history are counted from, which those of another do not share.
#pragma once

#include <cstdint>
#include <vector>

#include "analysis/figures/color_stack.h"

namespace patinate::analysis {

/// Arbitrary part of heights.
enum class HeightBase {
  Mean,  ///< Where zero is.
  Plane  ///< And how the surface lay: its tilt, as levelling takes it out [ISO 25178-2, F-operation].
};

/// Plane for a captured history that is looked at as it was photographed. Heights of a simulation, or of a history on
/// an atlas, stand on a mesh, whose texels lie on no plane: Mean.
[[nodiscard]] HeightBase height_base_of(const TextureSeries& series);

/// Base that take_base() removed.
struct TakenBase {
  HeightBase kind = HeightBase::Mean;
  double mean_mm = 0.0;  ///< Mean of the first time.
  double tilt_mm = 0.0;  ///< How much higher the plane's highest texel lies than its lowest.
};

/// Subtracts the base of the first time, by least squares over its texels, from the heights of all times, so that a
/// history's own course over time stays.
/// @param height  mm, times x stack.num_texels(); may be empty.
TakenBase take_base(std::vector<float>& height, const ColorStack& stack, HeightBase kind);

}  // namespace patinate::analysis
