// What every kernel stands on: products, sums, quotients and roots of floats and doubles, and whole numbers of 64 bit.

enum { kResultsOfItem = 6 };

// Any but NaN and infinity; numbers too small for a full mantissa among them. Every other one is of the size of 1.
static inline float float_from(u32 random) {
  const u32 exponent = (random >> 23) & 0xFFu;
  const u32 bits = (random & 1u) != 0u ? (random & 0x80FFFFFFu) | 0x3F000000u
                   : exponent == 0xFFu ? random & 0xBFFFFFFFu
                                       : random;
  return PATINATE_AS_FLOAT(bits);
}
static inline double double_from(u32 high, u32 low) {
  u64 bits = (u64)high << 32 | low;
  if ((low & 1u) != 0u) bits = (bits & 0x801FFFFFFFFFFFFFul) | 0x3FE0000000000000ul;
  if (((bits >> 52) & 0x7FFu) == 0x7FFu) bits &= 0xBFFFFFFFFFFFFFFFul;
  return PATINATE_AS_DOUBLE(bits);
}

// NaNs have many forms: they count as one.
static inline u32 float_result(float x) { return x == x ? PATINATE_FLOAT_BITS(x) : 0x7FC00000u; }
static inline u64 double_result(double x) { return x == x ? PATINATE_DOUBLE_BITS(x) : 0x7FF8000000000000ul; }

static inline void check_item(u32 item, PATINATE_GLOBAL u64* results) {
  RandomState random = random_state(0x5EEDul, item, 1u);
  const float a = float_from(random_next(&random)), b = float_from(random_next(&random)),
              c = float_from(random_next(&random));
  const u32 h0 = random_next(&random), l0 = random_next(&random), h1 = random_next(&random), l1 = random_next(&random);
  const double d = double_from(h0, l0), e = double_from(h1, l1);
  PATINATE_GLOBAL u64* out = results + (u64)item * kResultsOfItem;
  out[0] = (u64)float_result(a * b + c) << 32 | float_result(a / b);
  const float positive = a < 0.0f ? -a : a;
  out[1] = (u64)float_result(PATINATE_SQRTF(positive)) << 32 | float_result((a - b) * (b - c) + (c - a) / b);
  out[2] = double_result(d * e + d);
  out[3] = double_result(d / e);
  out[4] = double_result(PATINATE_SQRT(d < 0.0 ? -d : d));
  // Shifts of negative numbers, high halves of products.
  const i64 p = (i64)(((u64)h0 << 32 | l0) ^ ((u64)l1 << 20)), q = (i64)((u64)h1 << 32 | l1);
  out[5] = (u64)(p >> (h1 & 31u)) * 31u + (u64)(q / ((i64)(l0 >> 8) + 1)) + random_below(&random, 1u + (h0 >> 4));
}

#ifdef __OPENCL_VERSION__
kernel void check_arithmetic(global ulong* results) { check_item((uint)get_global_id(0), results); }
#endif
