// exp, log, pow, sine and cosine from additions, multiplications and divisions alone (portable_math.h), in the dialect
// of kernel_language.inl.

typedef struct SineCosine {
  PATINATE_MEMBER(double, sine, 0.0);
  PATINATE_MEMBER(double, cosine, 1.0);
} SineCosine;

PATINATE_CONSTANT(double, kLn2High, 0x1.62e42feep-1);  // 32 bits of ln 2: multiples up to 2^20 are exact.
PATINATE_CONSTANT(double, kLn2Low, 0x1.a39ef35793c76p-33);

// e^x, relative error < 1e-15; 0 below -708, infinity above 709. x is not NaN.
PATINATE_INLINE double portable_exp(double x) {
  if (x < -708.0) return 0.0;
  if (x > 709.0) return PATINATE_AS_DOUBLE(0x7FF0000000000000ul);
  const double shifted = x * 1.4426950408889634 + (x < 0 ? -0.5 : 0.5);
  const i64 n = (i64)shifted;
  const double r = (x - (double)n * kLn2High) - (double)n * kLn2Low;
  double sum = 1.0;
  for (int k = 13; k > 0; --k) sum = 1.0 + r * sum / k;
  return sum * PATINATE_AS_DOUBLE((u64)(n + 1023) << 52);
}

// 1 - e^-x for x >= 0, without cancellation where x is small; relative error < 1e-14. What part of a quantity has gone
// after x time constants.
PATINATE_INLINE double portable_decayed(double x) {
  if (x > 0.25) return 1.0 - portable_exp(-x);
  double sum = 1.0;
  for (int k = 12; k > 1; --k) sum = 1.0 - x * sum / k;
  return x * sum;
}

// Natural logarithm, absolute error < 1e-15 (1 + |log x|). x > 0 and normal.
PATINATE_INLINE double portable_log(double x) {
  const u64 bits = PATINATE_DOUBLE_BITS(x);
  i64 exponent = (i64)(bits >> 52) - 1023;
  double m = PATINATE_AS_DOUBLE((bits & 0xFFFFFFFFFFFFFul) | ((u64)1023 << 52));
  if (m > 1.4142135623730951) {
    m *= 0.5;
    ++exponent;
  }
  const double s = (m - 1.0) / (m + 1.0);  // log m = 2 atanh s, |s| < 0.172
  const double s2 = s * s;
  double sum = 0.0;
  for (int k = 21; k > 0; k -= 2) sum = 1.0 / k + s2 * sum;
  const double e = (double)exponent;
  return e * kLn2High + (2.0 * s * sum + e * kLn2Low);
}

// x^y; 1 for y = 0, 0 for x = 0 < y. x >= 0, not subnormal.
PATINATE_INLINE double portable_pow(double x, double y) {
  if (y == 0.0) return 1.0;
  if (!(x > 0.0)) return 0.0;
  return portable_exp(y * portable_log(x));
}

// Of 2 pi `turns`, absolute error < 1e-15; exact at quarter turns. |turns| < 2^50.
PATINATE_INLINE SineCosine portable_sine_cosine(double turns) {
  const double quarters = turns * 4.0;
  const i64 q = (i64)(quarters + (quarters < 0 ? -0.5 : 0.5));
  const double x = (quarters - (double)q) * 1.5707963267948966;  // |x| <= pi / 4
  const double x2 = x * x;
  double s = 1.0;
  double c = 1.0;
  for (int k = 16; k > 0; k -= 2) {
    s = 1.0 - x2 * s / (k * (k + 1));
    c = 1.0 - x2 * c / (k * (k - 1));
  }
  s *= x;
  const i64 quarter = q & 3;
  SineCosine result;
  result.sine = quarter == 0 ? s : quarter == 1 ? c : quarter == 2 ? -s : -c;
  result.cosine = quarter == 0 ? c : quarter == 1 ? -s : quarter == 2 ? -c : s;
  return result;
}
