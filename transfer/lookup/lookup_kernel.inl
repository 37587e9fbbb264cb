// Colors between two frames, in the dialect of kernel_language.inl. A pixel has one number more than colors do, so that
// it is one register.

enum { kPixelSize = 4 };

PATINATE_INLINE void blend_pixels(PATINATE_GLOBAL const float* a, PATINATE_GLOBAL const float* b, double fraction,
                                  float* blend) {
  const float share = (float)fraction, rest = 1.0f - share;
  for (i32 c = 0; c < kPixelSize; ++c) blend[c] = rest * a[c] + share * b[c];
}

// What all texels of a block of frames share.
typedef struct TimesNumbers {
  u64 num_texels;
  u64 num_pixels;  // Of a frame.
  double bins_per_time;
  i32 num_times, num_bins, between;  // Of FrameTimes.
  i32 first, end;                    // Frames that the block answers for.
} TimesNumbers;
