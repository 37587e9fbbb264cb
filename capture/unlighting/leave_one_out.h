/// \file
/// How well the other photographs predict each one: the check of an unlighting that needs no truth.
#pragma once

#include <vector>

#include "patinate/capture/unlight.h"

namespace patinate::capture {

struct LeaveOneOutError {
  double rms =
      0.0;  ///< Root mean square of prediction minus photograph over samples that counted as clean, over their mean.
  double median = 0.0;  ///< Median of |prediction - photograph| / prediction over all lit samples, rejected ones too.
  std::int64_t num_samples = 0;  ///< Number of samples of the median.
};

/// For each lamp, fits texels (up to 20,000 spread over the surface) without its sample, and renders that sample from
/// the fit: albedo, normal, strengths, ambient and highlights as found. The highlights' lobes were fitted with all
/// lamps.
/// @param result  Of unlight() with the same input and options. Same bits for any number of threads.
[[nodiscard]] std::vector<LeaveOneOutError> leave_one_out(const UnlightInput& input, const UnlightOptions& options,
                                                          const UnlightResult& result, const RunControl& control = {});

}  // namespace patinate::capture
