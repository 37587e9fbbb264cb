// Composition of a tile, in the dialect of kernel_language.inl and behind compose_types.inl. Included by
// compose_kernel_baseline.cpp, _avx2.cpp and _avx512.cpp inside a namespace of their own; nothing of the standard
// library, whose copies the linker would mix. Own arrays have PATINATE_LANES values.

static inline u32 at_most(u32 a, u32 b) { return a < b ? a : b; }
static inline i32 within(i32 x, i32 low, i32 high) {
  const i32 y = x < low ? low : x;
  return y > high ? high : y;
}

static inline void fill_noise(u32 first_texel, u32 key, i32* xi) {
  PATINATE_EACH_LANE(l) { xi[PATINATE_OWN(l)] = noise(first_texel + (u32)l, key); }
}

static inline void fill_grain(PATINATE_GLOBAL const u8* grain, i32* xi) {
  PATINATE_EACH_LANE(l) { xi[PATINATE_OWN(l)] = grain_noise(grain[l]); }
}

// 1 + v xi, 1 = 32768; [0, 65535].
static inline u32 varied(i32 variation, i32 xi) { return (u32)(32768 + ((variation * xi + 16384) >> 15)); }

// How far along each ramp of colors a texel is, 1 = 16384.
static inline void fill_ramps(PATINATE_GLOBAL const QuantizedAppearance* look, PATINATE_GLOBAL const u16* amount,
                              PATINATE_GLOBAL const u16* original, const i32* xi, i32 ramp[3][PATINATE_LANES]) {
  PATINATE_ALIGNED i32 whole[PATINATE_LANES];
  const i32 variation = look->variation;
  PATINATE_EACH_LANE(l) {
    const i32 delta = (i32)amount[l] - (i32)original[l];
    whole[PATINATE_OWN(l)] = delta > 0 ? delta : 0;
  }
  if (variation != 0) {
    PATINATE_EACH_LANE(l) {
      const u32 f = ((u32)whole[PATINATE_OWN(l)] * varied(variation, xi[PATINATE_OWN(l)]) + 16384u) >> 15;
      whole[PATINATE_OWN(l)] = (i32)at_most(f, 65535u);
    }
  }
  for (i32 r = 0; r < look->num_ramps; ++r) {
    const i32 start = look->ramp_start[r], width = look->ramp_width[r], scale = look->ramp_scale[r];
    PATINATE_EACH_LANE(l) {
      ramp[r][PATINATE_OWN(l)] = (within(whole[PATINATE_OWN(l)] - start, 0, width) * scale + 32768) >> 16;
    }
  }
}

static inline u32 varied_weight(u32 weight, i32 variation, i32 xi) {
  return at_most((weight * varied(variation, xi) + 16384u) >> 15, kMaxWeight);
}

// total: of weights; in the printed form of what they are where the amount is 1.
static inline void add_weights(const bool varies, const bool is_printed_form,
                               PATINATE_GLOBAL const QuantizedAppearance* look, PATINATE_GLOBAL const u16* amount,
                               PATINATE_GLOBAL const u16* original, const i32* xi, u16* weight, u32* total) {
  const u32 strength = look->strength, limit = look->limit, at_one = at_most(strength, kMaxWeight);
  const i32 variation = look->variation;
  PATINATE_EACH_LANE(l) {
    const i32 delta = (i32)amount[l] - (i32)original[l];
    const u32 more = (u32)(delta > 0 ? delta : 0);
    u32 w = (at_most(more, limit) * strength + 8192u) >> 14;
    w = more > limit ? kMaxWeight : w;
    u32 cover = more > 0u ? at_one : 0u;
    if (varies) w = varied_weight(w, variation, xi[PATINATE_OWN(l)]);
    if (varies && is_printed_form) cover = varied_weight(cover, variation, xi[PATINATE_OWN(l)]);
    weight[PATINATE_OWN(l)] = (u16)w;
    total[PATINATE_OWN(l)] += is_printed_form ? cover : w;
  }
}

// sum += delta (1 + v xi) factor >> shift, each within +-kMaxHeight.
static inline void add_scaled(const bool varies, i32 factor, i32 shift, i32 variation,
                              PATINATE_GLOBAL const u16* amount, PATINATE_GLOBAL const u16* original, const i32* xi,
                              i32* sum) {
  const i32 half_quantum = shift > 0 ? 1 << (shift - 1) : 0;
  PATINATE_EACH_LANE(l) {
    i32 delta = (i32)amount[l] - (i32)original[l];
    if (varies) delta = (delta * (i32)(varied(variation, xi[PATINATE_OWN(l)]) >> 2) + 4096) >> 13;
    sum[PATINATE_OWN(l)] += within((delta * factor + half_quantum) >> shift, -kMaxHeight, kMaxHeight);
  }
}

static inline void add_any(i32 factor, i32 shift, i32 variation, PATINATE_GLOBAL const u16* amount,
                           PATINATE_GLOBAL const u16* original, const i32* xi, i32* sum) {
  if (variation != 0) {
    add_scaled(true, factor, shift, variation, amount, original, xi, sum);
  } else {
    add_scaled(false, factor, shift, variation, amount, original, xi, sum);
  }
}

// What weights are multiplied by (1 = 65536): total weight a <= 1: 1, or a in the other forms; a > 1: (2^30 + a / 2)
// / a, or 1 in the printed form. The quotient by floats is off by at most 1, and then put right.
static inline void fill_scale(const u32* total, i32 form, u32* scale) {
  PATINATE_EACH_LANE(l) {
    const i32 over = (i32)(total[PATINATE_OWN(l)] > kOne ? total[PATINATE_OWN(l)] : kOne);
    const i32 q = (i32)(1073741824.0f / (float)over);
    const i32 twice = 2 * (1073741824 - q * over);
    scale[PATINATE_OWN(l)] = (u32)(q + (twice >= over ? 1 : 0) - (twice < -over ? 1 : 0));
  }
  if (form == kNormalizedForm) return;
  PATINATE_EACH_LANE(l) {
    const u32 a = total[PATINATE_OWN(l)], covered = form == kPrintedForm ? 65536u : scale[PATINATE_OWN(l)];
    scale[PATINATE_OWN(l)] = a > kOne ? covered : a * 4u;
  }
}

static inline void scale_weights(const u32* scale, u16* weight) {
  PATINATE_EACH_LANE(l) {
    weight[PATINATE_OWN(l)] = (u16)((weight[PATINATE_OWN(l)] * scale[PATINATE_OWN(l)] + 32768u) >> 16);
  }
}

// Of one channel: from `first` along the ramps of colors.
static inline void fill_by_amount(i32 first, PATINATE_GLOBAL const u16* ends, i32 num_ramps,
                                  const i32 ramp[3][PATINATE_LANES], i32* own) {
  PATINATE_EACH_LANE(l) { own[PATINATE_OWN(l)] = first; }
  i32 begin = first;
  for (i32 r = 0; r < num_ramps; ++r) {
    const i32 end = ends[3 * r], change = end - begin;
    PATINATE_EACH_LANE(l) { own[PATINATE_OWN(l)] += (change * ramp[r][PATINATE_OWN(l)]) >> 14; }
    begin = end;
  }
}

// The same for a material whose color follows its amount.
static inline void add_color_by_amount(PATINATE_GLOBAL const QuantizedAppearance* look, i32 channel, const u16* weight,
                                       const i32* xi, const i32 ramp[3][PATINATE_LANES], const bool has_two, u32* sum) {
  PATINATE_ALIGNED i32 own[PATINATE_LANES];
  fill_by_amount(look->color[channel], &look->ramp_color[channel], look->num_ramps, ramp, own);
  if (has_two) {
    PATINATE_ALIGNED i32 second[PATINATE_LANES];
    fill_by_amount(look->second_color[channel], &look->ramp_second[channel], look->num_ramps, ramp, second);
    PATINATE_EACH_LANE(l) {
      const i32 change = second[PATINATE_OWN(l)] - own[PATINATE_OWN(l)];
      own[PATINATE_OWN(l)] += (change * ((xi[PATINATE_OWN(l)] + 32768) >> 2)) >> 14;
    }
  }
  PATINATE_EACH_LANE(l) { sum[PATINATE_OWN(l)] += (u32)weight[PATINATE_OWN(l)] * (u32)own[PATINATE_OWN(l)]; }
}

// Adds a material's share of one channel.
static inline void add_color(const ComposeTask* task, i32 k, i32 channel, const u16* weight, const i32* xi,
                             const i32 ramp[3][PATINATE_LANES], u32* sum) {
  PATINATE_GLOBAL const QuantizedAppearance* look = task->look[k];
  const i32 color = look->color[channel];
  if (task->picture[k] != 0) {
    PATINATE_GLOBAL const u16* picture = task->picture[k] + channel * kTile;
    PATINATE_EACH_LANE(l) { sum[PATINATE_OWN(l)] += (u32)weight[PATINATE_OWN(l)] * picture[l]; }
  } else if (look->num_ramps != 0) {
    add_color_by_amount(look, channel, weight, xi, ramp, look->has_second_color != 0u && task->grain[k] != 0, sum);
  } else if (look->has_second_color != 0u && task->grain[k] != 0) {
    // Products below 2^31: 15 bits of xi.
    const i32 change = (i32)look->second_color[channel] - color;
    PATINATE_EACH_LANE(l) {
      const i32 own = color + ((change * ((xi[PATINATE_OWN(l)] + 32768) >> 2)) >> 14);
      sum[PATINATE_OWN(l)] += (u32)weight[PATINATE_OWN(l)] * (u32)own;
    }
  } else {
    PATINATE_EACH_LANE(l) { sum[PATINATE_OWN(l)] += (u32)weight[PATINATE_OWN(l)] * (u32)color; }
  }
}

// The same where weights may sum to more than 1: the sum ends at 1.
static inline void add_up_to_one(const ComposeTask* task, i32 k, i32 channel, const u16* weight, const i32* xi,
                                 const i32 ramp[3][PATINATE_LANES], u32* sum) {
  const u32 one = 1u << 30;
  PATINATE_ALIGNED u32 part[PATINATE_LANES];
  PATINATE_EACH_LANE(l) { part[PATINATE_OWN(l)] = 0u; }
  add_color(task, k, channel, weight, xi, ramp, part);
  PATINATE_EACH_LANE(l) {
    sum[PATINATE_OWN(l)] = at_most(sum[PATINATE_OWN(l)] + at_most(part[PATINATE_OWN(l)], one), one);
  }
}

static inline void blend(const ComposeTask* task, u16 weight[8][PATINATE_LANES], i32 xi[8][PATINATE_LANES],
                         i32 ramp[8][3][PATINATE_LANES], const u32* total, i32 channel, u16* index) {
  PATINATE_ALIGNED u32 sum[PATINATE_LANES];
  PATINATE_EACH_LANE(l) {
    sum[PATINATE_OWN(l)] = (kOne - at_most(total[PATINATE_OWN(l)], kOne)) * task->base->linear[channel][l] + 8192u;
  }
  for (i32 k = 0; k < task->num_materials; ++k) {
    if (task->look[k]->strength == 0u) continue;
    if (task->form == kPrintedForm) {
      add_up_to_one(task, k, channel, weight[k], xi[k], ramp[k], sum);
    } else {
      add_color(task, k, channel, weight[k], xi[k], ramp[k], sum);
    }
  }
  PATINATE_EACH_LANE(l) { index[PATINATE_OWN(l)] = (u16)(at_most(sum[PATINATE_OWN(l)] >> 14, 65535u) >> kSrgbShift); }
}

// What a material adds to weights, specular values and heights.
static inline void add_material(const ComposeTask* task, i32 k, i32* xi, u16* weight, u32* total, i32* specular,
                                i32* height) {
  PATINATE_GLOBAL const QuantizedAppearance* look = task->look[k];
  PATINATE_GLOBAL const u16* amount = task->amount[k];
  PATINATE_GLOBAL const u16* original = task->original[k];
  if (task->grain[k] != 0) {
    fill_grain(task->grain[k], xi);
  } else if ((look->variation | look->specular_variation | look->height_variation) != 0) {
    fill_noise(task->first_texel, look->noise_key, xi);
  }
  const bool is_printed = task->form == kPrintedForm, varies = look->variation != 0;
  if (look->strength != 0u && !is_printed && varies)
    add_weights(true, false, look, amount, original, xi, weight, total);
  if (look->strength != 0u && !is_printed && !varies)
    add_weights(false, false, look, amount, original, xi, weight, total);
  if (look->strength != 0u && is_printed && varies) add_weights(true, true, look, amount, original, xi, weight, total);
  if (look->strength != 0u && is_printed && !varies)
    add_weights(false, true, look, amount, original, xi, weight, total);
  if (look->specular != 0) add_any(look->specular, 13, look->specular_variation, amount, original, xi, specular);
  if (look->height != 0)
    add_any(look->height, look->height_shift, look->height_variation, amount, original, xi, height);
}

static inline void pack_colors(const ComposeTask* task, u16 index[3][PATINATE_LANES], const i32* specular, u32* rgba) {
  PATINATE_ALIGNED u32 top[PATINATE_LANES];
  PATINATE_EACH_LANE(l) {
    top[PATINATE_OWN(l)] = (u32)((within(specular[PATINATE_OWN(l)], 0, (i32)kOne) * 255 + 8192) >> 14) << 24;
  }
  PATINATE_GLOBAL const u8* srgb = task->srgb;
  PATINATE_EACH_LANE(l) {
    rgba[PATINATE_OWN(l)] = top[PATINATE_OWN(l)] | (u32)srgb[index[0][PATINATE_OWN(l)]] |
                            (u32)srgb[index[1][PATINATE_OWN(l)]] << 8 | (u32)srgb[index[2][PATINATE_OWN(l)]] << 16;
  }
}

// rgba: R | G << 8 | B << 16 | specular << 24; height: quanta. Both own.
static inline void compose_lanes(const ComposeTask* task, u32* rgba, i32* height) {
  PATINATE_ALIGNED u16 weight[8][PATINATE_LANES];
  PATINATE_ALIGNED i32 xi[8][PATINATE_LANES];
  PATINATE_ALIGNED i32 ramp[8][3][PATINATE_LANES];
  PATINATE_ALIGNED u32 total[PATINATE_LANES];
  PATINATE_ALIGNED i32 specular[PATINATE_LANES];
  PATINATE_EACH_LANE(l) {
    total[PATINATE_OWN(l)] = 0u;
    specular[PATINATE_OWN(l)] = task->base->specular[l];
    height[PATINATE_OWN(l)] = task->height[l];
  }
  for (i32 k = 0; k < task->num_materials; ++k) {
    add_material(task, k, xi[k], weight[k], total, specular, height);
    if (task->look[k]->num_ramps != 0) fill_ramps(task->look[k], task->amount[k], task->original[k], xi[k], ramp[k]);
  }
  PATINATE_EACH_LANE(l) { height[PATINATE_OWN(l)] = within(height[PATINATE_OWN(l)], -kMaxHeight, kMaxHeight); }
  PATINATE_ALIGNED u32 scale[PATINATE_LANES];
  fill_scale(total, task->form, scale);
  for (i32 k = 0; k < task->num_materials; ++k) {
    if (task->look[k]->strength != 0u) scale_weights(scale, weight[k]);
  }
  PATINATE_ALIGNED u16 index[3][PATINATE_LANES];
  for (i32 c = 0; c < 3; ++c) blend(task, weight, xi, ramp, total, c, index[c]);
  pack_colors(task, index, specular, rgba);
}

// Of a texel, from its frame: across = right - left, down = below - above.
static inline void slopes_of_steps(const Frame frame, i32 across, i32 down, i32* along_t, i32* along_b) {
  const i32 shift = frame.shift, half_quantum = 1 << (shift - 1);
  *along_t = within((across * frame.t + half_quantum) >> shift, -kMaxSlope, kMaxSlope);
  *along_b = within((across * frame.bt - down * frame.b + half_quantum) >> shift, -kMaxSlope, kMaxSlope);
}

// weights: along T or B of its four neighbors.
static inline i32 slope_at_border(PATINATE_GLOBAL const BorderTexel* texel, PATINATE_GLOBAL const i32* weights,
                                  PATINATE_GLOBAL const i32* heights) {
  const i64 half_quantum = 2048;
  i64 sum = half_quantum;
  for (i32 k = 0; k < 4; ++k) {
    const i32 step = within(heights[texel->neighbor[k]] - heights[texel->texel], -kMaxStep, kMaxStep);
    sum += (i64)step * weights[k];
  }
  const i64 slope = sum >> 12, most = kMaxSlope;
  return (i32)(slope < -most ? -most : slope > most ? most : slope);
}

// Normals as 127.5 + 127.5 n, rounded, from slopes (own) to 3 x 64 bytes.
static inline void encode_lanes(const i32* along_t, const i32* along_b, PATINATE_GLOBAL u8* normal) {
  PATINATE_EACH_LANE(l) {
    const i32 x = -along_t[PATINATE_OWN(l)], y = -along_b[PATINATE_OWN(l)];
    const i32 squared = x * x + y * y + kSlopeOne * kSlopeOne;
    // floor(sqrt(squared)): a float's is off by at most 1.
    i32 length = (i32)PATINATE_SQRTF((float)squared);
    length = length * length > squared ? length - 1 : length;
    length = (length + 1) * (length + 1) <= squared ? length + 1 : length;
    // Numerators are below 2^24 and denominators below 2^16, so that floats divide like integers.
    const float twice = (float)(2 * length);
    normal[l] = (u8)(i32)((float)(255 * (length + x) + length) / twice);
    normal[kTile + l] = (u8)(i32)((float)(255 * (length + y) + length) / twice);
    normal[2 * kTile + l] = (u8)(i32)((float)(255 * (length + kSlopeOne) + length) / twice);
  }
}
