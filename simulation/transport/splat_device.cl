// Splats and trails on a device, laid out by groups of items: plain ones from their stencils, others by the walk of
// surface_walk.cpp, whose sums are made in the same order. Behind spread_kernel.inl and exchange_types.inl.

// Compilers of processors are to take barriers out of functions; one of them fails where it may choose what to inline.
#define ALL_INLINE static inline __attribute__((always_inline))
#define PATINATE_LAY_ITEMS 32
// Items of a group take [0, num) in turns, as many turns for all: one compiler takes the first turn of a loop behind a
// barrier for granted.
#define EACH_IN_TURN(k, num) \
  for (uint k##_turn = 0u, k = lane; k##_turn < (num); k##_turn += kLayItems, k = k##_turn + lane) if (k < (num))
enum { kLayItems = PATINATE_LAY_ITEMS, kWalkSlots = 2048, kNoEdge = 0xFFFF };

typedef struct SplatSurface {
  int width;  // Of the atlas.
  uint most_links;
  global const ushort* weights;           // By texel.
  global const int* triangles;            // By texel.
  global const ushort* triangle_weights;  // By triangle.
  global const uchar* is_plain;           // By tile.
  global const uint* linked;              // SurfaceAtlas's.
  global const uint* first_linked;
  global const uint* first_link;
  global const SurfaceLink* links;
  global const StencilFacts* stencils;  // By size.
  global const StencilPart* parts;
} SplatSurface;
#define SPLAT_ARRAYS                                                                                                   \
  global const ushort *weights, global const int *triangles, global const ushort *triangle_weights,                   \
      global const uchar *is_plain, global const uint *linked, global const uint *first_linked,                       \
      global const uint *first_link, global const SurfaceLink *links, global const StencilFacts *stencils,            \
      global const StencilPart *stencil_parts
#define SPLAT_SURFACE_OF_ARRAYS                                                                                     \
  const SplatSurface surface = {call.atlas_width, call.most_links, weights,    triangles, triangle_weights, is_plain, \
                                linked,           first_linked,    first_link, links,     stencils,         stencil_parts}

ALL_INLINE uint texel_x(int width, uint texel) {
  return (texel >> 12) % (uint)((width + 63) / 64) << 6 | (texel >> 6 & 7u) << 3 | (texel & 7u);
}
ALL_INLINE uint texel_y(int width, uint texel) {
  return (texel >> 12) / (uint)((width + 63) / 64) << 6 | (texel >> 9 & 7u) << 3 | (texel >> 3 & 7u);
}
ALL_INLINE uint texel_beside(int width, uint texel, int dx, int dy) {
  const uint x = texel_x(width, texel) + (uint)dx, y = texel_y(width, texel) + (uint)dy;
  const uint page = (y >> 6) * (uint)((width + 63) / 64) + (x >> 6);
  return page << 12 | (y >> 3 & 7u) << 9 | (x >> 3 & 7u) << 6 | (y & 7u) << 3 | (x & 7u);
}

ALL_INLINE int size_there(const SplatSurface* s, double width, uint texel) {
  return width > 0.0 ? splat_variance(width, s->triangle_weights[s->triangles[texel]]) : 0;
}

// Whether a stencil's tiles are all plain, said by all items of a group. @param flag  The group's.
ALL_INLINE bool is_plain_there(const SplatSurface* s, uint texel, int reach, local uint* flag) {
  const int x = (int)texel_x(s->width, texel), y = (int)texel_y(s->width, texel);
  const uint lane = (uint)get_local_id(0);
  const bool is_inside = x >= reach && y >= reach && x + reach < s->width && y + reach < s->width;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u) *flag = is_inside ? 1u : 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  const int left = (x - reach) / 8, across = (x + reach) / 8 - left + 1, top = (y - reach) / 8,
            down = (y + reach) / 8 - top + 1;
  const uint num = is_inside ? (uint)(across * down) : 0u;
  EACH_IN_TURN(k, num) {
    const uint there = texel_beside(s->width, 0u, 8 * (left + (int)k % across), 8 * (top + (int)k / across));
    if (s->is_plain[there >> 6] == 0) *flag = 0u;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  return *flag != 0u;
}

// Sums of the values of all items up to each.
ALL_INLINE uint sum_up_to(local uint* room, uint value) {
  const uint lane = (uint)get_local_id(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  room[lane] = value;
  for (uint apart = 1u; apart < kLayItems; apart *= 2u) {
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint more = lane >= apart ? room[lane - apart] : 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    room[lane] += more;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  return room[lane];
}

ALL_INLINE uint stencil_share(const SplatSurface* s, uint texel, uint weight, uint part, uint* there) {
  global const StencilPart* of = s->parts + part;
  *there = texel_beside(s->width, texel, of->x, of->y);
  return balanced_share(of->share, weight, s->weights[*there]);
}

// Texels around one by their distance in links, and the links between them, by target too.
typedef struct LocalWalk {
  double share[720], next[720];
  uint texel[720];
  ushort slots[kWalkSlots];  // Node + 1.
  ushort first_edge[721];
  ushort first_in[720], last_in[720];  // Edges that lead to a node,
  ushort next_in[6 * 720];             // one behind the other,
  ushort source[6 * 720];              // and where they come from.
  uint level_end[24];
  uint num_nodes, num_edges, num_levels, num_parts;
  double sum;
} LocalWalk;

ALL_INLINE uint walk_slot(uint texel) { return (texel * 0x9E3779B1u >> 16) % kWalkSlots; }
// kWalkTexels where it is not among them, and is not made or has no room.
ALL_INLINE uint walk_node(local LocalWalk* w, uint texel, bool is_made) {
  uint s = walk_slot(texel);
  for (; w->slots[s] != 0; s = (s + 1u) % kWalkSlots) {
    if (w->texel[w->slots[s] - 1] == texel) return w->slots[s] - 1u;
  }
  if (!is_made || w->num_nodes == kWalkTexels) return kWalkTexels;
  const uint node = w->num_nodes++;
  w->texel[node] = texel;
  w->slots[s] = (ushort)(node + 1u);
  w->first_in[node] = kNoEdge;
  w->last_in[node] = kNoEdge;
  return node;
}

// The links of a texel, and what flows over each. @returns how many.
ALL_INLINE uint links_there(const SplatSurface* s, uint texel, double share, global uint* to, global double* flow) {
  const uint tile = texel >> 6;
  uint begin = s->first_linked[tile], end = s->first_linked[tile + 1u];
  const uint last = end;
  while (begin < end) {
    const uint middle = (begin + end) / 2u;
    if (s->linked[middle] < texel)
      begin = middle + 1u;
    else
      end = middle;
  }
  const bool is_linked = begin < last && s->linked[begin] == texel;
  const uint num = is_linked ? s->first_link[begin + 1u] - s->first_link[begin] : 4u;
  const uint weight = s->weights[texel], whole = s->triangle_weights[s->triangles[texel]];
  for (uint k = 0u; k < num; ++k) {
    uint there, count = 2u;
    if (is_linked) {
      there = s->links[s->first_link[begin] + k].texel;
      count = s->links[s->first_link[begin] + k].count;
    } else {
      there = texel_beside(s->width, texel, k == 0u ? 1 : k == 1u ? -1 : 0, k == 2u ? 1 : k == 3u ? -1 : 0);
    }
    to[k] = there;
    flow[k] = share * link_flow(weight, s->weights[there], whole + s->triangle_weights[s->triangles[there]], count);
  }
  return num;
}

// Finds the texels and edges of a walk. num_links, to, flow: of the texels that items look at, most_links each.
ALL_INLINE void lay_walk(const SplatSurface* s, uint middle, int depth, WalkLength length, local LocalWalk* w,
                            local uint* num_links, global uint* to, global double* flow, global WalkRoom* room) {
  const uint lane = (uint)get_local_id(0);
  EACH_IN_TURN(k, (uint)kWalkSlots) w->slots[k] = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u) {
    w->num_nodes = 0u;
    w->num_edges = 0u;
    w->num_levels = 0u;
    (void)walk_node(w, middle, true);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  uint begin = 0u;
  for (int d = 0; d <= depth; ++d) {
    const uint end = w->num_nodes;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lane == 0u) w->level_end[w->num_levels++] = end;
    if (d >= length.num_steps) {
      if (lane == 0u) w->first_edge[begin] = (ushort)w->num_edges;
      break;
    }
    for (uint first = begin; first < end; first += kLayItems) {
      if (first + lane < end)
        num_links[lane] = links_there(s, w->texel[first + lane], length.share, to + lane * s->most_links,
                                      flow + lane * s->most_links);
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
      const uint num_here = lane == 0u ? min((uint)kLayItems, end - first) : 0u;
      for (uint k = 0u; k < kLayItems; ++k) {
        if (k >= num_here) break;
        w->first_edge[first + k] = (ushort)w->num_edges;
        for (uint l = 0u; l < num_links[k]; ++l) {
          const uint node = walk_node(w, to[k * s->most_links + l], d < depth);
          if (node >= kWalkTexels || w->num_edges >= kWalkEdges) continue;
          const uint edge = w->num_edges++;
          room->flow[edge] = flow[k * s->most_links + l];
          w->source[edge] = (ushort)(first + k);
          w->next_in[edge] = kNoEdge;
          if (w->last_in[node] == kNoEdge)
            w->first_in[node] = (ushort)edge;
          else
            w->next_in[w->last_in[node]] = (ushort)edge;
          w->last_in[node] = (ushort)edge;
        }
      }
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    }
    begin = end;
  }
  if (lane == 0u) w->first_edge[w->num_nodes] = (ushort)w->num_edges;
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

// One step: what comes to a node and what leaves it, in the order in which nodes send.
ALL_INLINE void step_walk(local LocalWalk* w, global WalkRoom* room, uint there, uint reached) {
  const uint lane = (uint)get_local_id(0);
  EACH_IN_TURN(i, there) {
    const double all = w->share[i];
    double stays = all;
    for (uint e = w->first_edge[i]; e < w->first_edge[i + 1u]; ++e) {
      const double wished = all * room->flow[e], goes = wished < stays ? wished : stays;
      stays -= goes;
      room->goes[e] = goes;
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  EACH_IN_TURN(j, reached) {
    double value = w->share[j];
    bool has_sent = j >= there;
    for (uint e = w->first_in[j];; e = w->next_in[e]) {
      const bool is_end = e == kNoEdge || w->source[e] >= there;
      if (!has_sent && (is_end || w->source[e] > j)) {
        for (uint own = w->first_edge[j]; own < w->first_edge[j + 1u]; ++own) value -= room->goes[own];
        has_sent = true;
      }
      if (is_end) break;
      value += room->goes[e];
    }
    w->next[j] = value;
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  EACH_IN_TURN(j, reached) w->share[j] = w->next[j];
  barrier(CLK_LOCAL_MEM_FENCE);
}

// walk_surface(): parts into the room. @returns how many, the middle first.
ALL_INLINE uint walk_there(const SplatSurface* s, uint middle, int size, local LocalWalk* w, local uint* num_links,
                              global uint* to, global double* flow, global WalkRoom* room) {
  const uint lane = (uint)get_local_id(0);
  const WalkLength length = walk_length(size);
  const double least = least_of_walk(length.num_steps), weight = (double)s->weights[middle];
  lay_walk(s, middle, walk_depth(size, length.num_steps), length, w, num_links, to, flow, room);
  const uint num = w->num_nodes, last_level = w->num_levels - 1u;
  EACH_IN_TURN(i, num) w->share[i] = i == 0u ? 1.0 : 0.0;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint step = 0u; step < (uint)length.num_steps; ++step)
    step_walk(w, room, w->level_end[min(step, last_level)], w->level_end[min(step + 1u, last_level)]);
  EACH_IN_TURN(i, num) {
    const bool is = i == 0u || is_counted(w->share[i], weight, least, w->share[0], s->weights[w->texel[i]]);
    w->next[i] = is ? w->share[i] : 0.0;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u) {
    double sum = 0.0;
    for (uint i = 0u; i < num; ++i) sum += w->next[i];
    w->sum = sum;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  EACH_IN_TURN(i, num) {
    const bool is = i == 0u || is_counted(w->share[i], weight, least, w->share[0], s->weights[w->texel[i]]);
    w->next[i] = is ? (double)whole_share(w->share[i], w->sum) : 0.0;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u) {
    uint rest = kWholeSplat, parts = 1u;
    for (uint i = 1u; i < num; ++i) {
      const uint whole = (uint)w->next[i];
      if (whole == 0u) continue;
      room->part_texel[parts] = w->texel[i];
      room->part_share[parts++] = whole;
      rest -= whole;
    }
    room->part_texel[0] = middle;
    room->part_share[0] = rest;
    w->num_parts = parts;
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  return w->num_parts;
}
