/// \file
/// Least squares of a lamp and its reflection over windows of a series. Inside of stability only.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "capture/stability/static_light.h"

namespace patinate::capture {

/// Mean light of a window in one frame and channel.
struct WindowSeries {
  std::vector<PicturePoint> places;         ///< Places of the windows.
  std::vector<std::vector<double>> values;  ///< Per frame and channel one per window, > 0; NaN where not known.
};

/// One whole fit.
struct LightFit {
  LampLight lamp{{}, 0.0};
  LampReflection reflection{{}, 0.0, 0.0};
  double variance = 0.0;  ///< Mean square of the windows' logarithms from the fit.
};

struct FitParts {
  bool lamp = false, reflection = false;
};
/// @param series  Some value known in every frame and channel.
[[nodiscard]] LightFit fit_light(const WindowSeries& series, const FitParts& parts);

}  // namespace patinate::capture
