/// \file
/// Windows of a made texture, laid flat on the surface across seams, and windows of the source of the same shape.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "analysis/evaluation/source_lines.h"
#include "analysis/evaluation/synthesized_map.h"

namespace patinate::analysis {

inline constexpr int kWindowSide = 113;  ///< Texels. Cells of cracks close within it; few windows meet themselves.
inline constexpr int kNumWindows =
    100;  ///< Number of windows of a whole map, about: two draws differ by a tenth in dead ends.

/// Texels or pixels by the value of a control, in 64 bins of equal width over [0, 1].
using ControlCounts = std::array<std::int64_t, 64>;
[[nodiscard]] std::size_t control_bin(float value);

/// Source that windows are cut from.
struct WindowSource {
  const ImageF& lightness;        ///< L* of the source's own pixels.
  const ImageU8& mask;            ///< 0 = outside; may be empty.
  const ImageF& control;          ///< May be empty.
  double pixels_per_texel = 1.0;  ///< Windows of the source are sampled as far apart.
};

/// The i-th of `source` has the shape of the i-th of `made`.
struct SurfaceWindows {
  std::vector<Ground> made, source;
  ControlCounts made_control = {}, source_control = {};  ///< In every eighth row and column; 0 without controls.
};

/// Windows around texels drawn evenly over the surface, each at a random turn. They are laid from the middle outward,
/// from point to point over the surface, so that seams and turned charts make no difference; values between texels are
/// bilinear in their chart. Each window of the source lies at a random place and turn, of several the one whose control
/// is on average nearest to what the made one asks for. Same bits for any number of threads.
/// @param lightness  L* of the part's rectangle. @param before,all  In earlier parts, and in all.
[[nodiscard]] SurfaceWindows cut_windows(const MapPart& part, const ImageF& lightness, const WindowSource& source,
                                         const PartCounts& before, const PartCounts& all,
                                         const RunControl& control = {});

}  // namespace patinate::analysis
