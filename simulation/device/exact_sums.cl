// Sums of 64 bits in two words: exact in whatever order they are added to.
static inline void add_here(local uint* sum, uint low, uint high) {
  const uint before = atomic_add(sum, low);
  atomic_add(sum + 1, high + (before + low < before ? 1u : 0u));
}
static inline void add_everywhere(global uint* sum, uint low, uint high) {
  const uint before = atomic_add(sum, low);
  atomic_add(sum + 1, high + (before + low < before ? 1u : 0u));
}
