/// \file
/// exp, log, pow, sine and cosine from additions, multiplications and divisions alone: the same bits for every
/// instruction set and C library, as libm's are not (tested on x86-64). For whatever decides in a simulation. Compiled
/// with -ffp-contract=off (cmake/PatinateFlags.cmake). Argument reduction after [Cody and Waite 1980], series by
/// Horner's rule. Checked against libm over the whole range.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace patinate {

namespace portable_detail {
inline constexpr double kLn2High = 0x1.62e42feep-1;  ///< 32 bits of ln 2: multiples up to 2^20 are exact.
inline constexpr double kLn2Low = 0x1.a39ef35793c76p-33;
}  // namespace portable_detail

/// e^x, relative error < 1e-15; 0 below -708, infinity above 709. @param x  Not NaN.
[[nodiscard]] inline double portable_exp(double x) {
  if (x < -708.0) return 0.0;
  if (x > 709.0) return std::numeric_limits<double>::infinity();
  const double shifted = x * 1.4426950408889634 + (x < 0 ? -0.5 : 0.5);
  const auto n = static_cast<std::int64_t>(shifted);
  const double r =
      (x - static_cast<double>(n) * portable_detail::kLn2High) - static_cast<double>(n) * portable_detail::kLn2Low;
  double sum = 1.0;
  for (int k = 13; k > 0; --k) sum = 1.0 + r * sum / k;
  return sum * std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52);
}

/// 1 - e^-x for x >= 0, without cancellation where x is small; relative error < 1e-14. What part of a quantity has gone
/// after x time constants.
[[nodiscard]] inline double portable_decayed(double x) {
  if (x > 0.25) return 1.0 - portable_exp(-x);
  double sum = 1.0;
  for (int k = 12; k > 1; --k) sum = 1.0 - x * sum / k;
  return x * sum;
}

/// Natural logarithm, absolute error < 1e-15 (1 + |log x|). @param x  > 0 and normal.
[[nodiscard]] inline double portable_log(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  auto exponent = static_cast<std::int64_t>(bits >> 52) - 1023;
  double m = std::bit_cast<double>((bits & 0xFFFFFFFFFFFFFull) | (std::uint64_t{1023} << 52));
  if (m > 1.4142135623730951) {
    m *= 0.5;
    ++exponent;
  }
  const double s = (m - 1.0) / (m + 1.0);  // log m = 2 atanh s, |s| < 0.172
  const double s2 = s * s;
  double sum = 0.0;
  for (int k = 21; k > 0; k -= 2) sum = 1.0 / k + s2 * sum;
  const auto e = static_cast<double>(exponent);
  return e * portable_detail::kLn2High + (2.0 * s * sum + e * portable_detail::kLn2Low);
}

/// x^y; 1 for y = 0, 0 for x = 0 < y. @param x  >= 0, not subnormal.
[[nodiscard]] inline double portable_pow(double x, double y) {
  if (y == 0.0) return 1.0;
  if (!(x > 0.0)) return 0.0;
  return portable_exp(y * portable_log(x));
}

struct SineCosine {
  double sine = 0.0;
  double cosine = 1.0;
};

/// Sine and cosine of 2 pi `turns`, absolute error < 1e-15; exact at quarter turns. @param turns  |turns| < 2^50.
[[nodiscard]] inline SineCosine portable_sine_cosine(double turns) {
  const double quarters = turns * 4.0;
  const auto q = static_cast<std::int64_t>(quarters + (quarters < 0 ? -0.5 : 0.5));
  const double x = (quarters - static_cast<double>(q)) * 1.5707963267948966;  // |x| <= pi / 4
  const double x2 = x * x;
  double s = 1.0;
  double c = 1.0;
  for (int k = 16; k > 0; k -= 2) {
    s = 1.0 - x2 * s / (k * (k + 1));
    c = 1.0 - x2 * c / (k * (k - 1));
  }
  s *= x;
  switch (q & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace patinate
