/// \file
/// Removing changes of exposure from photograph to photograph without removing the material's own brightening and
/// darkening.
#pragma once

#include <array>
#include <vector>

#include "patinate/core/options.h"

namespace patinate::capture {

struct DeflickerOptions {
  int half_width =
      8;  ///< [1, 1000]. Frames on either side: brightness that changes over more than so many is the material's.
};
void describe(OptionVisitor& v, DeflickerOptions& o);

/// Factors per frame and channel that take flicker out.
///
/// The gains between neighbors add up to a curve of log brightness; a robust local line through it (tricube weights
/// over half_width frames on either side, Tukey weights against outliers [Cleveland 1979, "lowess"]) is the material's
/// own course, and the factor brings each frame onto it. A steady trend is a line and stays untouched, also at the
/// ends; a step becomes a ramp of the window's width.
/// A series no longer than the window is too short for its mean to be robust: the line starts as the one of median
/// slopes [Siegel 1982]. Of three photographs or two no course can be told: changes of more than 5 % are brought to the
/// middle one, or to the first, and smaller ones stay.
/// @param log_gains  log_gains[i] = natural logarithm of frame i + 1 / frame i, per channel; finite.
/// @param is_known  Per gain, whether it is the light's (LightChange::is_sure()); empty = all are. Frames on either
/// side of one that is not are two series: nothing is known of the one's exposure against the other's.
/// @returns log_gains.size() + 1 factors. @throws InvalidInput if an option is out of range or sizes differ.
[[nodiscard]] std::vector<std::array<double, 3>> deflicker_factors(const std::vector<std::array<double, 3>>& log_gains,
                                                                   const DeflickerOptions& options = {},
                                                                   const std::vector<bool>& is_known = {});

}  // namespace patinate::capture
