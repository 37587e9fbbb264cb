// What rules do to a tile, in the dialect of kernel_language.inl and behind rule_types.inl. Included by
// rule_kernel_baseline.cpp, _avx2.cpp and _avx512.cpp inside a namespace of their own; nothing of the standard library,
// whose copies the linker would mix. Own arrays have PATINATE_LANES values.
//
// Loops that clamp stand apart from those that convert to integers: in one, compilers branch on the clamp and do not
// use vectors.

PATINATE_CONSTANT(float, kOne, 16384.0f);  // kAmountOne
PATINATE_CONSTANT(i32, kMaxQuanta, 65535);
PATINATE_CONSTANT(float, kLeast, 1.0f / 32768.0f);  // Below any amount but 0.
PATINATE_CONSTANT(float, kMaxExtent, 1e6f);         // Far beyond what an amount can be.

static inline float amount_of(i32 quanta) { return (float)quanta * (1.0f / kOne); }

// 1 - e^-y for 0 <= y <= 80, relative error < 3e-7. e^-x = 2^-n e^-r with |r| < 0.35, so that little x loses no digits.
static inline float decayed(float y) {
  const i32 n = (i32)(y * 1.44269504f + 0.5f);
  const float whole = (float)n;
  const float r = (y - whole * 0.693145752f) - whole * 1.42860677e-6f;
  float sum = 1.0f - r * (1.0f / 8.0f);
  sum = 1.0f - r * (1.0f / 7.0f) * sum;
  sum = 1.0f - r * (1.0f / 6.0f) * sum;
  sum = 1.0f - r * (1.0f / 5.0f) * sum;
  sum = 1.0f - r * (1.0f / 4.0f) * sum;
  sum = 1.0f - r * (1.0f / 3.0f) * sum;
  sum = 1.0f - r * (1.0f / 2.0f) * sum;
  const float power = PATINATE_AS_FLOAT((127 - n) << 23);
  return (1.0f - power) + power * (r * sum);
}

// 31 random bits of a texel: multiplications and shifts, as hash functions finish.
static inline i32 random31(u32 texel, u32 key0, u32 key1) {
  u32 x = (texel ^ key0) * 0x9E3779B1u;
  x ^= x >> 15;
  x = (x + key1) * 0x85EBCA77u;
  x ^= x >> 13;
  x *= 0xC2B2AE3Du;
  x ^= x >> 16;
  x *= 0x27D4EB2Fu;
  x ^= x >> 15;
  return (i32)(x >> 1);
}

// Changes quanta by extents, rounded to whole quanta, right in the mean. Returns whether any changed.
static inline i32 change_quanta(const bool makes, const float* PATINATE_RESTRICT extent,
                                const i32* PATINATE_RESTRICT random, float share, i32* PATINATE_RESTRICT quanta,
                                float* PATINATE_RESTRICT amounts, i32* PATINATE_RESTRICT changes) {
  PATINATE_ALIGNED float exact[PATINATE_LANES];
  PATINATE_EACH_LANE(l) {
    const float wished = extent[PATINATE_OWN(l)] * share * kOne;
    exact[PATINATE_OWN(l)] = wished < 65536.0f ? wished : 65536.0f;
  }
  i32 any = 0;
  PATINATE_EACH_LANE(l) {
    const i32 whole = (i32)exact[PATINATE_OWN(l)];
    const i32 rest = (i32)((exact[PATINATE_OWN(l)] - (float)whole) * 2147483648.0f);
    const i32 wished = whole + (random[PATINATE_OWN(l)] < rest ? 1 : 0);
    const i32 most = makes ? kMaxQuanta - quanta[PATINATE_OWN(l)] : quanta[PATINATE_OWN(l)];
    const i32 change = wished < most ? wished : most;
    const i32 left = makes ? quanta[PATINATE_OWN(l)] + change : quanta[PATINATE_OWN(l)] - change;
    changes[PATINATE_OWN(l)] = change;
    quanta[PATINATE_OWN(l)] = left;
    amounts[PATINATE_OWN(l)] = amount_of(left);
    any |= change;
  }
  return any;
}

// extent = min(extent, what `full` of it can take of an amount, over share).
static inline void limit_extent(const float* PATINATE_RESTRICT full, const float* PATINATE_RESTRICT amounts,
                                float share, float* PATINATE_RESTRICT extent) {
  const float inverse = 1.0f / share;
  PATINATE_ALIGNED float times[PATINATE_LANES];
  PATINATE_EACH_LANE(l) {
    const float amount = amounts[PATINATE_OWN(l)] > kLeast ? amounts[PATINATE_OWN(l)] : kLeast;
    const float wished = full[PATINATE_OWN(l)] * share / amount;
    times[PATINATE_OWN(l)] = wished < 80.0f ? wished : 80.0f;
  }
  PATINATE_EACH_LANE(l) {
    const float can = amounts[PATINATE_OWN(l)] * decayed(times[PATINATE_OWN(l)]) * inverse;
    extent[PATINATE_OWN(l)] = can < extent[PATINATE_OWN(l)] ? can : extent[PATINATE_OWN(l)];
  }
}

// Of the texels from `first_texel` on: driver; covered, 1 or 0; quanta and amounts by slot, changed; changes by term,
// quanta made or used. Returns bit 0: some texel has an extent; bit 1: something changed (only then are changes set).
static inline i32 apply_rule(PATINATE_GLOBAL const KernelRule* rule, const float* PATINATE_RESTRICT driver,
                             const float* PATINATE_RESTRICT covered, u32 first_texel, i32* quanta, float* amounts,
                             i32* changes) {
  PATINATE_ALIGNED float full[PATINATE_LANES];
  PATINATE_ALIGNED float extent[PATINATE_LANES];
  PATINATE_ALIGNED i32 random[PATINATE_LANES];
  const float scale = rule->scale;
  i32 any = 0;
  PATINATE_EACH_LANE(l) {
    const float wished = driver[PATINATE_OWN(l)] * scale;
    const float low = wished > 0.0f ? wished : 0.0f;
    const float within = (low < kMaxExtent ? low : kMaxExtent) * covered[PATINATE_OWN(l)];
    full[PATINATE_OWN(l)] = within;
    extent[PATINATE_OWN(l)] = within;
  }
  for (i32 k = rule->num_makes; k < rule->num_terms; ++k)
    limit_extent(full, amounts + rule->terms[k].material * PATINATE_LANES, rule->terms[k].share, extent);
  PATINATE_EACH_LANE(l) { any |= extent[PATINATE_OWN(l)] > 0.0f ? 1 : 0; }
  if (any == 0) return 0;
  const u32 key0 = rule->keys[0], key1 = rule->keys[1];
  PATINATE_EACH_LANE(l) { random[PATINATE_OWN(l)] = random31(first_texel + (u32)l, key0, key1); }
  any = 0;
  for (i32 k = 0; k < rule->num_terms; ++k) {
    const i32 at = rule->terms[k].material * PATINATE_LANES;
    const float share = rule->terms[k].share;
    i32* own = changes + k * PATINATE_LANES;
    any |= k < rule->num_makes ? change_quanta(true, extent, random, share, quanta + at, amounts + at, own)
                               : change_quanta(false, extent, random, share, quanta + at, amounts + at, own);
  }
  return any == 0 ? 1 : 3;
}
