// How wide gammatons and trails lie on texels: splat.h, surface_walk.h, pieces.h. In the dialect of
// kernel_language.inl, behind transfer_kernel.inl.

PATINATE_CONSTANT(i32, kVarianceOne, 64);       // Variances along an axis, texels^2: 1.
PATINATE_CONSTANT(i32, kMaxVariance, 30 * 64);  // A standard deviation of 5.5 texels.
PATINATE_CONSTANT(u32, kWalkTexels, 720u);      // SplatShape::kMaxParts.
PATINATE_CONSTANT(u32, kWalkEdges, 6u * 720u);  // A surface may branch; what finds no room is a wall.
PATINATE_CONSTANT(i32, kDeepestWalk, 22);       // Links: four standard deviations of the widest splat.
PATINATE_CONSTANT(double, kLargestStep, 0.25);  // Of variance: more than an eighth over each side is too much.

// The variance of a splat on texels of an area weight; 0 = one texel, which is twice as wide. @param width  In texels
// of median size.
PATINATE_INLINE i32 splat_variance(double width, u32 weight) {
  const double size = (double)kVarianceOne / 36.0 * width * width * (double)kMedianTexelWeight / (double)weight;
  if (size < (double)(kVarianceOne / 16)) return 0;
  return size + 0.5 < (double)kMaxVariance ? (i32)(size + 0.5) : kMaxVariance;
}

// Of what is left along a trail of so many contacts, over that of a drop: as large a stain where it was short.
PATINATE_INLINE double stain_width(u32 length) { return 1.0 + 2.0 / (double)length; }

// Steps of one kind: `share` goes to each of four neighbors, the rest stays.
typedef struct WalkLength {
  PATINATE_MEMBER(i32, num_steps, 0);
  PATINATE_MEMBER(double, share, 0.0);
} WalkLength;

PATINATE_INLINE WalkLength walk_length(i32 size) {
  const double variance = (double)size / (double)kVarianceOne;
  WalkLength walk;
  walk.num_steps = 1;
  while ((double)walk.num_steps * kLargestStep < variance) ++walk.num_steps;
  walk.share = 0.5 * variance / (double)walk.num_steps;
  return walk;
}

// Of the middle's share per area: texels with less are left out, beyond 2.6 standard deviations. Short walks keep all.
PATINATE_INLINE double least_of_walk(i32 num_steps) { return num_steps > 3 ? 1.0 / 32.0 : 0.0; }

// Links from the middle at most: four standard deviations along the diagonal of the links, which is 2.8 on the surface;
// beyond lies less than least_of_walk().
PATINATE_INLINE i32 walk_depth(i32 size, i32 num_steps) {
  i32 depth = 1;
  while (depth * depth * kVarianceOne < 16 * size) ++depth;
  if (depth > num_steps) depth = num_steps;
  return depth < kDeepestWalk ? depth : kDeepestWalk;
}

// Of what is on a texel, over a link that is named `count` times, as a multiple of what goes between two whole texels.
// @param whole  The weights of whole texels here and there, summed.
PATINATE_INLINE double link_flow(u32 weight, u32 other, u32 whole, u32 count) {
  const u32 least = weight < other ? weight : other;
  const u32 twice = whole < 4u * least ? whole : 4u * least;  // No more than a small one has.
  // Between whole texels, which most are, without a division.
  return count * twice == 4u * weight ? 1.0 : (double)count * (double)twice / (4.0 * (double)weight);
}

// Whether a walk's share counts that is not the middle's.
PATINATE_INLINE bool is_counted(double share, double weight, double least, double middle_share, u32 other) {
  return share * weight >= least * middle_share * (double)other;
}

PATINATE_INLINE u32 whole_share(double share, double sum) { return (u32)(share / sum * (double)kWholeSplat); }

// Trails keep the texels of the last contacts in a ring: how many they have, which is the i-th, the oldest first, and
// how many were added after one more, which stays below 2 * kTrailLength and keeps its place in the ring.
PATINATE_CONSTANT(u32, kTrailLength, 16u);
PATINATE_INLINE u32 trail_size(u32 num_added) { return num_added < kTrailLength ? num_added : kTrailLength; }
PATINATE_INLINE u32 trail_place(u32 num_added, u32 i) { return (num_added - trail_size(num_added) + i) % kTrailLength; }
PATINATE_INLINE u32 one_more_added(u32 num_added) {
  return num_added + 1u == 2u * kTrailLength ? kTrailLength : num_added + 1u;
}
// Splats along a trail of `length` have shares that rise by one each: the way ends dark, and begins without a step.
PATINATE_INLINE u32 trail_whole(u32 length) { return length * (length + 1u) / 2u; }
PATINATE_INLINE u32 trail_share(u32 share, u32 of_place, u32 whole) { return share * of_place / whole; }
#ifdef __OPENCL_VERSION__
typedef struct Trail {  // The class of trail.h.
  u32 texel[16];
  u32 num_added;
} Trail;
#endif
