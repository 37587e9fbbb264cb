// The best of the candidates of one texel (multi_level.h), in the dialect of kernel_language.inl: behind philox.inl,
// texel_neighbors.inl and cost_kernel.inl.

enum {
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
