// Sums of a group, which are added to those of all once it is done; behind tally_types.inl.

enum { kGroupSums = kTallyWords - kFirstCount };
static inline uint count_at(uint count) { return 2u * count; }
static inline uint mass_at(uint kind, uint material) { return kFirstMass - kFirstCount + 2u * (8u * kind + material); }

static inline void add_here(local uint* sum, uint low, uint high) {
  const uint before = atomic_add(sum, low);
  high += before + low < before ? 1u : 0u;
  if (high != 0u) atomic_add(sum + 1, high);
}
static inline void add_everywhere(global uint* sum, uint low, uint high) {
  const uint before = atomic_add(sum, low);
  high += before + low < before ? 1u : 0u;
  if (high != 0u) atomic_add(sum + 1, high);
}

// By all items of a group, before and after they add: barriers stand in between.
static inline void clear_sums(local uint* sums) {
  for (uint k = (uint)get_local_id(0); k < kGroupSums; k += (uint)get_local_size(0)) sums[k] = 0u;
}
static inline void add_sums(local const uint* sums, global uint* tally) {
  for (uint k = (uint)get_local_id(0); k < kGroupSums / 2; k += (uint)get_local_size(0)) {
    if ((sums[2u * k] | sums[2u * k + 1u]) != 0u)
      add_everywhere(tally + kFirstCount + 2u * k, sums[2u * k], sums[2u * k + 1u]);
  }
}

// Tiles whose amounts a kernel has changed.
typedef struct Tiles {
  global uint* dirty;      // By tile: a bit for each material that has changed since the host was told.
  global int* changed_in;  // By tile: the last iteration.
  global uint* awake;      // By tile: rules may have something to do.
  global uint* is_listed;  // By tile: whether it is among those to be composed,
  global uint* touched;    // which are these.
} Tiles;
#define TILE_ARRAYS                                                                               \
  global uint *dirty, global int *changed_in, global uint *awake, global uint *is_listed, \
      global uint *touched

static inline void mark_tile(const Tiles* tiles, uint tile, uint materials, int iteration, global uint* tally) {
  atomic_or(tiles->dirty + tile, materials);
  tiles->changed_in[tile] = iteration;
  tiles->awake[tile] = 1u;
  if (tiles->is_listed[tile] == 0u && atomic_xchg(tiles->is_listed + tile, 1u) == 0u)
    tiles->touched[atomic_inc(tally + kNumTouched)] = tile;
}
