// What the exact search of a window calculates (window_search.h, neighborhood_projection.h, reference.h), in the
// dialect of kernel_language.inl: behind philox.inl, texel_neighbors.inl, cost_kernel.inl and search_kernel.inl.

enum {
  kProjectedValues = 16,
  kProjectionUnit = 4,  // Projections are in units of this many of the appearance's.
  kAxisBits = 13,       // Axes are integers over 2 to this.
  kNeighborhoodQuarters = 4,
  kEveryQuarter = 15,
  kReachControlBits = 16,
  kWindowTries = 64  // Pixels of similar control value of which one is a window's center.
};

// Pixels [x0, x1) x [y0, y1).
typedef struct SearchWindow {
  PATINATE_MEMBER(i32, x0, 0);
  PATINATE_MEMBER(i32, y0, 0);
  PATINATE_MEMBER(i32, x1, 0);
  PATINATE_MEMBER(i32, y1, 0);
} SearchWindow;

PATINATE_INLINE i64 at_most(i64 value, i64 most) { return value < most ? value : most; }
PATINATE_INLINE i64 moved_between(i64 value, i64 low, i64 high) {
  return value < low ? low : value > high ? high : value;
}

// The window of `side` pixels around a place, moved into the source.
PATINATE_INLINE SearchWindow window_around(i64 x, i64 y, i32 side, i32 width, i32 height) {
  SearchWindow window;
  window.x0 = (i32)moved_between(x - side / 2, 0, width > side ? width - side : 0);
  window.y0 = (i32)moved_between(y - side / 2, 0, height > side ? height - side : 0);
  window.x1 = (i32)at_most((i64)window.x0 + side, width);
  window.y1 = (i32)at_most((i64)window.y0 + side, height);
  return window;
}

// Is `pixel` in it, of a source that is `width` wide?
PATINATE_INLINE bool window_holds(SearchWindow window, i32 pixel, i32 width) {
  const i32 x = pixel % width, y = pixel / width;
  return x >= window.x0 && x < window.x1 && y >= window.y0 && y < window.y1;
}

// Of a square >= 0.
PATINATE_INLINE i64 root_rounded_down(i64 square) {
  i64 root = (i64)PATINATE_SQRT((double)square);
  while (root * root > square) --root;  // The root is rounded.
  while ((root + 1) * (root + 1) <= square) ++root;
  return root;
}

// Of the whole of a window's cost, what may be lost: a texel takes any pixel that costs no more.
PATINATE_INLINE i64 loosened_cost(i64 least, double epsilon) { return least + (i64)(epsilon * (double)least); }

// Has this neighbor coordinates?
PATINATE_INLINE bool has_place(PATINATE_GLOBAL const i32* pixels, PixelNeighbor n) {
  return n.texel >= 0 && pixels[n.texel] >= 0;
}

// Where a neighbor that has_place() would put the texel; pixel -1 where none can be copied.
PATINATE_INLINE FixedPlace led_place(const SourceTables* source, const PlaceTables* places, PixelNeighbor n) {
  FixedPlace place = place_of_texel(places, n.texel);
  place.x -= n.x;
  place.y -= n.y;
  const i32 x = whole_pixels(place.x), y = whole_pixels(place.y);
  place.pixel = x >= 0 && y >= 0 && x < source->width && y < source->height ? y * source->width + x : -1;
  if (place.pixel >= 0 && source->is_usable[place.pixel] == 0) place.pixel = -1;
  return place;
}

// The same of whole pixels: the neighbor's is `from`. Usable or not; -1 outside of the source.
PATINATE_INLINE i32 led_pixel(const SourceTables* source, i32 from, PixelNeighbor n) {
  const i32 x = from % source->width - whole_pixels(n.x), y = from / source->width - whole_pixels(n.y);
  return x >= 0 && y >= 0 && x < source->width && y < source->height ? y * source->width + x : -1;
}

// In whole pixels, of sums of weight * place over some weights.
PATINATE_INLINE i64 mean_place(i64 sum, i64 weights) { return sum / (weights * kFixedOne); }

PATINATE_INLINE i64 squared_apart(i32 pixel, i32 width, i64 x, i64 y) {
  const i64 dx = pixel % width - x, dy = pixel / width - y;
  return dx * dx + dy * dy;
}

// Of a projection of neighborhoods by one row of values: an axis, or the weights of a part, whose last value says how
// long the rest is that its axes leave (NeighborhoodProjection).
PATINATE_INLINE i32 projection_term(i16 value, i16 row, bool is_rest) {
  return value * (is_rest ? (i16)(value * row) : row);
}
// By the sums of terms. Axes are short, so that the squares of their sums are at most 2^22 times the part's weighted
// squares: below 2^53.
PATINATE_INLINE i16 projected_value(i32 sum) { return (i16)(sum >> kAxisBits); }
PATINATE_INLINE i64 squared_length(i32 sum) {
  return ((i64)sum << (2 * kAxisBits)) / (kProjectionUnit * kProjectionUnit);
}
PATINATE_INLINE i16 projected_rest(i64 squares_left) { return (i16)(root_rounded_down(squares_left) >> kAxisBits); }

// The largest |p - q|^2 of projections of neighborhoods that differ by `squares` >= 0: (sqrt(squares) / 4 + 4)^2,
// rounded up. Of squares + 16 x it is at least x more.
PATINATE_INLINE i64 projection_reach(i64 squares) {
  return squares / (kProjectionUnit * kProjectionUnit) + 2 * (root_rounded_down(squares) + 1) + 17;
}

// How far a projection may be from a texel's when the pixel's cost does not exceed a bound.
typedef struct ProjectionReach {
  i64 coherence_scale, control_scale;
  i32 target;  // Of the first control.
} ProjectionReach;

// coherence_scale > 0.
PATINATE_INLINE ProjectionReach reach_of(i64 coherence_scale, i64 first_control_scale, i32 target) {
  // Squares of differences take 24 bits, the ratio of scales what is left.
  const i64 largest = (i64)1 << 38, squared_unit = kProjectionUnit * kProjectionUnit;
  ProjectionReach reach;
  reach.coherence_scale = coherence_scale;
  reach.control_scale = at_most(largest, (first_control_scale << kReachControlBits) / (squared_unit * coherence_scale));
  reach.target = target;
  return reach;
}

PATINATE_CONSTANT(i64, kAnyDistance, 0x7FFFFFFFFFFFFFFFl);

// Of pixels that cost at most `bound`: their squared distance.
PATINATE_INLINE i64 reach_within(const ProjectionReach* reach, i64 bound) {
  const i64 farthest = (i64)1 << 40, squares = bound / reach->coherence_scale;
  return squares < farthest ? projection_reach(squares + 1) : kAnyDistance;
}

// Of controls in [low, high]: what their difference alone takes from the squared distance.
PATINATE_INLINE i64 reach_taken(const ProjectionReach* reach, i32 low, i32 high) {
  const i32 below = low - reach->target, above = reach->target - high;
  const i64 d = below > 0 ? below : above > 0 ? above : 0;
  return (d * d * reach->control_scale) >> kReachControlBits;
}

// Does the neighbor at an offset in whole pixels lie where it should?
PATINATE_INLINE bool lies_at(PixelNeighbor n, i32 x, i32 y) { return whole_pixels(n.x) == x && whole_pixels(n.y) == y; }

// Can the projections of whole quarters be compared (bit q of `quarters` for quarter q)? Where they hold less than four
// sevenths of the known neighbors, they say too little to be worth the while (measured).
PATINATE_INLINE bool compares_projections(i64 coherence_scale, u32 quarters, i32 num_known, i32 num_neighbors) {
  const i32 num_whole = PATINATE_NUM_BITS((u64)quarters) * num_neighbors / kNeighborhoodQuarters;
  return coherence_scale != 0 && quarters != 0u && 7 * num_whole >= 4 * num_known;
}

// The squared distance of a pixel's projection from a texel's, over the values of some quarters: reach_kernel.inc
// compares 16 pixels at once.
PATINATE_INLINE i32 projected_distance(const i16* query, const i16* projection, u32 quarters) {
  i32 sum = 0;
  for (i32 j = 0; j < kProjectedValues; ++j) {
    const i32 d = (quarters >> (j / kNeighborhoodQuarters) & 1u) != 0u ? query[j] - projection[j] : 0;
    sum += d * d;
  }
  return sum;
}
