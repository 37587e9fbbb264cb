// The entries of search_kernel.inl. A pass over a set lists the texels whose turn it is; a group of items searches for
// each, an item a candidate; then what was found is taken. No order matters: a set is decided from the state before it.

#define PATINATE_LIST_ITEMS 64  // SearchDevice has these too.
#define PATINATE_SEARCH_ITEMS 32
enum { kSearchItems = PATINATE_SEARCH_ITEMS, kMaxRandom = 64, kTexelsSummed = 64 };

// What the items of a group have together of their texel.
typedef struct SharedSearch {
  KnownNeighbors known;
  FixedPlace leads[kTexelsBeside];
  BegunPlaces begun;
  i32 random_pixels[kMaxRandom];
  i32 sum_of_weights;
  // By item: its best, and which of all candidates that is.
  i64 cost[kSearchItems];
  i32 candidate[kSearchItems];
  FixedPlace place[kSearchItems];
} SharedSearch;

// due: items of the set, in any order; num_due: one number, 0 before.
kernel __attribute__((reqd_work_group_size(PATINATE_LIST_ITEMS, 1, 1))) void list_due(const SearchNumbers numbers,
                                                                                      global const int* triangle,
                                                                                      global const uchar* changed_near,
                                                                                      global uint* num_due,
                                                                                      global uint* due) {
  local uint num, first;
  const uint item = (uint)get_global_id(0), lane = (uint)get_local_id(0);
  if (lane == 0) num = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  uint place = 0;
  bool is_listed = item < numbers.num_items;
  if (is_listed) {
    const long texel = texel_of_item(&numbers, item);
    is_listed = triangle[texel] >= 0 && is_due(changed_near[texel], numbers.turn, numbers.is_whole != 0);
  }
  if (is_listed) place = atomic_inc(&num);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0) first = num > 0 ? atomic_add(num_due, num) : 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (is_listed) due[first + place] = item;
}

// All of a group do the same steps, so that each meets every barrier. found_pixel is -1 where nothing changes.
kernel __attribute__((reqd_work_group_size(PATINATE_SEARCH_ITEMS, 1, 1))) void search_due(
    const SearchNumbers numbers, global const short* appearance, global const ushort* controls,
    global const uchar* is_usable, global const int* similar, global const int* usable, global const int* first_with,
    global const int* grid_cell, global const int* grid_begin, global const int* grid_pixels,
    global const short* weights, global const long* coherence_scales, global const long* control_scales,
    global const uchar* reuse, global const uchar* look, global const int* excess, global const ushort* targets,
    global const int* row, global const ulong* is_stored, global const uint* begin, global const PackedNeighbor* stored,
    global const int* triangle, global const int* steps_of, global const PackedNeighbor* steps,
    global const int* pixels, global const char* beside, global const uint* due, global int* found_pixel,
    global char* found_beside) {
  local SharedSearch shared;
  const ulong index = get_global_id(0) / kSearchItems;
  const i32 lane = (i32)get_local_id(0);
  const long texel = texel_of_item(&numbers, due[index]);
  const NeighborTables tables = {
      numbers.num_neighbors + kTexelsBeside, row, is_stored, begin, stored, triangle, steps_of, steps};
  const SearchPass pass = {
      {appearance, controls, is_usable, similar, numbers.source_width, numbers.source_height},
      {usable, first_with, grid_cell, grid_begin, grid_pixels, numbers.num_usable, numbers.num_controls},
      {weights, coherence_scales, control_scales, numbers.num_neighbors, numbers.radius_px, numbers.num_controls},
      {pixels, beside, numbers.source_width, numbers.shift, numbers.reciprocal},
      {numbers.factors, reuse, look, excess},
      targets,
      numbers.num_random,
      numbers.tolerance};
  TexelSearch search;
  search.target = targets + texel * numbers.num_controls;
  search.best = place_of_texel(&pass.places, texel);
  search.best_cost = kNoCost;
  const FixedPlace current = search.best;
  if (lane < kTexelsBeside)
    shared.leads[lane] = continued_place(&pass, texel, texel_neighbor(&tables, texel, numbers.num_neighbors + lane));
  if (lane == 0) shared.sum_of_weights = 0;
  barrier(CLK_LOCAL_MEM_FENCE);

  if (lane == 0) begin_places(&pass, shared.leads, current, &shared.begun);
  if (lane == kTexelsBeside) {  // Any that has nothing else to do.
    const AlikePixels alike = alike_pixels(&pass.alike, search.target, numbers.tolerance);
    RandomState random = random_state(numbers.seed, (ulong)texel, numbers.stream);
    for (i32 i = 0; i < numbers.num_random; ++i)
      shared.random_pixels[i] = alike.pixels[random_below(&random, (uint)alike.num)];
  }
  barrier(CLK_LOCAL_MEM_FENCE);

  const bool is_searched = shared.begun.is_quiet == 0;
  for (i32 k = lane; is_searched && k < numbers.num_neighbors; k += kSearchItems) {
    if (know_neighbor(&pass.source, &pass.cost, pixels, texel, texel_neighbor(&tables, texel, k), k, k,
                      &shared.known)) {
      atomic_add(&shared.sum_of_weights, (i32)weights[k]);
      continue;
    }
    forget_neighbor(&shared.known, k);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0) {
    shared.known.num = numbers.num_neighbors;
    shared.known.coherence_scale = coherence_scales[shared.sum_of_weights];
  }
  barrier(CLK_LOCAL_MEM_FENCE);

  // Candidates in the CPU's order: each begun place and those that look like it, then the random ones.
  const i32 of_each = 1 + kAlikeCandidates, num_begun = of_each * shared.begun.num;
  const i32 num_candidates = is_searched ? num_begun + numbers.num_random : 0;
  i32 best = num_candidates;
  for (i32 c = lane; c < num_candidates; c += kSearchItems) {
    i32 bonus = numbers.factors.bonus;
    FixedPlace place;
    if (c < num_begun) {
      place = shared.begun.places[c / of_each];
      if (c % of_each == 0) bonus = bonus_of(&pass, &shared.begun, c / of_each);
    }
    const i32 pixel = c >= num_begun     ? shared.random_pixels[c - num_begun]
                      : c % of_each == 0 ? place.pixel
                                         : similar_pixel(&pass, place.pixel, c % of_each - 1);
    if (pixel < 0) continue;
    if (c >= num_begun || c % of_each != 0) place = middle_of(&pass.source, pixel);
    if (try_place(&pass, &shared.known, place, bonus, &search)) best = c;
  }
  shared.cost[lane] = search.best_cost;
  shared.candidate[lane] = best;
  shared.place[lane] = search.best;
  for (i32 apart = kSearchItems / 2; apart > 0; apart /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    const i32 other = lane + apart;
    if (lane < apart &&
        (shared.cost[other] < shared.cost[lane] ||
         (shared.cost[other] == shared.cost[lane] && shared.candidate[other] < shared.candidate[lane]))) {
      shared.cost[lane] = shared.cost[other];
      shared.candidate[lane] = shared.candidate[other];
      shared.place[lane] = shared.place[other];
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane != 0) return;
  const FixedPlace found = is_searched ? shared.place[0] : current;
  const char x = (char)beside_middle(found.x), y = (char)beside_middle(found.y);
  const bool is_same = found.pixel == pixels[texel] && x == beside[2 * texel] && y == beside[2 * texel + 1];
  found_pixel[index] = is_same ? -1 : found.pixel;
  found_beside[2 * index] = x;
  found_beside[2 * index + 1] = y;
}

// Takes what was decided. Several items may mark one texel: all write the same.
kernel void take_due(const SearchNumbers numbers, global const int* row, global const ulong* is_stored,
                     global const uint* begin, global const PackedNeighbor* stored, global const int* triangle,
                     global const int* steps_of, global const PackedNeighbor* steps, global const uint* due,
                     const uint num_due, global const int* found_pixel, global const char* found_beside,
                     global int* pixels, global char* beside, global uchar* changed_near) {
  const ulong index = get_global_id(0);
  if (index >= num_due || found_pixel[index] < 0) return;
  const long texel = texel_of_item(&numbers, due[index]);
  if (found_pixel[index] != pixels[texel]) {
    const NeighborTables tables = {
        numbers.num_neighbors + kTexelsBeside, row, is_stored, begin, stored, triangle, steps_of, steps};
    changed_near[texel] = (uchar)numbers.turn;
    for (int k = 0; k < kTexelsBeside; ++k) {
      const long n = texel_neighbor(&tables, texel, numbers.num_neighbors + k).texel;
      if (n >= 0) changed_near[n] = (uchar)numbers.turn;
    }
  }
  pixels[texel] = found_pixel[index];
  beside[2 * texel] = found_beside[2 * index];
  beside[2 * texel + 1] = found_beside[2 * index + 1];
}

// What the texels of a group cost, one after the other, an item a neighbor: of coherence and of control 2^32 * high +
// low, in this order.
kernel __attribute__((reqd_work_group_size(PATINATE_SEARCH_ITEMS, 1, 1))) void sum_costs(
    const SearchNumbers numbers, global const short* appearance, global const ushort* controls,
    global const uchar* is_usable, global const short* weights, global const long* coherence_scales,
    global const long* control_scales, global const ushort* targets, global const int* row,
    global const ulong* is_stored, global const uint* begin, global const PackedNeighbor* stored,
    global const int* triangle, global const int* steps_of, global const PackedNeighbor* steps,
    global const int* pixels, const ulong num_texels, global long* sums) {
  local KnownNeighbors known;
  local i32 sum_of_weights;
  local i64 squares[kSearchItems];
  const i32 lane = (i32)get_local_id(0);
  const i64 group = (i64)(get_global_id(0) / kSearchItems);
  const NeighborTables tables = {
      numbers.num_neighbors + kTexelsBeside, row, is_stored, begin, stored, triangle, steps_of, steps};
  const SourceTables source = {appearance, controls, is_usable, 0, numbers.source_width, numbers.source_height};
  const CostTables cost = {weights, coherence_scales, control_scales, numbers.num_neighbors, numbers.radius_px,
                           numbers.num_controls};
  i64 coherence_high = 0, coherence_low = 0, control_high = 0, control_low = 0;
  for (i32 i = 0; i < kTexelsSummed; ++i) {
    const i64 texel = group * kTexelsSummed + i;
    const bool is_there = texel < (i64)num_texels && triangle[texel] >= 0;
    if (lane == 0) sum_of_weights = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    i64 own_squares = 0;
    for (i32 k = lane; is_there && k < numbers.num_neighbors; k += kSearchItems) {
      if (!know_neighbor(&source, &cost, pixels, texel, texel_neighbor(&tables, texel, k), k, k, &known)) continue;
      atomic_add(&sum_of_weights, (i32)weights[k]);
      global const short* base = appearance + (i64)pixels[texel] * kComponents;
      own_squares += (i64)squares_of(&known, k, base + known.delta[k]) * known.weight[k];
    }
    squares[lane] = own_squares;
    for (i32 apart = kSearchItems / 2; apart > 0; apart /= 2) {
      barrier(CLK_LOCAL_MEM_FENCE);
      if (lane < apart) squares[lane] += squares[lane + apart];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lane == 0 && is_there) {
      const i64 coherence = squares[0] * coherence_scales[sum_of_weights];
      const i64 control = control_cost(&source, &cost, targets + texel * numbers.num_controls, pixels[texel]);
      coherence_high += coherence >> 32;
      coherence_low += coherence & 0xFFFFFFFFl;
      control_high += control >> 32;
      control_low += control & 0xFFFFFFFFl;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  if (lane != 0) return;
  sums[4 * group] = coherence_high;
  sums[4 * group + 1] = coherence_low;
  sums[4 * group + 2] = control_high;
  sums[4 * group + 3] = control_low;
}
