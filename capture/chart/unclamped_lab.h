/// \file
/// CIELAB of colors that Rec. 709 does not hold, also for automatic derivatives. Inside of the chart only.
#pragma once

#include <array>
#include <cmath>

namespace patinate::capture {

/// Works as lab_from_linear(), but keeps negative values: the inverse of linear_from_lab().
template <class T>
[[nodiscard]] std::array<T, 3> unclamped_lab(const std::array<T, 3>& linear) {
  using std::cbrt;
  constexpr double kXyz[3][3] = {
      {0.4124564, 0.3575761, 0.1804375}, {0.2126729, 0.7151522, 0.0721750}, {0.0193339, 0.1191920, 0.9503041}};
  std::array<T, 3> f{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double white = kXyz[i][0] + kXyz[i][1] + kXyz[i][2];
    const T t = (kXyz[i][0] * linear[0] + kXyz[i][1] * linear[1] + kXyz[i][2] * linear[2]) / white;
    f[i] = t > T(216.0 / 24389.0) ? T(cbrt(t)) : T((24389.0 / 27.0 * t + 16.0) / 116.0);
  }
  return {116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])};
}

}  // namespace patinate::capture
