// Included by compose_kernel_baseline.cpp, _avx2.cpp and _avx512.cpp inside a namespace of their own. Plain loops over
// 64 texels that compilers turn into vector code; nothing of the standard library, whose copies the linker would mix.

using u8 = std::uint8_t;
using u16 = std::uint16_t;
using u32 = std::uint32_t;
using i32 = std::int32_t;

namespace {

inline u32 at_most(u32 a, u32 b) { return a < b ? a : b; }
inline i32 within(i32 x, i32 low, i32 high) {
  const i32 y = x < low ? low : x;
  return y > high ? high : y;
}

void fill_noise(u32 first_texel, u32 key, i32* xi) {
  const u32 first = first_texel * 0x9E3779B1u;
  for (u32 l = 0; l < kTile; ++l) {
    u32 x = (first + l * 0x9E3779B1u) ^ key;
    x ^= x >> 16;
    x *= 0x7FEB352Du;
    x ^= x >> 15;
    x *= 0x846CA68Bu;
    xi[l] = static_cast<i32>(x) >> 16;
  }
}

// 1 + v xi, 1 = 32768; [0, 65535].
inline u32 varied(i32 variation, i32 xi) { return static_cast<u32>(32768 + ((variation * xi + 16384) >> 15)); }

template <bool kVaries>
void add_weights(const QuantizedAppearance& look, const u16* amount, const u16* original, const i32* xi, u16* weight,
                 u32* total) {
  const u32 strength = look.strength, limit = look.limit;
  const i32 variation = look.variation;
  for (int l = 0; l < kTile; ++l) {
    const i32 delta = static_cast<i32>(amount[l]) - static_cast<i32>(original[l]);
    const u32 more = static_cast<u32>(delta > 0 ? delta : 0);
    u32 w = (at_most(more, limit) * strength + 8192) >> 14;
    w = more > limit ? kMaxWeight : w;
    if (kVaries) w = at_most((w * varied(variation, xi[l]) + 16384) >> 15, kMaxWeight);
    weight[l] = static_cast<u16>(w);
    total[l] += w;
  }
}

// sum += delta (1 + v xi) factor >> shift, each within +-kMaxHeight.
template <bool kVaries>
void add_scaled(i32 factor, i32 shift, i32 variation, const u16* amount, const u16* original, const i32* xi, i32* sum) {
  const i32 half = shift > 0 ? 1 << (shift - 1) : 0;
  for (int l = 0; l < kTile; ++l) {
    i32 delta = static_cast<i32>(amount[l]) - static_cast<i32>(original[l]);
    if (kVaries) delta = (delta * static_cast<i32>(varied(variation, xi[l]) >> 2) + 4096) >> 13;
    sum[l] += within((delta * factor + half) >> shift, -kMaxHeight, kMaxHeight);
  }
}

void add_any(bool varies, i32 factor, i32 shift, i32 variation, const u16* amount, const u16* original, const i32* xi,
             i32* sum) {
  if (varies) {
    add_scaled<true>(factor, shift, variation, amount, original, xi, sum);
  } else {
    add_scaled<false>(factor, shift, variation, amount, original, xi, sum);
  }
}

// What weights are multiplied by (1 = 65536): total weight a <= 1: 1, or a in the published form; a > 1: (2^30 + a / 2)
// / a. The quotient by floats is off by at most 1, and then put right.
void fill_scale(const u32* total, bool is_published_form, u32* scale) {
  for (int l = 0; l < kTile; ++l) {
    const i32 over = static_cast<i32>(total[l] > kOne ? total[l] : kOne);
    const i32 q = static_cast<i32>(1073741824.0f / static_cast<float>(over));
    const i32 twice = 2 * (1073741824 - q * over);
    scale[l] = static_cast<u32>(q + (twice >= over ? 1 : 0) - (twice < -over ? 1 : 0));
  }
  if (!is_published_form) return;
  for (int l = 0; l < kTile; ++l) scale[l] = total[l] > kOne ? scale[l] : total[l] * 4;
}

void scale_weights(const u32* scale, u16* weight) {
  for (int l = 0; l < kTile; ++l) weight[l] = static_cast<u16>((weight[l] * scale[l] + 32768) >> 16);
}

void blend(const ComposeTask& task, const u16 (*weight)[kTile], const u32* total, int channel, u16* index) {
  alignas(64) u32 sum[kTile];
  for (int l = 0; l < kTile; ++l) sum[l] = (kOne - at_most(total[l], kOne)) * task.base->linear[channel][l] + 8192;
  for (int k = 0; k < task.num_materials; ++k) {
    const u16* w = weight[k];
    if (task.look[static_cast<unsigned>(k)]->strength == 0) continue;
    if (const u16* picture = task.picture[static_cast<unsigned>(k)]; picture != nullptr) {
      const u16* color = picture + channel * kTile;
      for (int l = 0; l < kTile; ++l) sum[l] += static_cast<u32>(w[l]) * color[l];
    } else {
      const u32 color = task.look[static_cast<unsigned>(k)]->color[static_cast<unsigned>(channel)];
      for (int l = 0; l < kTile; ++l) sum[l] += w[l] * color;
    }
  }
  for (int l = 0; l < kTile; ++l) index[l] = static_cast<u16>(at_most(sum[l] >> 14, 65535u) >> kSrgbShift);
}

void compose_tile(const ComposeTask& task, u32* rgba, i32* height) {
  alignas(64) u16 weight[8][kTile];
  alignas(64) u32 total[kTile];
  alignas(64) i32 specular[kTile];
  alignas(64) i32 white[kTile];
  for (int l = 0; l < kTile; ++l) {
    total[l] = 0;
    specular[l] = task.base->specular[l];
    height[l] = task.height[l];
  }
  for (unsigned k = 0; k < static_cast<unsigned>(task.num_materials); ++k) {
    const QuantizedAppearance& look = *task.look[k];
    const u16* amount = task.amount[k];
    const u16* original = task.original[k];
    const i32* xi = task.xi[k];
    if (xi == nullptr && (look.variation | look.specular_variation | look.height_variation) != 0) {
      fill_noise(task.first_texel, look.noise_key, white);
      xi = white;
    }
    if (look.strength != 0 && look.variation != 0) add_weights<true>(look, amount, original, xi, weight[k], total);
    if (look.strength != 0 && look.variation == 0) add_weights<false>(look, amount, original, xi, weight[k], total);
    if (look.specular != 0)
      add_any(look.specular_variation != 0, look.specular, 13, look.specular_variation, amount, original, xi, specular);
    if (look.height != 0)
      add_any(look.height_variation != 0, look.height, look.height_shift, look.height_variation, amount, original, xi,
              height);
  }
  for (int l = 0; l < kTile; ++l) height[l] = within(height[l], -kMaxHeight, kMaxHeight);
  alignas(64) u32 scale[kTile];
  fill_scale(total, task.is_published_form, scale);
  for (unsigned k = 0; k < static_cast<unsigned>(task.num_materials); ++k) {
    if (task.look[k]->strength != 0) scale_weights(scale, weight[k]);
  }
  alignas(64) u16 index[3][kTile];
  for (int c = 0; c < 3; ++c) blend(task, weight, total, c, index[c]);
  alignas(64) u32 top[kTile];
  for (int l = 0; l < kTile; ++l)
    top[l] = static_cast<u32>((within(specular[l], 0, static_cast<i32>(kOne)) * 255 + 8192) >> 14) << 24;
  const u8* srgb = task.srgb;
  const auto pack = [&](int l) {
    rgba[l] = top[l] | static_cast<u32>(srgb[index[0][l]]) | static_cast<u32>(srgb[index[1][l]]) << 8 |
              static_cast<u32>(srgb[index[2][l]]) << 16;
  };
  for (int l = 0; l < kTile; l += 4) {
    pack(l);
    pack(l + 1);
    pack(l + 2);
    pack(l + 3);
  }
}

void fill_slopes(const NormalTask& task, SlopeTile& out) {
  alignas(64) i32 across[kTile];
  alignas(64) i32 down[kTile];
  // Rows are 8 long: the first and last of each are put right after.
  const i32* here = task.here;
  across[0] = across[kTile - 1] = 0;
  for (int l = 1; l < kTile - 1; ++l) across[l] = within(here[l + 1] - here[l - 1], -kMaxStep, kMaxStep);
  for (int l = 0; l < kTile; l += 8) {
    across[l] = within(here[l + 1] - task.left[l + 7], -kMaxStep, kMaxStep);
    across[l + 7] = within(task.right[l] - here[l + 6], -kMaxStep, kMaxStep);
  }
  for (int l = 0; l < 8; ++l) down[l] = within(here[l + 8] - task.above[l + 56], -kMaxStep, kMaxStep);
  for (int l = 8; l < 56; ++l) down[l] = within(here[l + 8] - here[l - 8], -kMaxStep, kMaxStep);
  for (int l = 56; l < kTile; ++l) down[l] = within(task.below[l - 56] - here[l - 8], -kMaxStep, kMaxStep);
  // Frames by pairs of 32 bits, each two of 16: t, bt; b, shift.
  alignas(64) i32 frame[2 * kTile];
  for (int l = 0; l < kTile; ++l) __builtin_memcpy(frame + 2 * l, task.frame + task.triangle[l] + 1, sizeof(Frame));
  for (int l = 0; l < kTile; ++l) {
    const i32 t = frame[2 * l] << 16 >> 16, bt = frame[2 * l] >> 16;
    const i32 b = frame[2 * l + 1] << 16 >> 16, shift = frame[2 * l + 1] >> 16;
    const i32 half = 1 << (shift - 1);
    out.along_t[l] = within((across[l] * t + half) >> shift, -kMaxSlope, kMaxSlope);
    out.along_b[l] = within((across[l] * bt - down[l] * b + half) >> shift, -kMaxSlope, kMaxSlope);
  }
}

void encode_normals(const SlopeTile& slopes, u8* normal) {
  for (int l = 0; l < kTile; ++l) {
    const i32 x = -slopes.along_t[l];
    const i32 y = -slopes.along_b[l];
    const i32 squared = x * x + y * y + kSlopeOne * kSlopeOne;
    // floor(sqrt(squared)): a float's is off by at most 1.
    i32 length = static_cast<i32>(__builtin_sqrtf(static_cast<float>(squared)));
    length = length * length > squared ? length - 1 : length;
    length = (length + 1) * (length + 1) <= squared ? length + 1 : length;
    // Numerators are below 2^24 and denominators below 2^16, so that floats divide like integers.
    const float twice = static_cast<float>(2 * length);
    normal[l] = static_cast<u8>(static_cast<i32>(static_cast<float>(255 * (length + x) + length) / twice));
    normal[kTile + l] = static_cast<u8>(static_cast<i32>(static_cast<float>(255 * (length + y) + length) / twice));
    normal[2 * kTile + l] =
        static_cast<u8>(static_cast<i32>(static_cast<float>(255 * (length + kSlopeOne) + length) / twice));
  }
}

bool replace_words(u32* __restrict to, const u32* __restrict from, int num_words) {
  u32 difference = 0;
  for (int l = 0; l < (num_words & ~15); ++l) {
    difference |= to[l] ^ from[l];
    to[l] = from[l];
  }
  return difference != 0;
}

}  // namespace

extern const Kernels kKernels;
const Kernels kKernels{compose_tile, fill_slopes, encode_normals, replace_words};
