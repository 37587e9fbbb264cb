/// \file
/// A camera's response from an exposure series: which linear value each code stands for.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/image/color.h"
#include "patinate/image/image.h"

namespace patinate::capture {

struct ResponseOptions {
  double smoothness = 1.0;  ///< Weight of the curve's second derivative; > 0.
  int num_pixels = 500;     ///< Pixels that are compared, spread over the picture and its values; [20, 2000].
};
void describe(OptionVisitor& v, ResponseOptions& o);

enum class ResponseStatus {
  Converged,
  Undetermined,  ///< The photographs' codes cover too little of the curve; outside of low_code and high_code it is
                 ///< extended.
};

struct ResponseCurve {
  ResponseStatus status = ResponseStatus::Undetermined;
  std::array<double, 256> linear{};  ///< Linear value of each code; rising, linear[255] = 1.
  int low_code = 0;                  ///< Codes that the photographs show.
  int high_code = 255;
  Response closest;          ///< sRGB, linear or the best gamma.
  double closest_rms = 0.0;  ///< Root mean square of linear - closest over [low_code, high_code], weighted by the hat.
};

/// log exposure of every pixel and log linear of every code by weighted linear least squares [Debevec and Malik 1997];
/// a hat weighs codes near the ends less. Then the nearest of sRGB, linear and a gamma in [0.3, 4].
/// @param photos    Two or more of the same scene and camera, codes of 8 bit, same size and channels (the channels'
/// curves are taken as one).
/// @param exposures Relative; > 0; not all equal.
/// @throws InvalidInput when sizes differ, exposures do not fit, or no pixel changes between photographs (all black,
/// all white).
[[nodiscard]] ResponseCurve recover_response(const std::vector<ImageU8>& photos, const std::vector<double>& exposures,
                                             const ResponseOptions& options = {});

}  // namespace patinate::capture
