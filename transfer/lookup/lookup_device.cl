// The entries of lookups. Indices of texels that show nothing are kNone.

#define kNone 0xFFFFFFFFu

// A source's pixels are bits of 1, 2, 4, 8 or 16 bytes, whatever they stand for; three numbers a pixel are padded to
// four, so that one load finds them. An item takes four texels: one load of indices, four of pixels, whole words
// written.
#define kTexelsOfItem 4

static inline uchar pixel_1(global const uchar* source, uint index) {
  return index == kNone ? (uchar)0 : source[index];
}
static inline ushort pixel_2(global const ushort* source, uint index) {
  return index == kNone ? (ushort)0 : source[index];
}
static inline uint pixel_4(global const uint* source, uint index) { return index == kNone ? 0u : source[index]; }
static inline uint2 pixel_8(global const uint2* source, uint index) {
  return index == kNone ? (uint2)(0) : source[index];
}
static inline uint4 pixel_16(global const uint4* source, uint index) {
  return index == kNone ? (uint4)(0) : source[index];
}

// Those of an item at the end that has fewer texels.
#define PATINATE_REST(work)                                                          \
  for (ulong texel = kTexelsOfItem * get_global_id(0); texel < num_texels; ++texel) { \
    work;                                                                            \
  }
#define PATINATE_IS_WHOLE (kTexelsOfItem * get_global_id(0) + kTexelsOfItem <= num_texels)
#define PATINATE_INDICES_OF_ITEM (((global const uint4*)indices)[get_global_id(0)])

kernel void gather_1(const ulong num_texels, global const uint* indices, global const uchar* source,
                     global uchar* values) {
  if (PATINATE_IS_WHOLE) {
    const uint4 at = PATINATE_INDICES_OF_ITEM;
    ((global uchar4*)values)[get_global_id(0)] =
        (uchar4)(pixel_1(source, at.x), pixel_1(source, at.y), pixel_1(source, at.z), pixel_1(source, at.w));
  } else {
    PATINATE_REST(values[texel] = pixel_1(source, indices[texel]))
  }
}

kernel void gather_2(const ulong num_texels, global const uint* indices, global const ushort* source,
                     global ushort* values) {
  if (PATINATE_IS_WHOLE) {
    const uint4 at = PATINATE_INDICES_OF_ITEM;
    ((global ushort4*)values)[get_global_id(0)] =
        (ushort4)(pixel_2(source, at.x), pixel_2(source, at.y), pixel_2(source, at.z), pixel_2(source, at.w));
  } else {
    PATINATE_REST(values[texel] = pixel_2(source, indices[texel]))
  }
}

kernel void gather_4(const ulong num_texels, global const uint* indices, global const uint* source,
                     global uint* values) {
  if (PATINATE_IS_WHOLE) {
    const uint4 at = PATINATE_INDICES_OF_ITEM;
    ((global uint4*)values)[get_global_id(0)] =
        (uint4)(pixel_4(source, at.x), pixel_4(source, at.y), pixel_4(source, at.z), pixel_4(source, at.w));
  } else {
    PATINATE_REST(values[texel] = pixel_4(source, indices[texel]))
  }
}

kernel void gather_8(const ulong num_texels, global const uint* indices, global const uint2* source,
                     global uint2* values) {
  if (PATINATE_IS_WHOLE) {
    const uint4 at = PATINATE_INDICES_OF_ITEM;
    global uint4* to = (global uint4*)values + 2 * get_global_id(0);
    to[0] = (uint4)(pixel_8(source, at.x), pixel_8(source, at.y));
    to[1] = (uint4)(pixel_8(source, at.z), pixel_8(source, at.w));
  } else {
    PATINATE_REST(values[texel] = pixel_8(source, indices[texel]))
  }
}

kernel void gather_16(const ulong num_texels, global const uint* indices, global const uint4* source,
                      global uint4* values) {
  if (PATINATE_IS_WHOLE) {
    const uint4 at = PATINATE_INDICES_OF_ITEM;
    global uint4* to = values + 4 * get_global_id(0);
    to[0] = pixel_16(source, at.x);
    to[1] = pixel_16(source, at.y);
    to[2] = pixel_16(source, at.z);
    to[3] = pixel_16(source, at.w);
  } else {
    PATINATE_REST(values[texel] = pixel_16(source, indices[texel]))
  }
}

// Three bytes a texel from pixels of four, of which the last is 0: twelve bytes of an item are three words.
kernel void gather_3_of_4(const ulong num_texels, global const uint* indices, global const uint* source,
                          global uchar* values) {
  if (PATINATE_IS_WHOLE) {
    const uint4 at = PATINATE_INDICES_OF_ITEM;
    const uint a = pixel_4(source, at.x), b = pixel_4(source, at.y), c = pixel_4(source, at.z),
               d = pixel_4(source, at.w);
    global uint* to = (global uint*)values + 3 * get_global_id(0);
    to[0] = a | b << 24;
    to[1] = b >> 8 | c << 16;
    to[2] = c >> 16 | d << 8;
  } else {
    PATINATE_REST(const uint pixel = pixel_4(source, indices[texel]); values[3 * texel] = (uchar)pixel;
                  values[3 * texel + 1] = (uchar)(pixel >> 8); values[3 * texel + 2] = (uchar)(pixel >> 16))
  }
}

// The same of words.
kernel void gather_12_of_16(const ulong num_texels, global const uint* indices, global const uint4* source,
                            global uint* values) {
  if (PATINATE_IS_WHOLE) {
    const uint4 at = PATINATE_INDICES_OF_ITEM;
    const uint4 a = pixel_16(source, at.x), b = pixel_16(source, at.y), c = pixel_16(source, at.z),
                d = pixel_16(source, at.w);
    global uint4* to = (global uint4*)values + 3 * get_global_id(0);
    to[0] = (uint4)(a.xyz, b.x);
    to[1] = (uint4)(b.yz, c.xy);
    to[2] = (uint4)(c.z, d.xyz);
  } else {
    PATINATE_REST(const uint4 pixel = pixel_16(source, indices[texel]); values[3 * texel] = pixel.x;
                  values[3 * texel + 1] = pixel.y; values[3 * texel + 2] = pixel.z)
  }
}

static inline FramePosition position_of(const TimesNumbers* numbers, global const double* frame_times,
                                        global const int* bins, float time) {
  const FrameTimes frames = {frame_times,       bins,
                             numbers->bins_per_time, numbers->num_times,
                             numbers->num_bins, numbers->between};
  return locate_frame(&frames, (double)time, 0);
}
static inline bool is_of_block(const TimesNumbers* numbers, FramePosition at) {
  return at.index >= numbers->first && at.index < numbers->end;
}

// Marks the frames that texels of a block look at. Several items may mark one: all write the same.
kernel void mark_frames(const TimesNumbers numbers, global const double* frame_times, global const int* bins,
                        global const uint* indices, global const float* times, global uchar* is_needed) {
  const ulong item = get_global_id(0);
  if (item >= numbers.num_texels || indices[item] == kNone) return;
  const FramePosition at = position_of(&numbers, frame_times, bins, times[item]);
  if (!is_of_block(&numbers, at)) return;
  is_needed[at.index - numbers.first] = 1;
  if (at.fraction != 0.0) is_needed[at.index - numbers.first + 1] = 1;
}

// frames: those of the block and the next, kPixelSize numbers a pixel; colors: three a texel, 0 where it shows nothing,
// left alone where its time is another block's.
kernel void look_up_times(const TimesNumbers numbers, global const double* frame_times, global const int* bins,
                          global const uint* indices, global const float* times, global const float* frames,
                          global float* colors) {
  const ulong item = get_global_id(0);
  if (item >= numbers.num_texels) return;
  global float* color = colors + 3 * item;
  if (indices[item] == kNone) {
    for (int c = 0; c < 3; ++c) color[c] = 0.0f;
    return;
  }
  const FramePosition at = position_of(&numbers, frame_times, bins, times[item]);
  if (!is_of_block(&numbers, at)) return;
  global const float* before =
      frames + kPixelSize * ((ulong)(at.index - numbers.first) * numbers.num_pixels + indices[item]);
  float blend[kPixelSize];
  if (at.fraction == 0.0) {
    for (int c = 0; c < 3; ++c) color[c] = before[c];
  } else {
    blend_pixels(before, before + kPixelSize * numbers.num_pixels, at.fraction, blend);
    for (int c = 0; c < 3; ++c) color[c] = blend[c];
  }
}
