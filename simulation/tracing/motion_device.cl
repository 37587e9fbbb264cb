// The entries of gammatons' ways: an item a gammaton. Those that were born are loaded, and those that end are entered
// into the tally, at once or once what they carry lies along their trails.

static bool is_clear(const struct Surroundings* s, i32 triangle, bool is_front) {
  return s->clear[2 * triangle + (is_front ? 0 : 1)] != 0;
}

static double wet_amount(const struct Surroundings* s, i32 triangle, double b1, double b2) {
  const u32 texel = texel_at(&s->wet.places, triangle, b1, b2);
  return texel == kNowhere ? 0.0 : (double)s->wet.amounts[texel] / 16384.0;  // kAmountOne
}

#define SCENE_ARRAYS                                                                                              \
  const MotionFacts facts, global const BvhNode *nodes, global const TriangleBlock *blocks,                       \
      global const TriangleFrame *frames, global const CornerNormals *corner_normals,                             \
      global const TriangleLinks *links, global const uchar *empty_cells, global const uchar *clear,              \
      const PlaceFacts place_facts, global const float *corner_texels, global const int *charts,                  \
      global const uint *fallbacks, global const int *tile_charts, global const int *triangles,                   \
      global const ushort *amounts, const ulong first_wet

// `s` and `places` from the arguments.
#define SCENE_OF_ARRAYS                   \
  Places places;                          \
  places.facts = place_facts;             \
  places.corners = corner_texels;         \
  places.charts = charts;                 \
  places.fallbacks = fallbacks;           \
  places.tile_charts = tile_charts;       \
  places.triangles = triangles;           \
  Surroundings s;                         \
  s.facts = &facts;                       \
  s.nodes = nodes;                        \
  s.blocks = blocks;                      \
  s.frames = frames;                      \
  s.corner_normals = corner_normals;      \
  s.links = links;                        \
  s.empty_cells = empty_cells;            \
  s.clear = clear;                        \
  s.wet.places = places;                  \
  s.wet.amounts = amounts + first_wet

// What becomes of gammatons' cargo. ended: by gammaton, 1 + kMassAbsorbed and so on of those that ended and whose cargo
// is not in the tally yet; endings: those whose trails are to be laid.
#define LIFE_ARRAYS                                                                                         \
  const uint num_materials, const uint is_deposited, global uint *cargo, global Trail *trails, global uint *ended, \
      global uint *endings, global uint *tally

static inline void end_life(local uint* sums, global uint* mine, uint num_materials, uint kind) {
  for (uint m = 0u; m < num_materials; ++m) {
    if (mine[m] != 0u) add_here(sums + mass_at(kind, m), mine[m], 0u);
    mine[m] = 0u;
  }
}

static inline void bury(local uint* sums, uint item, uint kind, uint which, uint num_materials, bool has_trail,
                        global uint* cargo, global uint* ended, global uint* endings, global uint* tally) {
  if (!has_trail) {
    end_life(sums, cargo + item * num_materials, num_materials, kind);
    return;
  }
  ended[item] = 1u + kind;
  endings[atomic_inc(tally + kNumEndings + which)] = item;
}

// loads: by emitter and material; met: a bit for each texel; contacts: by gammaton, its texel.
kernel void trace_drops(SCENE_ARRAYS, const MotionCall call, global const EmitterFacts* emitters, const uint num,
                        global DropRecord* drops, LIFE_ARRAYS, global const uint* loads, global uint* met,
                        global uint* contacts) {
  const uint item = (uint)get_global_id(0);
  local uint sums[kGroupSums];
  clear_sums(sums);
  if (item == 0u) {  // No one needs them now.
    tally[kNumPieces + kPhaseOfResponses] = 0u;
    tally[kNumEndings + 1] = 0u;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item < num) {
    SCENE_OF_ARRAYS;
    global uint* mine = cargo + item * num_materials;
    if (ended[item] != 0u) {
      end_life(sums, mine, num_materials, ended[item] - 1u);
      ended[item] = 0u;
    }
    global DropRecord* record = drops + item;
    Drop g = drop_of(record);
    uint num_births = record->num_births;
    const Told told = trace_one(&s, &call, emitters + record->emitter, item, &g, &num_births);
    put_drop(&g, record);
    record->num_births = num_births;
    add_here(sums + count_at(kSegments), told.num_pieces, 0u);
    if (told.is_born != 0u) {
      add_here(sums + count_at(kEmitted), 1u, 0u);
      for (uint m = 0u; m < num_materials; ++m) {
        mine[m] = loads[record->emitter * num_materials + m];
        if (mine[m] != 0u) add_here(sums + mass_at(kMassEmitted, m), mine[m], 0u);
      }
    }
    uint texel = kNowhere;
    global Trail* trail = trails + item;
    if (told.end == kEndContact) {
      add_here(sums + count_at(kContacts), 1u, 0u);
      texel = texel_at(&places, g.at.triangle, g.at.b1, g.at.b2);
    }
    contacts[item] = texel;
    if (texel != kNowhere) {
      const uint num_added = told.is_landing != 0u ? 0u : trail->num_added;
      trail->texel[num_added % kTrailLength] = texel;
      trail->num_added = one_more_added(num_added);
      const uint bit = 1u << (texel & 31u);
      if ((met[texel >> 5] & bit) == 0u) atomic_or(met + (texel >> 5), bit);
    }
    if (told.end == kEndLeft) {
      add_here(sums + count_at(kLeft), 1u, 0u);
      end_life(sums, mine, num_materials, kMassLeft);
    }
    if (told.end == kEndRested) {
      add_here(sums + count_at(kRested), 1u, 0u);
      bury(sums, item, kMassRested, 0u, num_materials, is_deposited != 0u && trail->num_added != 0u, cargo, ended,
           endings, tally);
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  add_sums(sums, tally);
}

kernel void respond_drops(SCENE_ARRAYS, const MotionCall call, const uint num, global DropRecord* drops, LIFE_ARRAYS) {
  const uint item = (uint)get_global_id(0);
  local uint sums[kGroupSums];
  clear_sums(sums);
  if (item == 0u) {
    tally[kNumPieces + kPhaseOfWays] = 0u;
    tally[kNumPieces + kPhaseOfContacts] = 0u;
    tally[kNumEndings] = 0u;
    tally[kNumCut] = 0u;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item < num && drops[item].state == kIsInContact) {
    SCENE_OF_ARRAYS;
    Drop g = drop_of(drops + item);
    const Vector normal = shading_normal_of(&s, g.at);
    const uint outcome = respond_to(&s, &call, item, &g, normal);
    if (outcome != kStaysAlive) {
      g.state = kIsWaiting;
      const bool is_absorbed = outcome == kIsAbsorbed;
      add_here(sums + count_at(is_absorbed ? kAbsorbed : kRested), 1u, 0u);
      bury(sums, item, is_absorbed ? kMassAbsorbed : kMassRested, 1u, num_materials,
           is_deposited != 0u && trails[item].num_added != 0u, cargo, ended, endings, tally);
    }
    put_drop(&g, drops + item);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  add_sums(sums, tally);
}

// Enters those whose trails were laid after responses.
kernel void end_lives(const uint num, const uint num_materials, global uint* cargo, global uint* ended,
                      global uint* tally) {
  const uint item = (uint)get_global_id(0);
  local uint sums[kGroupSums];
  clear_sums(sums);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item < num && ended[item] != 0u) {
    end_life(sums, cargo + item * num_materials, num_materials, ended[item] - 1u);
    ended[item] = 0u;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  add_sums(sums, tally);
}
