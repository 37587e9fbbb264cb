/// \file
/// Photographs whose codes were decoded by the wrong curve.
#pragma once

#include <optional>

#include "capture/unlighting/unlight.h"
#include "libcommon/image/color.h"

namespace patinate {

/// How far photographs and lamps disagree: root mean square of the residuals of plain least squares, over the mean.
struct ResponseCheck {
  double as_declared = 0.0;
  double otherwise = 0.0;  ///< With the other curve.
  bool is_doubtful = false;
};

/// Decodes codes that were taken as linear by the sRGB curve instead, and others as linear instead, fits up to 5,000 texels both ways, and doubts the declared
/// response when the other way's residual is below 0.6 of its own. Taking sRGB codes for linear costs 23 % of the albedo, without a word from any photograph alone.
/// @param ambient  What was subtracted from every photograph, H x W x C; may be empty.
[[nodiscard]] ResponseCheck check_response(const UnlightInput& input, const ImageF& ambient, const Response& declared, const RunControl& control = {});

}  // namespace patinate
