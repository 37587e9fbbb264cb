/// \file
/// Photographs whose codes were decoded by the wrong curve.
#pragma once

#include <optional>

#include "patinate/capture/unlight.h"
#include "patinate/image/color.h"

namespace patinate::capture {

/// How far photographs are off that the others predict (leave_one_out(), median), in shares of the values as declared.
struct ResponseCheck {
  double as_declared = 0.0;
  double otherwise = 0.0;  ///< With the other curve.
  bool is_doubtful = false;
};

/// Decodes codes that were taken as linear by the sRGB curve instead, and others as linear instead, fits up to 2,000
/// texels both ways, and doubts the declared response when the other way's error is below 0.6 of its own, and that is
/// above 2 %. Taking sRGB codes for linear costs 23 % of the albedo, though every single photograph looks well.
/// @param ambient  What was subtracted from every photograph, H x W x C; may be empty.
[[nodiscard]] ResponseCheck check_response(const UnlightInput& input, const ImageF& ambient, const Response& declared,
                                           const RunControl& control = {});

}  // namespace patinate::capture
