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

// The k-th neighbor of a texel.
PATINATE_INLINE PixelNeighbor texel_neighbor(const NeighborTables* tables, i64 texel, i32 k) {
  const i32 row = tables->row[texel];
  bool is_stored = false;
  PackedNeighbor n;
  if (row >= 0) {
    PATINATE_GLOBAL const u64* words = tables->is_stored + 2 * (i64)row;
    const u64 word = words[k >> 6], bit = (u64)1u << (k & 63);
    is_stored = (word & bit) != 0u;
    const i32 before = PATINATE_NUM_BITS(word & (bit - 1u)) + (k >= 64 ? PATINATE_NUM_BITS(words[0]) : 0);
    if (is_stored) n = tables->stored[tables->begin[row] + (u32)before];
  }
  if (!is_stored) n = tables->steps[(i64)tables->steps_of[tables->triangle[texel]] * tables->num + k];
  PixelNeighbor neighbor;
  neighbor.texel = n.texel == kNoNeighbor ? -1 : is_stored ? n.texel : texel + n.texel;
  neighbor.x = n.x;
  neighbor.y = n.y;
  return neighbor;
}
