// The neighbors of a texel from flat tables (texel_neighborhood.h), in the dialect of kernel_language.inl.

#ifdef __OPENCL_VERSION__
// patinate::PixelNeighbor.
typedef struct PixelNeighbor {
  i64 texel;
  i16 x, y;
} PixelNeighbor;
PATINATE_INLINE i32 whole_pixels(i32 fixed) { return (fixed + 128) >> 8; }
#endif

// A neighbor, or a step to one: `texel` is then how far on it is.
typedef struct PackedNeighbor {
  i32 texel;
  i16 x, y;
} PackedNeighbor;

enum { kNoNeighbor = -2147483647 };  // In place of a texel or a step.

// `num` neighbors of each texel; the last eight are those beside it.
typedef struct NeighborTables {
  i32 num;
  PATINATE_GLOBAL const i32* row;        // By texel: what is stored of it; -1 = nothing.
  PATINATE_GLOBAL const u64* is_stored;  // By row, two words: which neighbors are.
  PATINATE_GLOBAL const u32* begin;      // By row: the first of them in `stored`.
  PATINATE_GLOBAL const PackedNeighbor* stored;
  PATINATE_GLOBAL const i32* triangle;  // By texel.
  PATINATE_GLOBAL const i32* steps_of;  // By triangle: where its steps begin, over `num`.
  PATINATE_GLOBAL const PackedNeighbor* steps;
} NeighborTables;

PATINATE_INLINE void find_texel_neighbors(const NeighborTables* tables, i64 texel, PixelNeighbor* out) {
  const i32 row = tables->row[texel], num = tables->num;
  PATINATE_GLOBAL const PackedNeighbor* steps = tables->steps + (i64)tables->steps_of[tables->triangle[texel]] * num;
  u32 next = row >= 0 ? tables->begin[row] : 0u;
  for (i32 k = 0; k < num; ++k) {
    const bool is_stored = row >= 0 && (tables->is_stored[2 * (i64)row + (k >> 6)] >> (k & 63) & 1u) != 0u;
    const PackedNeighbor n = is_stored ? tables->stored[next] : steps[k];
    out[k].texel = n.texel == kNoNeighbor ? -1 : is_stored ? n.texel : texel + n.texel;
    out[k].x = n.x;
    out[k].y = n.y;
    next += is_stored ? 1u : 0u;
  }
}
