/// \file
/// When every texel begins to age, when it is done, and how far it goes.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "analysis/figures/color_stack.h"
#include "patinate/core/run_control.h"

namespace patinate::analysis {

/// The non-decreasing sequence nearest to `values` in the least-squares sense [Ayer et al. 1955: pool adjacent
/// violators].
[[nodiscard]] std::vector<double> monotone_fit(std::span<const double> values);

/// A list of one entry a texel each.
struct TexelAging {
  std::vector<float> change;       ///< Delta E 1976 from the first to the last time, of the monotone fit.
  std::vector<std::uint8_t> ages;  ///< change >= visible: only then the times below mean something.
  std::vector<float> onset;        ///< Time at which a tenth of the change is reached.
  std::vector<float> saturation;   ///< Time at which nine tenths are.
  std::vector<std::uint16_t>
      covered_at;  ///< Index of the first time with a visible change; the number of times if there is none.
};

/// The frames between which a moment lies: what happened between two photographs is known no better.
/// @param frames  Times, ascending; one or more. @returns The same time twice where it is a frame's, or outside of all.
[[nodiscard]] std::pair<double, double> seen_between(double time, const std::vector<double>& frames);

/// The distance from the first color, Delta E 1976, made non-decreasing: noise and flicker then move no time by much.
/// Colors that come back (dust that is wiped off) are not described by it.
/// @param visible_delta_e  > 0. @throws InvalidInput with fewer than two times. Times are interpolated between those of
/// the stack.
[[nodiscard]] TexelAging texel_aging(const ColorStack& stack, double visible_delta_e, const RunControl& control = {});

}  // namespace patinate::analysis
