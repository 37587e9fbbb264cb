// The entries of search_kernel.inl: one item a texel of an interleaved set.

// Decides: found_pixel is -1 where nothing changes.
kernel void search_set(const SearchNumbers numbers, global const short* appearance, global const ushort* controls,
                       global const uchar* is_usable, global const int* similar, global const int* usable,
                       global const int* first_with, global const int* grid_cell, global const int* grid_begin,
                       global const int* grid_pixels, global const short* weights, global const long* coherence_scales,
                       global const long* control_scales, global const uchar* reuse, global const uchar* look,
                       global const int* excess, global const ushort* targets, global const int* row,
                       global const ulong* is_stored, global const uint* begin, global const PackedNeighbor* stored,
                       global const int* triangle, global const int* steps_of, global const PackedNeighbor* steps,
                       global const int* pixels, global const char* beside, global const uchar* changed_near,
                       global int* found_pixel, global char* found_beside) {
  const ulong item = get_global_id(0);
  if (item >= numbers.num_items) return;
  const long texel = texel_of_item(&numbers, item);
  found_pixel[item] = -1;
  if (triangle[texel] < 0 || !is_due(changed_near[texel], numbers.turn, numbers.is_whole != 0)) return;
  const NeighborTables tables = {numbers.num_neighbors + kTexelsBeside, row, is_stored, begin, stored, triangle, steps_of, steps};
  PixelNeighbor neighbors[PATINATE_MOST_NEIGHBORS];
  find_texel_neighbors(&tables, texel, neighbors);
  const SearchPass pass = {
      {appearance, controls, is_usable, similar, numbers.source_width, numbers.source_height},
      {usable, first_with, grid_cell, grid_begin, grid_pixels, numbers.num_usable, numbers.num_controls},
      {weights, coherence_scales, control_scales, numbers.num_neighbors, numbers.radius_px, numbers.num_controls},
      {pixels, beside, numbers.source_width, numbers.shift, numbers.reciprocal},
      {numbers.factors, reuse, look, excess},
      targets,
      numbers.num_random,
      numbers.tolerance};
  KnownNeighbors known;
  const FixedPlace best =
      best_place(&pass, texel, neighbors, random_state(numbers.seed, (ulong)texel, numbers.stream), &known);
  const char x = (char)beside_middle(best.x), y = (char)beside_middle(best.y);
  if (best.pixel == pixels[texel] && x == beside[2 * texel] && y == beside[2 * texel + 1]) return;
  found_pixel[item] = best.pixel;
  found_beside[2 * item] = x;
  found_beside[2 * item + 1] = y;
}

// Takes what was decided. Several items may mark one texel: all write the same.
kernel void take_set(const SearchNumbers numbers, global const int* row, global const ulong* is_stored,
                     global const uint* begin, global const PackedNeighbor* stored, global const int* triangle,
                     global const int* steps_of, global const PackedNeighbor* steps, global const int* found_pixel,
                     global const char* found_beside, global int* pixels, global char* beside,
                     global uchar* changed_near) {
  const ulong item = get_global_id(0);
  if (item >= numbers.num_items || found_pixel[item] < 0) return;
  const long texel = texel_of_item(&numbers, item);
  if (found_pixel[item] != pixels[texel]) {
    const NeighborTables tables = {numbers.num_neighbors + kTexelsBeside, row, is_stored, begin, stored, triangle, steps_of, steps};
    PixelNeighbor neighbors[PATINATE_MOST_NEIGHBORS];
    find_texel_neighbors(&tables, texel, neighbors);
    changed_near[texel] = (uchar)numbers.turn;
    for (int k = 0; k < kTexelsBeside; ++k) {
      const long n = neighbors[numbers.num_neighbors + k].texel;
      if (n >= 0) changed_near[n] = (uchar)numbers.turn;
    }
  }
  pixels[texel] = found_pixel[item];
  beside[2 * texel] = found_beside[2 * item];
  beside[2 * texel + 1] = found_beside[2 * item + 1];
}
