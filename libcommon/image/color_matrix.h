/// \file
/// 3 x 3 matrices between color spaces, and what a profile of curves and a matrix becomes. Inside of image input, and
/// for colors that are stated for D50.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "libcommon/image/color_encoding.h"

namespace patinate {

using ColorMatrix = std::array<std::array<double, 3>, 3>;
/// Light of a code in [0, 1]; empty where values are light.
using ToneCurve = std::function<double(double)>;
using ToneCurves = std::array<ToneCurve, 3>;

[[nodiscard]] inline std::array<double, 3> product(const ColorMatrix& m, const std::array<double, 3>& v) {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}

[[nodiscard]] inline ColorMatrix product(const ColorMatrix& a, const ColorMatrix& b) {
  ColorMatrix out{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) out[i][k] = a[i][0] * b[0][k] + a[i][1] * b[1][k] + a[i][2] * b[2][k];
  }
  return out;
}

/// @param m  Invertible.
[[nodiscard]] inline ColorMatrix inverse(const ColorMatrix& m) {
  const auto minor = [&](std::size_t i, std::size_t k) {
    const std::size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (k + 1) % 3, d = (k + 2) % 3;
    return m[a][c] * m[b][d] - m[a][d] * m[b][c];
  };
  const double determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
  ColorMatrix out{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) out[k][i] = minor(i, k) / determinant;
  }
  return out;
}

/// Linear Rec. 709 (D65) from XYZ relative to D50, by Bradford's matrix.
[[nodiscard]] ColorMatrix rec709_from_d50();
/// No encoding where it is within rounding what values are anyway.
/// @param rec709  From the light that the curves give.
[[nodiscard]] SaidColor color_of_curves(std::string name, const ToneCurves& curves, const ColorMatrix& rec709);

}  // namespace patinate
