// Where times fall between the frames of a history (frame_locator.h), in the dialect of kernel_language.inl.

enum { kBlendFrames, kHoldFrame, kNearestFrame };

// Frame `index` and the next one weighted (1 - fraction) and fraction.
typedef struct FramePosition {
  i32 index;
  double fraction;
} FramePosition;

typedef struct FrameTimes {
  PATINATE_GLOBAL const double* times;
  PATINATE_GLOBAL const i32* first;  // Per bin of equal length: the frame at or before its beginning.
  double bins_per_time;
  i32 num_times, num_bins;
  i32 between;
} FrameTimes;

// NaN is at the last frame. hint: a frame that the time may lie after; any.
PATINATE_INLINE FramePosition locate_frame(const FrameTimes* frames, double time, i32 hint) {
  PATINATE_GLOBAL const double* times = frames->times;
  const i32 last = frames->num_times - 1;
  FramePosition at;
  at.index = hint;
  at.fraction = 0.0;
  if (!(hint < last && times[hint] <= time && time < times[hint + 1])) {
    at.index = time <= times[0] ? 0 : last;
    if (time <= times[0] || !(time < times[last])) return at;
    const u64 bin = (u64)((time - times[0]) * frames->bins_per_time);
    // Rounding may put a time into the bin beside its own.
    at.index = frames->first[bin < (u64)frames->num_bins ? bin : (u64)frames->num_bins - 1];
    while (times[at.index] > time) --at.index;
    while (times[at.index + 1] <= time) ++at.index;
  }
  const double fraction = (time - times[at.index]) / (times[at.index + 1] - times[at.index]);
  if (frames->between == kBlendFrames) at.fraction = fraction;
  if (frames->between == kNearestFrame && fraction >= 0.5) ++at.index;
  return at;
}
