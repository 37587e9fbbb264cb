// The best of the candidates of one texel, and what they cost (energy.h, multi_level.h), in the dialect of
// kernel_language.inl: behind philox.inl and texel_neighbors.inl.

#ifndef PATINATE_MOST_NEIGHBORS  // A device's program says how many there are, to keep little.
#define PATINATE_MOST_NEIGHBORS 128
#endif

enum {
  kComponents = 8,       // Of the appearance.
  kAlikeCandidates = 3,  // k-coherent ones of a pixel.
  kTexelsBeside = 8,
  kLargestControl = 4095,
  kControlGridSide = 64,
  kOfOne = 16,         // Preferences are in sixteenths,
  kReuseQuarters = 4,  // what is used too often in quarters,
  kExcessOne = 256,
  kExcessCells = 16,  // by value of the first control, and by look.
  kFixedOne = 256     // Of a pixel.
};

// Usable pixels by control value: SourceLevel has them.
typedef struct AlikeTables {
  PATINATE_GLOBAL const i32* usable;
  PATINATE_GLOBAL const i32* first_with;
  PATINATE_GLOBAL const i32* grid_cell;
  PATINATE_GLOBAL const i32* grid_begin;
  PATINATE_GLOBAL const i32* grid_pixels;
  i32 num_usable;
  i32 num_controls;
} AlikeTables;

// Some of them.
typedef struct AlikePixels {
  PATINATE_GLOBAL const i32* pixels;
  i32 num;
} AlikePixels;

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

PATINATE_INLINE i32 control_cell(PATINATE_GLOBAL const u16* controls) {
  const i32 steps_a_cell = kLargestControl / kControlGridSide + 1;
  return controls[1] / steps_a_cell * kControlGridSide + controls[0] / steps_a_cell;
}

PATINATE_INLINE i32 first_usable_with(const AlikeTables* tables, i32 value) {
  const i32 low = value < 0 ? 0 : value;
  return tables->first_with[low > kLargestControl + 1 ? kLargestControl + 1 : low];
}

// SourceLevel::similar() is this.
PATINATE_INLINE AlikePixels alike_pixels(const AlikeTables* tables, PATINATE_GLOBAL const u16* target, i32 tolerance) {
  AlikePixels alike;
  if (tables->num_controls > 1) {
    const i32 cell = tables->grid_cell[control_cell(target)];
    alike.pixels = tables->grid_pixels + tables->grid_begin[cell];
    alike.num = tables->grid_begin[cell + 1] - tables->grid_begin[cell];
    return alike;
  }
  i32 begin = first_usable_with(tables, target[0] - tolerance);
  i32 end = first_usable_with(tables, target[0] + tolerance + 1);
  if (begin == end) {  // The nearest values on either side.
    const i32 few = 16, left = tables->num_usable - end;
    begin -= begin < few ? begin : few;
    end += left < few ? left : few;
  }
  alike.pixels = tables->usable + begin;
  alike.num = end - begin;
  return alike;
}

// The places of all texels, as PlaceMap keeps them.
typedef struct PlaceTables {
  PATINATE_GLOBAL const i32* pixels;
  PATINATE_GLOBAL const i8* beside;  // x, y of each, in 1/256 pixel.
  i32 width;                         // Of the source,
  i32 shift;                         // and what divides by it: pixel * reciprocal >> shift.
  u64 reciprocal;
} PlaceTables;

// In 1/256 pixel; its pixel is y * width + x of the nearest, -1 = none.
typedef struct FixedPlace {
  i32 pixel, x, y;
} FixedPlace;

PATINATE_INLINE FixedPlace place_of_texel(const PlaceTables* places, i64 texel) {
  FixedPlace place;
  place.pixel = places->pixels[texel];
  // pixel / width, exactly for all pixels below 2^31 [Granlund and Montgomery 1994, "Division by invariant integers
  // using multiplication"].
  const i32 row = (i32)((u64)place.pixel * places->reciprocal >> places->shift);
  place.x = (place.pixel - row * places->width) * kFixedOne + places->beside[2 * texel];
  place.y = row * kFixedOne + places->beside[2 * texel + 1];
  return place;
}

// Beside the middle of its pixel: [-128, 127].
PATINATE_INLINE i32 beside_middle(i32 fixed) { return fixed - whole_pixels(fixed) * kFixedOne; }

typedef struct Preferences {
  i32 bonus;  // In 1 / kOfOne, as the other two: at most 16 (1 + 8 + 8 * 8) = 1168 in all, so that products stay below
              // 2^62.
  i32 penalty;
  i32 amounts;
  i32 leaves_quiet;  // A texel that continues all its neighbors is left as it is.
} Preferences;

// What a pass goes by besides the energy; tables are looked at where there is such a preference.
typedef struct PreferenceTables {
  Preferences factors;
  PATINATE_GLOBAL const u8* reuse;    // By pixel, in 1 / kReuseQuarters.
  PATINATE_GLOBAL const u8* look;     // By pixel.
  PATINATE_GLOBAL const i32* excess;  // kExcessCells x kExcessCells.
} PreferenceTables;

typedef struct SearchPass {
  SourceTables source;
  AlikeTables alike;
  CostTables cost;
  PlaceTables places;
  PreferenceTables preferences;
  PATINATE_GLOBAL const u16* targets;  // num_controls a texel.
  i32 num_random;
  i32 tolerance;  // How near "similar control value" is.
} SearchPass;

PATINATE_CONSTANT(i64, kNoCost, 0x7FFFFFFFFFFFFFFFl);

// What one texel asks for, and the best so far.
typedef struct TexelSearch {
  PATINATE_GLOBAL const u16* target;
  FixedPlace best;
  i64 best_cost;
} TexelSearch;

// @returns whether it is the best so far.
PATINATE_INLINE bool try_place(const SearchPass* pass, PATINATE_LOCAL KnownNeighbors* known, FixedPlace place,
                               i32 bonus, TexelSearch* search) {
  const PreferenceTables* p = &pass->preferences;
  const i32 reuse = p->factors.penalty == 0 ? 0 : p->reuse[place.pixel];
  i32 excess = 0;
  if (p->factors.amounts != 0) {
    const i32 value = search->target[0] * kExcessCells / (kLargestControl + 1);
    excess = p->excess[value * kExcessCells + p->look[place.pixel]];
    excess = excess > 0 ? excess : 0;
  }
  const i64 factor =
      kOfOne + bonus + p->factors.penalty * reuse / kReuseQuarters + p->factors.amounts * excess / kExcessOne;
  const i64 cost = cost_beside(&pass->source, &pass->cost, search->target, known, place.pixel, beside_middle(place.x),
                               beside_middle(place.y), search->best_cost / factor + 1) *
                   factor;
  if (cost >= search->best_cost) return false;
  search->best_cost = cost;
  search->best = place;
  return true;
}

PATINATE_INLINE FixedPlace middle_of(const SourceTables* source, i32 pixel) {
  FixedPlace place;
  place.pixel = pixel;
  place.x = pixel % source->width * kFixedOne;
  place.y = pixel / source->width * kFixedOne;
  return place;
}

// Where the source of a neighbor leads; its pixel is kNoSource or kOutside where nothing can be copied from there.
enum { kNoSource = -2, kOutside = -1 };

PATINATE_INLINE FixedPlace continued_place(const SearchPass* pass, i64 texel, PixelNeighbor n) {
  FixedPlace place = {kNoSource, 0, 0};
  if (n.texel < 0 || n.texel == texel) return place;
  place = place_of_texel(&pass->places, n.texel);
  place.x -= n.x;
  place.y -= n.y;
  const i32 x = whole_pixels(place.x), y = whole_pixels(place.y), width = pass->source.width;
  const bool is_inside = x >= 0 && y >= 0 && x < width && y < pass->source.height;
  place.pixel = is_inside ? y * width + x : kOutside;
  if (is_inside && pass->source.is_usable[place.pixel] == 0) place.pixel = kOutside;
  return place;
}

// The places that a texel begins its search with: where the eight neighbors' sources lead, each pixel once (in coherent
// regions all eight agree), and its own behind them unless it is one of those.
typedef struct BegunPlaces {
  FixedPlace places[kTexelsBeside + 1];
  i32 num_continued;
  i32 num;
  i32 is_quiet;  // It is left as it is.
} BegunPlaces;

// leads: by neighbor, continued_place().
PATINATE_INLINE void begin_places(const SearchPass* pass, PATINATE_LOCAL const FixedPlace* leads, FixedPlace current,
                                  PATINATE_LOCAL BegunPlaces* begun) {
  i32 num = 0;
  bool leads_outside = false, is_continued = false;
  for (i32 k = 0; k < kTexelsBeside; ++k) {
    const FixedPlace place = leads[k];
    leads_outside = leads_outside || place.pixel == kOutside;
    bool is_new = place.pixel >= 0;
    for (i32 i = 0; i < num; ++i) is_new = is_new && begun->places[i].pixel != place.pixel;
    if (!is_new) continue;
    is_continued = is_continued || place.pixel == current.pixel;
    begun->places[num++] = place;
  }
  begun->num_continued = num;
  begun->is_quiet = pass->preferences.factors.leaves_quiet != 0 && !leads_outside && num == 1 && is_continued ? 1 : 0;
  if (!is_continued) begun->places[num++] = current;
  begun->num = num;
}

PATINATE_INLINE i32 bonus_of(const SearchPass* pass, PATINATE_LOCAL const BegunPlaces* begun, i32 i) {
  return i < begun->num_continued ? 0 : pass->preferences.factors.bonus;
}

PATINATE_INLINE i32 similar_pixel(const SearchPass* pass, i32 pixel, i32 i) {
  return pass->source.similar[(i64)pixel * kAlikeCandidates + i];
}

#ifndef __OPENCL_VERSION__  // There the items of a group share the candidates among them: search_device.cl.
// The first of the best: where the neighbors' sources lead, its own place, what looks like each of those, and some of
// similar control value.
// neighbors: those that are compared, and behind them those beside. known: room.
PATINATE_INLINE FixedPlace best_place(const SearchPass* pass, i64 texel, const PixelNeighbor* neighbors,
                                      RandomState random, KnownNeighbors* known) {
  FixedPlace leads[kTexelsBeside];
  for (i32 k = 0; k < kTexelsBeside; ++k)
    leads[k] = continued_place(pass, texel, neighbors[pass->cost.num_neighbors + k]);
  BegunPlaces begun;
  const FixedPlace current = place_of_texel(&pass->places, texel);
  begin_places(pass, leads, current, &begun);
  if (begun.is_quiet != 0) return current;
  gather_known(&pass->source, &pass->cost, pass->places.pixels, texel, neighbors, known, 0);
  const i32 bonus = pass->preferences.factors.bonus;
  TexelSearch search;
  search.target = pass->targets + texel * pass->cost.num_controls;
  search.best = current;
  search.best_cost = kNoCost;
  for (i32 i = 0; i < begun.num; ++i) {
    try_place(pass, known, begun.places[i], bonus_of(pass, &begun, i), &search);
    for (i32 k = 0; k < kAlikeCandidates; ++k) {
      const i32 pixel = similar_pixel(pass, begun.places[i].pixel, k);
      if (pixel >= 0) try_place(pass, known, middle_of(&pass->source, pixel), bonus, &search);
    }
  }
  const AlikePixels alike = alike_pixels(&pass->alike, search.target, pass->tolerance);
  for (i32 i = 0; i < pass->num_random; ++i)
    try_place(pass, known, middle_of(&pass->source, alike.pixels[random_below(&random, (u32)alike.num)]), bonus,
              &search);
  return search.best;
}
#endif

enum { kInterleavedSets = 4 };  // A turn is a set's; 16 passes of them stay below 256.

// changed_near: the last turn in which the texel or one beside it changed.
PATINATE_INLINE bool is_due(u8 changed_near, i32 turn, bool is_whole) {
  return is_whole || turn < kInterleavedSets || changed_near + kInterleavedSets >= turn;
}

// What a pass over one of the interleaved sets on a device is given by value. The sets: texels of even or odd columns
// in even or odd rows.
typedef struct SearchNumbers {
  u64 seed;
  u64 reciprocal;  // As PlaceTables have it,
  i32 shift;       // and so on.
  i32 source_width, source_height;
  i32 num_usable, num_controls, num_neighbors, radius_px;
  Preferences factors;
  i32 num_random, tolerance;
  u32 stream;
  i32 width;    // Of the atlas,
  i32 columns;  // and of the set.
  i32 set, turn, is_whole;
  u32 num_items;  // Of the set; the last group may go on behind them.
} SearchNumbers;

// The texel of a set's item.
PATINATE_INLINE i64 texel_of_item(const SearchNumbers* numbers, u64 item) {
  const i64 columns = numbers->columns, x = (i64)item % columns * 2 + numbers->set % 2,
            y = (i64)item / columns * 2 + numbers->set / 2;
  return y * numbers->width + x;
}
