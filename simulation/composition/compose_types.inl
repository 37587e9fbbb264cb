// What composition works with, as C++ and devices have it (kernel_language.inl).

PATINATE_CONSTANT(i32, kTile, 64);            // Texels.
PATINATE_CONSTANT(u32, kOne, 16384);          // Amounts, weights and specular values: 1.
PATINATE_CONSTANT(u32, kMaxWeight, 65535);    // A weight saturates here, just under 4.
PATINATE_CONSTANT(i32, kMaxHeight, 1 << 27);  // Height quanta.
PATINATE_CONSTANT(i32, kMaxStep, 32767);      // Height differences over two texels saturate here: 32 texels.
PATINATE_CONSTANT(i32, kSlopeOne, 1024);
PATINATE_CONSTANT(i32, kMaxSlope, 16 * 1024);  // In 1 / kSlopeOne: 86.4 degrees.
PATINATE_CONSTANT(i32, kNormalizedForm, 0);    // ColorForm.
PATINATE_CONSTANT(i32, kPublishedForm, 1);
PATINATE_CONSTANT(i32, kPrintedForm, 2);
PATINATE_CONSTANT(i32, kSrgbShift, 3);  // Linear values of 16 bit, shifted by this, index a table of sRGB codes.

// A MaterialAppearance as integers. What changes with the amount is F = amount difference * (1 + variation * xi), in
// quanta of 1 / kOne.
typedef struct QuantizedAppearance {
  PATINATE_MEMBER(u32, strength, 0);   // 1 = kOne.
  PATINATE_MEMBER(u32, limit, 65535);  // Amount differences above it weigh kMaxWeight.
  PATINATE_MEMBER(i32, variation, 0);  // 1 = 32768.
  PATINATE_MEMBER(i32, specular, 0);   // 1 = 8192.
  PATINATE_MEMBER(i32, specular_variation, 0);
  PATINATE_MEMBER(i32, height, 0);        // F * height >> height_shift are height quanta; |height| <= 8192.
  PATINATE_MEMBER(i32, height_shift, 0);  // [0, 30].
  PATINATE_MEMBER(i32, height_variation, 0);
  PATINATE_ARRAY(u16, color, 3);         // Linear, 1 = 65535.
  PATINATE_ARRAY(u16, second_color, 3);  // At xi = 1; `color` at -1.
  PATINATE_MEMBER(u32, has_second_color, 0);
  // Colors by amount: from `color` on, each ramp goes to the next; from F = start to start + width.
  PATINATE_MEMBER(i32, num_ramps, 0);
  PATINATE_ARRAY(i32, ramp_start, 3);
  PATINATE_ARRAY(i32, ramp_width, 3);   // [1, 65535].
  PATINATE_ARRAY(i32, ramp_scale, 3);   // 2^30 / width, rounded.
  PATINATE_ARRAY(u16, ramp_color, 9);   // By ramp, then channel: at its end,
  PATINATE_ARRAY(u16, ramp_second, 9);  // and there at xi = 1.
  PATINATE_MEMBER(u32, noise_key, 0);
} QuantizedAppearance;

// What texels look like when they are new.
typedef struct BaseTile {
  PATINATE_ALIGNED u16 linear[3][64];  // 1 = 65535.
  PATINATE_ALIGNED i32 specular[64];   // 1 = kOne.
  PATINATE_ALIGNED u32 code[64];  // R | G << 8 | B << 16 | specular << 24: exactly what is shown where nothing changed.
} BaseTile;

// A tile in which some amounts differ from the originals.
typedef struct ComposeTask {
  PATINATE_MEMBER(i32, num_materials, 0);  // Of those that differ.
  PATINATE_ARRAY(PATINATE_GLOBAL const QuantizedAppearance*, look, 8);
  PATINATE_ARRAY(PATINATE_GLOBAL const u16*, amount, 8);  // 64 each.
  PATINATE_ARRAY(PATINATE_GLOBAL const u16*, original, 8);
  PATINATE_ARRAY(PATINATE_GLOBAL const u8*, grain, 8);  // 64 values in place of noise; may be null.
  PATINATE_ARRAY(PATINATE_GLOBAL const u16*, picture,
                 8);  // 3 x 64 linear values in place of the look's color; may be null.
  PATINATE_MEMBER(PATINATE_GLOBAL const BaseTile*, base, 0);
  PATINATE_MEMBER(PATINATE_GLOBAL const i32*, height, 0);  // Height quanta when new.
  PATINATE_MEMBER(PATINATE_GLOBAL const u8*, srgb, 0);     // kSrgbSize codes.
  PATINATE_MEMBER(u32, first_texel, 0);
  PATINATE_MEMBER(i32, form, 0);
} ComposeTask;

// What turns height differences of a triangle's texels into slopes along its tangents T (+u) and B (+v, orthogonal to
// T): along T (right - left) * t >> shift; along B ((right - left) * bt - (below - above) * b) >> shift; rounded, 1 =
// kSlopeOne.
typedef struct Frame {
  PATINATE_MEMBER(i16, t, 0);  // |.| < 2^14, as the other two.
  PATINATE_MEMBER(i16, bt, 0);
  PATINATE_MEMBER(i16, b, 0);
  PATINATE_MEMBER(i16, shift, 1);  // [1, 30].
} Frame;

// Normals of a tile from heights.
typedef struct NormalTask {
  PATINATE_MEMBER(PATINATE_GLOBAL const i32*, here, 0);  // 64 height quanta.
  // Of the tiles beside; `here` where there is none (their texels are on a border, and redone).
  PATINATE_MEMBER(PATINATE_GLOBAL const i32*, right, 0);
  PATINATE_MEMBER(PATINATE_GLOBAL const i32*, left, 0);
  PATINATE_MEMBER(PATINATE_GLOBAL const i32*, below, 0);
  PATINATE_MEMBER(PATINATE_GLOBAL const i32*, above, 0);
  PATINATE_MEMBER(PATINATE_GLOBAL const i32*, triangle, 0);  // 64; -1 = none.
  PATINATE_MEMBER(PATINATE_GLOBAL const Frame*, frame, 0);   // By triangle + 1.
} NormalTask;

// How texels on a border find their slopes: from the differences to their four neighbors, each at its real place: its
// direction in the tangent plane, its distance through space. Exact where height is linear.
typedef struct BorderTexel {
  PATINATE_MEMBER(u32, texel, 0);
  PATINATE_ARRAY(u32, neighbor, 4);  // Itself where the surface ends.
  PATINATE_ARRAY(i32, along_t, 4);   // Slope (1 = kSlopeOne) by height quantum, 1 = 4096.
  PATINATE_ARRAY(i32, along_b, 4);
} BorderTexel;

// What a device knows of a tile.
typedef struct TileFacts {
  PATINATE_MEMBER(u32, is_covered, 0);
  PATINATE_MEMBER(i32, originals, 0);     // Planes of 64 amounts: that of the first material, the others behind it.
  PATINATE_MEMBER(i32, base, 0);          // Among BaseTiles,
  PATINATE_MEMBER(i32, height, 0);        // and planes of 64 height quanta.
  PATINATE_ARRAY(u32, beside, 4);         // Tiles: right, left, below, above.
  PATINATE_MEMBER(u32, border_begin, 0);  // Of its border texels.
  PATINATE_MEMBER(u32, border_end, 0);
  PATINATE_MEMBER(u32, dependents_begin, 0);  // Of other tiles whose slopes use its heights.
  PATINATE_MEMBER(u32, dependents_end, 0);
} TileFacts;

typedef struct ComposeCall {
  PATINATE_MEMBER(u32, number, 0);  // Of this call, from 1.
  PATINATE_MEMBER(u32, num_materials, 0);
  PATINATE_MEMBER(u32, num_texels, 0);
  PATINATE_MEMBER(u32, has_heights, 0);
  PATINATE_MEMBER(i32, form, 0);
  PATINATE_ARRAY(i32, grain_layer, 8);  // By material; -1 = none.
  PATINATE_ARRAY(i32, picture_layer, 8);
} ComposeCall;

// xi of a texel and material, 1 = 32768: uniform in [-32768, 32767].
static inline i32 noise(u32 texel, u32 key) {
  u32 x = texel * 0x9E3779B1u ^ key;
  x ^= x >> 16;
  x *= 0x7FEB352Du;
  x ^= x >> 15;
  x *= 0x846CA68Bu;
  return (i32)x >> 16;
}

// xi of a texel with grain `value` (127.5 in the mean, standard deviation 51), 1 = 32768: mean 0, of the same standard
// deviation as noise().
static inline i32 grain_noise(u8 value) {
  const i32 spread = 371;  // 32768 / sqrt 3 over 51.
  const i32 xi = (2 * (i32)value - 255) * spread / 2;
  return xi < -32768 ? -32768 : xi > 32767 ? 32767 : xi;
}
