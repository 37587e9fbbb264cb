// Random directions, from additions, multiplications and divisions alone, in the dialect of kernel_language.inl and
// behind portable_math.inl and vectors.inl: random_direction.h says what each gives.

// Sine and cosine of `turns` / 2^32 of a full turn, absolute error < 1e-11: several times as fast as
// portable_sine_cosine().
PATINATE_INLINE SineCosine sine_cosine_of_turns(u32 turns) {
  const u32 quarter = (turns + (1u << 29)) >> 30;
  const i32 rest = (i32)(turns - (quarter << 30));
  const double x = rest * (1.5707963267948966 * 0x1.0p-30);  // |x| <= pi / 4
  const double y = x * x;
  const double s =
      x * (1.0 + y * (-1.0 / 6 + y * (1.0 / 120 + y * (-1.0 / 5040 + y * (1.0 / 362880 + y * (-1.0 / 39916800))))));
  const double c =
      1.0 +
      y * (-0.5 + y * (1.0 / 24 + y * (-1.0 / 720 + y * (1.0 / 40320 + y * (-1.0 / 3628800 + y * (1.0 / 479001600))))));
  const u32 which = quarter & 3u;
  SineCosine result;
  result.sine = which == 0u ? s : which == 1u ? c : which == 2u ? -s : -c;
  result.cosine = which == 0u ? c : which == 1u ? -s : which == 2u ? -c : s;
  return result;
}

// ((n + 1/2) / 2^32)^power, relative error < 1e-11. power: [0, 1].
PATINATE_INLINE double power_of_uniform(u32 n, double power) {
  const u64 bits = PATINATE_DOUBLE_BITS((n + 0.5) * 0x1.0p-32);
  i64 exponent = (i64)(bits >> 52) - 1023;
  double m = PATINATE_AS_DOUBLE((bits & 0xFFFFFFFFFFFFFul) | ((u64)1023 << 52));
  if (m > 1.4142135623730951) {
    m *= 0.5;
    ++exponent;
  }
  const double s = (m - 1.0) / (m + 1.0);  // log m = 2 atanh s, |s| < 0.172
  const double s2 = s * s;
  const double log_of =
      (double)exponent * 0.6931471805599453 +
      s * (2.0 + s2 * (2.0 / 3 + s2 * (2.0 / 5 + s2 * (2.0 / 7 + s2 * (2.0 / 9 + s2 * (2.0 / 11 + s2 * (2.0 / 13)))))));
  const double x = power * log_of;  // [-23, 0]
  const i64 k = (i64)(x * 1.4426950408889634 - 0.5);
  const double r = x - (double)k * 0.6931471805599453;  // |r| <= 0.35
  const double e =
      1.0 +
      r * (1.0 + r * (1.0 / 2 +
                      r * (1.0 / 6 +
                           r * (1.0 / 24 +
                                r * (1.0 / 120 +
                                     r * (1.0 / 720 + r * (1.0 / 5040 + r * (1.0 / 40320 + r * (1.0 / 362880)))))))));
  return e * PATINATE_AS_DOUBLE((u64)(k + 1023) << 52);
}

// Two unit vectors that make a right-handed frame with unit w: u x v = w.
typedef struct Across {
  Vector u, v;
} Across;

// Continuous but at w = -z [Duff et al. 2017].
PATINATE_INLINE Across across_of(Vector w) {
  const double sign = PATINATE_DOUBLE_BITS(w.z) >> 63 != 0u ? -1.0 : 1.0;
  const double a = -1.0 / (sign + w.z);
  const double b = w.x * w.y * a;
  Across across;
  across.u = vector_of(1.0 + sign * w.x * w.x * a, sign * b, -sign * w.x);
  across.v = vector_of(b, sign + w.y * w.y * a, -w.y);
  return across;
}

// Unit direction at an angle of the given cosine from unit w, turned by `turns` / 2^32 around it.
PATINATE_INLINE Vector direction_at(Vector w, double cosine, u32 turns) {
  const Across across = across_of(w);
  const SineCosine t = sine_cosine_of_turns(turns);
  const double left = 1.0 - cosine * cosine, sine = PATINATE_SQRT(0.0 < left ? left : 0.0);
  return plus(plus(times(sine * t.cosine, across.u), times(sine * t.sine, across.v)), times(cosine, w));
}

PATINATE_INLINE Vector direction_in_lobe(Vector axis, double exponent, u32 a, u32 b) {
  return direction_at(axis, power_of_uniform(a, 1.0 / (exponent + 1.0)), b);
}

PATINATE_INLINE Vector direction_in_cone(Vector axis, double cosine, u32 a, u32 b) {
  return direction_at(axis, 1.0 - (a + 0.5) * 0x1.0p-32 * (1.0 - cosine), b);
}
