// What a pixel costs a texel (energy.h), in the dialect of kernel_language.inl: behind texel_neighbors.inl.

#ifndef PATINATE_MOST_NEIGHBORS  // A device's program says how many there are, to keep little.
#define PATINATE_MOST_NEIGHBORS 128
#endif

enum { kComponents = 8 };  // Of the appearance.

typedef struct SourceTables {
  PATINATE_GLOBAL const i16* appearance;  // kComponents a pixel.
  PATINATE_GLOBAL const u16* controls;
  PATINATE_GLOBAL const u8* is_usable;
  PATINATE_GLOBAL const i32* similar;  // kAlikeCandidates a pixel; -1 = none.
  i32 width, height;
} SourceTables;

typedef struct CostTables {
  PATINATE_GLOBAL const i16* weights;           // By neighbor.
  PATINATE_GLOBAL const i64* coherence_scales;  // By the sum of weights of those known.
  PATINATE_GLOBAL const i64* control_scales;
  i32 num_neighbors;  // Those that are compared.
  i32 radius_px;
  i32 num_controls;
} CostTables;

// The neighbors that have coordinates and lie within the radius.
typedef struct KnownNeighbors {
  i32 num;
  i64 coherence_scale;
  PATINATE_ALIGNED_TO(16) i16 appearance[PATINATE_MOST_NEIGHBORS * kComponents];
  i16 weight[PATINATE_MOST_NEIGHBORS];
  i32 delta[PATINATE_MOST_NEIGHBORS];  // Their offset in the source, in values,
  i32 x[PATINATE_MOST_NEIGHBORS];      // and in 1/256 pixel.
  i32 y[PATINATE_MOST_NEIGHBORS];
#ifndef __OPENCL_VERSION__
  i32 delta_beside[PATINATE_MOST_NEIGHBORS];  // Seen from beside the middle of a pixel.
  i16 weight_beside[PATINATE_MOST_NEIGHBORS];
#endif
} KnownNeighbors;

PATINATE_INLINE bool lies_within(i32 x, i32 y, i32 radius) {
  return x >= -radius && x <= radius && y >= -radius && y <= radius;
}

// The k-th neighbor becomes the i-th known one. @returns false where it is not known; nothing is written then. Where
// texels are larger than the offset, a texel would be its own neighbor: that says nothing.
PATINATE_INLINE bool know_neighbor(const SourceTables* source, const CostTables* cost,
                                   PATINATE_GLOBAL const i32* coordinates, i64 texel, PixelNeighbor n, i32 k, i32 i,
                                   PATINATE_LOCAL KnownNeighbors* known) {
  const i32 s = n.texel >= 0 && n.texel != texel ? coordinates[n.texel] : -1;
  const i32 dx = whole_pixels(n.x), dy = whole_pixels(n.y);
  // Pixels know only what lies within the radius.
  if (s < 0 || !lies_within(dx, dy, cost->radius_px)) return false;
  for (i32 d = 0; d < kComponents; ++d)
    known->appearance[i * kComponents + d] = source->appearance[(i64)s * kComponents + d];
  known->weight[i] = cost->weights[k];
  known->delta[i] = (dy * source->width + dx) * kComponents;
  known->x[i] = n.x;
  known->y[i] = n.y;
  return true;
}

// In place of one that is not known, on devices, whose items each know a neighbor: of no weight, and compared with the
// candidate itself.
PATINATE_INLINE void forget_neighbor(PATINATE_LOCAL KnownNeighbors* known, i32 i) {
  known->weight[i] = 0;
  known->delta[i] = 0;
  known->x[i] = 0;
  known->y[i] = 0;
  for (i32 d = 0; d < kComponents; ++d) known->appearance[i * kComponents + d] = 0;
}

// known_at: by neighbor, which of the known ones it is; not touched where it is not known. May be 0.
PATINATE_INLINE void gather_known(const SourceTables* source, const CostTables* cost,
                                  PATINATE_GLOBAL const i32* coordinates, i64 texel, const PixelNeighbor* neighbors,
                                  PATINATE_LOCAL KnownNeighbors* known, i32* known_at) {
  i32 sum_of_weights = 0, num = 0;
  for (i32 k = 0; k < cost->num_neighbors; ++k) {
    if (!know_neighbor(source, cost, coordinates, texel, neighbors[k], k, num, known)) continue;
    sum_of_weights += cost->weights[k];
    if (known_at) known_at[k] = num;
    ++num;
  }
  known->num = num;
  known->coherence_scale = cost->coherence_scales[sum_of_weights];
}

// Of the k-th known neighbor and a pixel.
PATINATE_INLINE i32 squares_of(PATINATE_LOCAL const KnownNeighbors* known, i32 k, PATINATE_GLOBAL const i16* pixel) {
#ifdef __OPENCL_VERSION__  // Two loads of 16 bytes: what pixels and neighbors look like is aligned to that.
  const int8 difference = convert_int8(*(PATINATE_LOCAL const short8*)(known->appearance + k * kComponents)) -
                          convert_int8(*(PATINATE_GLOBAL const short8*)pixel);
  const int8 squares = difference * difference;
  return squares.s0 + squares.s1 + squares.s2 + squares.s3 + squares.s4 + squares.s5 + squares.s6 + squares.s7;
#else
  i32 squares = 0;
  for (i32 d = 0; d < kComponents; ++d) {
    const i32 difference = known->appearance[k * kComponents + d] - pixel[d];
    squares += difference * difference;
  }
  return squares;
#endif
}

// Where the i-th known neighbor lies, in values of the source, seen from beside the middle of a pixel.
typedef struct SeenNeighbor {
  i32 delta;
  i16 weight;  // 0 where it lies beyond the radius.
} SeenNeighbor;

PATINATE_INLINE SeenNeighbor seen_from(const SourceTables* source, const CostTables* cost,
                                       PATINATE_LOCAL const KnownNeighbors* known, i32 i, i32 beside_x, i32 beside_y) {
  const i32 dx = whole_pixels(known->x[i] + beside_x), dy = whole_pixels(known->y[i] + beside_y);
  const bool is_seen = lies_within(dx, dy, cost->radius_px);
  SeenNeighbor seen;
  seen.delta = is_seen ? (dy * source->width + dx) * kComponents : 0;
  seen.weight = is_seen ? known->weight[i] : (i16)0;
  return seen;
}

// sum_k w_k |difference_k|^2 over some of the known neighbors. |difference| <= 1022, weights <= 16 and 1024 in all: a
// lane of two components stays below 2^31.
PATINATE_INLINE i64 weighted_squares(PATINATE_LOCAL const KnownNeighbors* known, PATINATE_LOCAL const i32* delta,
                                     PATINATE_LOCAL const i16* weight, PATINATE_GLOBAL const i16* base, i32 begin,
                                     i32 end) {
#if defined(__SSE2__) && !defined(__OPENCL_VERSION__)
  __m128i sum = _mm_setzero_si128();
  for (i32 k = begin; k < end; ++k) {
    const __m128i own = _mm_loadu_si128(reinterpret_cast<const __m128i*>(known->appearance + k * kComponents));
    const __m128i candidate = _mm_loadu_si128(reinterpret_cast<const __m128i*>(base + delta[k]));
    const __m128i difference = _mm_sub_epi16(own, candidate);
    sum = _mm_add_epi32(sum, _mm_madd_epi16(difference, _mm_mullo_epi16(difference, _mm_set1_epi16(weight[k]))));
  }
  alignas(16) i32 lanes[4];
  _mm_store_si128(reinterpret_cast<__m128i*>(lanes), sum);
  return (i64)lanes[0] + lanes[1] + lanes[2] + lanes[3];
#else
  i64 total = 0;
  for (i32 k = begin; k < end; ++k) total += (i64)squares_of(known, k, base + delta[k]) * weight[k];
  return total;
#endif
}

// Stops early and returns something >= bound when it cannot be below it.
PATINATE_INLINE i64 coherence_cost(const SourceTables* source, PATINATE_LOCAL const KnownNeighbors* known,
                                   PATINATE_LOCAL const i32* delta, PATINATE_LOCAL const i16* weight, i32 pixel,
                                   i64 bound) {
  const i32 kBlock = 8;  // Neighbors between two looks at the bound.
  PATINATE_GLOBAL const i16* base = source->appearance + (i64)pixel * kComponents;
  i64 total = 0;
  for (i32 begin = 0; begin < known->num; begin += kBlock) {
    const i32 end = begin + kBlock < known->num ? begin + kBlock : known->num;
    total += weighted_squares(known, delta, weight, base, begin, end);
    if (total * known->coherence_scale >= bound) break;
  }
  return total * known->coherence_scale;
}

PATINATE_INLINE i64 control_cost(const SourceTables* source, const CostTables* cost, PATINATE_GLOBAL const u16* target,
                                 i32 pixel) {
  PATINATE_GLOBAL const u16* value = source->controls + (i64)pixel * cost->num_controls;
  i64 sum = 0;
  for (i32 c = 0; c < cost->num_controls; ++c) {
    const i64 difference = (i64)value[c] - target[c];
    sum += difference * difference * cost->control_scales[c];
  }
  return sum;
}

// Of the middle of a pixel. Stops early and returns something >= bound when it cannot be below it.
PATINATE_INLINE i64 cost_of_pixel(const SourceTables* source, const CostTables* cost, PATINATE_GLOBAL const u16* target,
                                  PATINATE_LOCAL const KnownNeighbors* known, i32 pixel, i64 bound) {
  const i64 control = control_cost(source, cost, target, pixel);
  if (control >= bound) return control;
  return control + coherence_cost(source, known, known->delta, known->weight, pixel, bound - control);
}

// Of a place beside the middle of its pixel, in 1/256 pixel: neighbors are compared with the pixels nearest to where
// they lie seen from there. Items of a device's group share what is known, and write nothing into it.
PATINATE_INLINE i64 cost_beside(const SourceTables* source, const CostTables* cost, PATINATE_GLOBAL const u16* target,
                                PATINATE_LOCAL KnownNeighbors* known, i32 pixel, i32 beside_x, i32 beside_y,
                                i64 bound) {
  const i64 control = control_cost(source, cost, target, pixel);
  if (control >= bound) return control;
#ifdef __OPENCL_VERSION__
  PATINATE_GLOBAL const i16* base = source->appearance + (i64)pixel * kComponents;
  i64 total = 0;
  for (i32 i = 0; i < known->num; ++i) {
    const SeenNeighbor seen = seen_from(source, cost, known, i, beside_x, beside_y);
    total += (i64)squares_of(known, i, base + seen.delta) * seen.weight;
  }
  return control + total * known->coherence_scale;
#else
  if (beside_x == 0 && beside_y == 0)
    return control + coherence_cost(source, known, known->delta, known->weight, pixel, bound - control);
  for (i32 i = 0; i < known->num; ++i) {
    const SeenNeighbor seen = seen_from(source, cost, known, i, beside_x, beside_y);
    known->delta_beside[i] = seen.delta;
    known->weight_beside[i] = seen.weight;
  }
  return control + coherence_cost(source, known, known->delta_beside, known->weight_beside, pixel, bound - control);
#endif
}
