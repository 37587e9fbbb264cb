// Four floats at once, in the dialect of kernel_language.inl: vectors of SSE2 or OpenCL where there are some; the plain
// loops give the same bits.

#if defined(__OPENCL_VERSION__)
typedef float4 Lanes;
static inline Lanes lanes_of(float x) { return (float4)(x); }
static inline Lanes load_lanes(PATINATE_GLOBAL const float* x) { return vload4(0, x); }
static inline void store_lanes(Lanes a, float* x) { vstore4(a, 0, x); }
static inline Lanes lanes_add(Lanes a, Lanes b) { return a + b; }
static inline Lanes lanes_sub(Lanes a, Lanes b) { return a - b; }
static inline Lanes lanes_mul(Lanes a, Lanes b) { return a * b; }
static inline Lanes lanes_least(Lanes a, Lanes b) { return select(b, a, a < b); }
static inline Lanes lanes_most(Lanes a, Lanes b) { return select(b, a, a > b); }
static inline Lanes lanes_magnitude(Lanes a) { return as_float4(as_int4(a) & 0x7FFFFFFF); }
static inline u32 which_not_above(Lanes a, Lanes b) {
  const int4 is = a <= b;
  return (u32)((is.x & 1) | (is.y & 2) | (is.z & 4) | (is.w & 8));
}
#elif defined(__SSE2__)
typedef __m128 Lanes;
static inline Lanes lanes_of(float x) { return _mm_set1_ps(x); }
static inline Lanes load_lanes(const float* x) { return _mm_load_ps(x); }
static inline void store_lanes(Lanes a, float* x) { _mm_store_ps(x, a); }
static inline Lanes lanes_add(Lanes a, Lanes b) { return _mm_add_ps(a, b); }
static inline Lanes lanes_sub(Lanes a, Lanes b) { return _mm_sub_ps(a, b); }
static inline Lanes lanes_mul(Lanes a, Lanes b) { return _mm_mul_ps(a, b); }
static inline Lanes lanes_least(Lanes a, Lanes b) { return _mm_min_ps(a, b); }
static inline Lanes lanes_most(Lanes a, Lanes b) { return _mm_max_ps(a, b); }
static inline Lanes lanes_magnitude(Lanes a) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), a); }
static inline u32 which_not_above(Lanes a, Lanes b) { return (u32)_mm_movemask_ps(_mm_cmple_ps(a, b)); }
#else
typedef struct Lanes {
  float x[4];
} Lanes;
#define PATINATE_LANES_ARE(name, value)           \
  static inline Lanes name(Lanes a, Lanes b) {    \
    Lanes out;                                    \
    for (i32 k = 0; k < 4; ++k) out.x[k] = value; \
    return out;                                   \
  }
PATINATE_LANES_ARE(lanes_add, a.x[k] + b.x[k])
PATINATE_LANES_ARE(lanes_sub, a.x[k] - b.x[k])
PATINATE_LANES_ARE(lanes_mul, a.x[k] * b.x[k])
PATINATE_LANES_ARE(lanes_least, a.x[k] < b.x[k] ? a.x[k] : b.x[k])
PATINATE_LANES_ARE(lanes_most, a.x[k] > b.x[k] ? a.x[k] : b.x[k])
#undef PATINATE_LANES_ARE
static inline Lanes load_lanes(const float* x) {
  Lanes out;
  for (i32 k = 0; k < 4; ++k) out.x[k] = x[k];
  return out;
}
static inline Lanes lanes_of(float x) {
  const float all[4] = {x, x, x, x};
  return load_lanes(all);
}
static inline void store_lanes(Lanes a, float* x) {
  for (i32 k = 0; k < 4; ++k) x[k] = a.x[k];
}
static inline Lanes lanes_magnitude(Lanes a) {
  for (i32 k = 0; k < 4; ++k) a.x[k] = PATINATE_AS_FLOAT(PATINATE_FLOAT_BITS(a.x[k]) & 0x7FFFFFFFu);
  return a;
}
static inline u32 which_not_above(Lanes a, Lanes b) {
  u32 which = 0u;
  for (i32 k = 0; k < 4; ++k) which |= a.x[k] <= b.x[k] ? 1u << k : 0u;
  return which;
}
#endif
