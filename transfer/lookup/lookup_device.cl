// The entries of lookups. Indices of texels that show nothing are kNone.

#define kNone 0xFFFFFFFFu

// An item a value: what the source has at a texel's index, 0 where it shows nothing.
kernel void gather_bytes(const ulong num_values, const uint channels, global const uint* indices,
                         global const uchar* source, global uchar* values) {
  const ulong item = get_global_id(0);
  if (item >= num_values) return;
  const uint index = indices[item / channels];
  values[item] = index == kNone ? (uchar)0 : source[(ulong)index * channels + item % channels];
}
kernel void gather_floats(const ulong num_values, const uint channels, global const uint* indices,
                          global const float* source, global float* values) {
  const ulong item = get_global_id(0);
  if (item >= num_values) return;
  const uint index = indices[item / channels];
  values[item] = index == kNone ? 0.0f : source[(ulong)index * channels + item % channels];
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

// frames: those of the block and the next, kPixelSize numbers a pixel; colors: three a texel.
kernel void look_up_times(const TimesNumbers numbers, global const double* frame_times, global const int* bins,
                          global const uint* indices, global const float* times, global const float* frames,
                          global float* colors) {
  const ulong item = get_global_id(0);
  if (item >= numbers.num_texels || indices[item] == kNone) return;
  const FramePosition at = position_of(&numbers, frame_times, bins, times[item]);
  if (!is_of_block(&numbers, at)) return;
  global const float* before =
      frames + kPixelSize * ((ulong)(at.index - numbers.first) * numbers.num_pixels + indices[item]);
  global float* color = colors + 3 * item;
  float blend[kPixelSize];
  if (at.fraction == 0.0) {
    for (int c = 0; c < 3; ++c) color[c] = before[c];
  } else {
    blend_pixels(before, before + kPixelSize * numbers.num_pixels, at.fraction, blend);
    for (int c = 0; c < 3; ++c) color[c] = blend[c];
  }
}
