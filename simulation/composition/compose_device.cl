// The entries of compose_kernel.inl: groups of 64 items take tiles in turns, an item a texel. Behind tally.cl.

// Tiles on whose slopes a change of heights tells.
typedef struct StaleTiles {
  global const TileFacts* facts;
  global const uint* dependents;
  global uint* stale_in;  // By tile: the call in which it was listed last.
  global uint* stale;     // Those of this call.
} StaleTiles;

static inline void mark_stale(const StaleTiles* s, uint tile, uint call, global uint* num_stale) {
  if (s->facts[tile].is_covered != 0u && atomic_xchg(s->stale_in + tile, call) != call)
    s->stale[atomic_inc(num_stale)] = tile;
}

// Bits for the edges of a tile that a texel is on: right, left, below, above.
static inline uint edges_of(uint lane) {
  const uint x = lane & 7u, y = lane >> 3;
  return (x == 7u ? 1u : 0u) | (x == 0u ? 2u : 0u) | (y == 7u ? 4u : 0u) | (y == 0u ? 8u : 0u);
}

static inline void mark_slopes(const StaleTiles* s, uint tile, uint edges, uint call, global uint* num_stale) {
  global const TileFacts* of = s->facts + tile;
  mark_stale(s, tile, call, num_stale);
  for (uint k = 0u; k < 4u; ++k) {
    global const TileFacts* beside = s->facts + of->beside[k];
    if ((edges >> k & 1u) != 0u || beside->border_begin != beside->border_end)
      mark_stale(s, of->beside[k], call, num_stale);
  }
  for (uint d = of->dependents_begin; d < of->dependents_end; ++d) mark_stale(s, s->dependents[d], call, num_stale);
}

// grains and pictures: by texel, plane after plane (pictures: three planes of 64 a tile); a layer of
// -1: a material has none. composed_in: by tile, the last call that changed what is seen.
kernel void compose_touched(const ComposeCall call, global const QuantizedAppearance* looks,
                            global const ushort* amounts, global const ushort* originals, global const uchar* grains,
                            global const ushort* pictures, global const BaseTile* bases, global const int* base_heights,
                            global const uchar* srgb, global const TileFacts* facts, global const uint* dependents,
                            global uint* is_listed, global const uint* touched, global uint* stale_in,
                            global uint* stale, global uint* codes, global int* heights, global uint* composed_in,
                            global uint* tally) {
  local uint differing, edges;
  const uint lane = (uint)get_local_id(0), num = tally[kNumTouched];
  const StaleTiles slopes = {facts, dependents, stale_in, stale};
  global uint* num_stale = tally + kNumStale + (call.number & 1u);
  if (get_global_id(0) == 0) tally[kNumStale + (~call.number & 1u)] = 0u;
  for (uint k = (uint)get_group_id(0); k < num; k += (uint)get_num_groups(0)) {
    const uint tile = touched[k];
    const ulong texel = (ulong)tile * 64u + lane;
    global const TileFacts* of = facts + tile;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lane == 0u) {
      is_listed[tile] = 0u;
      differing = 0u;
      edges = 0u;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (of->is_covered == 0u) continue;
    uint mine = 0u;
    for (uint m = 0u; m < call.num_materials; ++m) {
      const ushort amount = amounts[(ulong)m * call.num_texels + texel];
      mine |= (amount != originals[(ulong)(of->originals + (int)m) * 64u + lane] ? 1u : 0u) << m;
    }
    if (mine != 0u) atomic_or(&differing, mine);
    barrier(CLK_LOCAL_MEM_FENCE);
    ComposeTask task;
    task.num_materials = 0;
    for (uint m = 0u; m < call.num_materials; ++m) {
      if ((differing >> m & 1u) == 0u) continue;
      const int at = task.num_materials++;
      task.look[at] = looks + m;
      task.amount[at] = amounts + (ulong)m * call.num_texels + (ulong)tile * 64u;
      task.original[at] = originals + (ulong)(of->originals + (int)m) * 64u;
      task.grain[at] = call.grain_layer[m] < 0 ? 0 : grains + (ulong)call.grain_layer[m] * call.num_texels + tile * 64ul;
      task.picture[at] =
          call.picture_layer[m] < 0 ? 0 : pictures + ((ulong)call.picture_layer[m] * call.num_texels + tile * 64ul) * 3u;
    }
    task.base = bases + of->base;
    task.height = base_heights + (long)of->height * 64;
    task.srgb = srgb;
    task.first_texel = tile * 64u;
    task.form = call.form;
    uint rgba[1];
    int height[1];
    compose_lanes(&task, rgba, height);
    if (task.num_materials == 0) {
      rgba[0] = task.base->code[lane];
      height[0] = task.height[lane];
    }
    if (codes[texel] != rgba[0]) {
      codes[texel] = rgba[0];
      composed_in[tile] = call.number;
    }
    if (call.has_heights == 0u) continue;
    if (heights[texel] != height[0]) {
      heights[texel] = height[0];
      composed_in[tile] = call.number;
      atomic_or(&edges, 16u | edges_of(lane));
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lane == 0u && edges != 0u) mark_slopes(&slopes, tile, edges, call.number, num_stale);
  }
}

kernel void compose_normals(const ComposeCall call, global const TileFacts* facts, global const int* heights,
                            global const int* triangles, global const Frame* frames, global const BorderTexel* border,
                            global const uint* stale, global uchar* normals, global uint* composed_in,
                            global uint* tally) {
  const uint num = tally[kNumStale + (call.number & 1u)], lane = (uint)get_local_id(0);
  const int l = (int)lane, x = l & 7, y = l >> 3;
  if (get_global_id(0) == 0) tally[kNumTouched] = 0u;
  for (uint k = (uint)get_group_id(0); k < num; k += (uint)get_num_groups(0)) {
    const uint tile = stale[k];
    global const TileFacts* of = facts + tile;
    const ulong first = (ulong)tile * 64u;
    const int right = x < 7 ? heights[first + l + 1] : heights[(ulong)of->beside[0] * 64u + l - 7];
    const int left = x > 0 ? heights[first + l - 1] : heights[(ulong)of->beside[1] * 64u + l + 7];
    const int below = y < 7 ? heights[first + l + 8] : heights[(ulong)of->beside[2] * 64u + l - 56];
    const int above = y > 0 ? heights[first + l - 8] : heights[(ulong)of->beside[3] * 64u + l + 56];
    int along_t[1], along_b[1];
    slopes_of_steps(frames[triangles[first + l] + 1], within(right - left, -kMaxStep, kMaxStep),
                    within(below - above, -kMaxStep, kMaxStep), along_t, along_b);
    for (uint b = of->border_begin; b < of->border_end; ++b) {
      if (border[b].texel != first + l) continue;
      along_t[0] = slope_at_border(border + b, border[b].along_t, heights);
      along_b[0] = slope_at_border(border + b, border[b].along_b, heights);
    }
    global uchar* mine = normals + first * 3u;
    const uchar before_x = mine[l], before_y = mine[64 + l], before_z = mine[128 + l];
    encode_lanes(along_t, along_b, mine);
    if (mine[l] != before_x || mine[64 + l] != before_y || mine[128 + l] != before_z) composed_in[tile] = call.number;
  }
}

// Words of tiles, one tile behind the other.
kernel void gather_words(global const uint* tiles, const uint words_each, global const uint* from, global uint* to) {
  const ulong item = get_global_id(0);
  to[item] = from[(ulong)tiles[item / words_each] * words_each + item % words_each];
}
