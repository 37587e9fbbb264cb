// Splats on a device: plain ones are laid out by stencils, others by the walk of surface_walk.cpp, whose sums are made in
// the same order. Behind spread_kernel.inl and exchange_types.inl.

// Compilers of processors are to take barriers out of functions; one of them fails where it may choose what to inline.
#define ALL_INLINE static inline __attribute__((always_inline))
// So many items of a group take [0, num) in turns, as many turns for all: one compiler takes the first turn of a loop
// behind a barrier for granted.
#define EACH_IN_TURN(k, num, items) \
  for (uint k##_turn = 0u, k = lane; k##_turn < (num); k##_turn += (items), k = k##_turn + lane) if (k < (num))

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

// Whether a stencil's tiles are all plain.
static inline bool is_plain_there(const SplatSurface* s, uint texel, int reach) {
  const int x = (int)texel_x(s->width, texel), y = (int)texel_y(s->width, texel);
  if (x < reach || y < reach || x + reach >= s->width || y + reach >= s->width) return false;
  for (int ty = (y - reach) / 8; ty <= (y + reach) / 8; ++ty) {
    for (int tx = (x - reach) / 8; tx <= (x + reach) / 8; ++tx) {
      if (s->is_plain[texel_beside(s->width, 0u, 8 * tx, 8 * ty) >> 6] == 0) return false;
    }
  }
  return true;
}

// Sums of the values of all items up to each. @param room  A word for each item; the last has the sum of all.
ALL_INLINE uint sum_up_to(local uint* room, uint value) {
  const uint lane = (uint)get_local_id(0), num = (uint)get_local_size(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  room[lane] = value;
  for (uint apart = 1u; apart < num; apart *= 2u) {
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

