// The entries of the exact search, behind window_group.cl: audits, and fronts of the reference synthesis.

// The texel of `item` that is drawn: what its own pixel costs, and the least that there is. Its neighbors are listed by
// texels of their own, so that nothing but what it sees is there.
kernel __attribute__((reqd_work_group_size(PATINATE_WINDOW_ITEMS, 1, 1))) void audit_texels(
    const WindowNumbers numbers, global const short* appearance, global const ushort* controls,
    global const uchar* is_usable, global const short* weights, global const long* coherence_scales,
    global const long* control_scales, global const short* offsets, global const uchar* quarter,
    global const ushort* first_controls, global const short* whole, global const short* quarters,
    global const short* whole_rows, global const short* quarter_rows, global const PackedNeighbor* neighbors,
    global const int* coordinates, global const int* own_pixels, global const ushort* targets, global long* own_costs,
    global long* least_costs) {
  local SharedWindow shared;
  const i32 lane = (i32)get_local_id(0), of_each = numbers.num_neighbors + kTexelsBeside;
  const i64 item = (i64)numbers.first + (i64)get_group_id(0), kNoTexel = -2;
  const WindowTables tables = {
      {appearance, controls, is_usable, 0, numbers.source_width, numbers.source_height},
      {weights, coherence_scales, control_scales, numbers.num_neighbors, numbers.radius_px, numbers.num_controls},
      offsets,
      quarter,
      first_controls,
      {whole, quarters},
      {whole_rows, quarter_rows}};
  global const ushort* target = targets + item * numbers.num_controls;
  clear_shared(&shared, lane);
  for (i32 k = lane; k < of_each; k += kItems) {
    const PackedNeighbor packed = neighbors[item * of_each + k];
    PixelNeighbor n;
    n.texel = packed.texel;
    n.x = packed.x;
    n.y = packed.y;
    if (k < numbers.num_neighbors) {
      take_neighbor(&tables, coordinates, kNoTexel, n, k, &shared);
    } else {
      shared.leads[k - numbers.num_neighbors].pixel =
          has_place(coordinates, n) ? led_pixel(&tables.source, coordinates[n.texel], n) : -1;
    }
  }
  const i32 own = own_pixels[item];
  if (lane == 0) shared.leads[kTexelsBeside].pixel = own;
  begin_search(&tables, target, &shared, lane);
  SearchWindow window;
  window.x0 = 0;
  window.y0 = 0;
  window.x1 = numbers.source_width;
  window.y1 = numbers.source_height;
  queue_leads(&tables, &shared, kTexelsBeside + 1, window, lane);
  ItemBest best = {kNoCost, kNoLimit};
  scan_window(&tables, target, &shared, window, kFindBest, 0.0, &best, lane);
  find_least(&shared, lane, best.cost, best.pixel);
  if (lane != 0) return;
  own_costs[item] = cost_of_pixel(&tables.source, &tables.cost, target, &shared.known, own, kNoCost);
  least_costs[item] = shared.cost[0];
}

// The middle of the window: of some pixels of similar control value the one nearest to where the known neighbors would
// put the texel. Items draw the random words of their tries by themselves; where one is rejected, which is rare, all
// are drawn one after the other. @returns a pixel.
WINDOW_INLINE i32 find_center(const WindowNumbers* numbers, AlikePixels alike, i64 texel, local SharedWindow* shared,
                              i32 lane) {
  const bool has_mean = shared->mean_weights > 0;
  const i32 num_tries = has_mean ? kWindowTries : 1;
  for (i32 i = lane; i < num_tries; i += kItems) {
    RandomState random = random_state_after(numbers->seed, (u64)texel, numbers->stream, (u32)i);
    const i64 value = word_below(random_next(&random), (u32)alike.num);
    if (value < 0) atomic_inc(&shared->num_rejected);
    shared->tried[i] = value < 0 ? -1 : alike.pixels[value];
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0) {
    shared->num_words = num_tries;
    if (shared->num_rejected > 0) {
      RandomState random = random_state(numbers->seed, (u64)texel, numbers->stream);
      for (i32 i = 0; i < num_tries; ++i) shared->tried[i] = alike.pixels[random_below(&random, (u32)alike.num)];
      shared->num_words = (i32)random_words_used(&random);
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  i64 x = 0, y = 0;
  if (has_mean) {
    x = mean_place(((i64)shared->mean_high[0] << kHalfBits) + shared->mean_low[0], shared->mean_weights);
    y = mean_place(((i64)shared->mean_high[1] << kHalfBits) + shared->mean_low[1], shared->mean_weights);
  }
  i64 least = kNoCost;
  i32 first = kNoLimit;
  for (i32 i = lane; i < num_tries; i += kItems) {
    const i64 apart = squared_apart(shared->tried[i], numbers->source_width, x, y);
    if (apart >= least) continue;
    least = apart;
    first = i;
  }
  find_least(shared, lane, least, first);
  return shared->tried[shared->rank[0]];
}

// Where leads lie beside the middle of their pixel, what they cost there, if that is at most shared->bound.
WINDOW_INLINE void cost_leads(const WindowTables* tables, global const ushort* target, local SharedWindow* shared,
                              i32 num_leads, i32 lane) {
  for (i32 i = lane; i < num_leads; i += kItems) {
    const FixedPlace lead = shared->leads[i];
    const i32 x = beside_middle(lead.x), y = beside_middle(lead.y);
    i64 cost = kNoCost;
    if (lead.pixel >= 0 && (x != 0 || y != 0))
      cost = cost_beside(&tables->source, &tables->cost, target, &shared->known, lead.pixel, x, y, shared->bound + 1);
    shared->lead_costs[i] = cost <= shared->bound ? cost : kNoCost;
  }
}

// A texel takes one of all that cost at most 1 + epsilon of the least, by chance: pixels of the window, and places of
// pieces that go on. This is the bound of what pixels may cost then.
WINDOW_INLINE void bound_good(const WindowTables* tables, const WindowNumbers* numbers, local SharedWindow* shared,
                              i32 num_leads) {
  i64 least = shared->best_cost;
  for (i32 i = 0; i < num_leads; ++i) least = at_most(least, shared->lead_costs[i]);
  shared->bound = loosened_cost(least, numbers->epsilon);
  shared->limit = limit_of(tables, shared, shared->bound);
}

// Of what was found within the bound: a place that goes on comes to `taken`; a pixel is the best one, or one of the
// hits before which `num_before` come, or none yet (-1).
WINDOW_INLINE void choose_good(const WindowNumbers* numbers, i64 texel, local SharedWindow* shared, i32 num_leads) {
  i32 num_going_on = 0;
  for (i32 i = 0; i < num_leads; ++i) num_going_on += shared->lead_costs[i] <= shared->bound ? 1 : 0;
  const bool takes_any = numbers->epsilon > 0.0;
  const i32 num_pixels = takes_any ? shared->num_hits : num_going_on == 0 ? 1 : 0, num = num_pixels + num_going_on;
  RandomState random = random_state_after(numbers->seed, (u64)texel, numbers->stream, (u32)shared->num_words);
  const i32 chosen = (i32)random_below(&random, num > 0 ? (u32)num : 1u);
  shared->chosen = shared->best_pixel;
  shared->num_before = takes_any && chosen < num_pixels ? chosen : -1;
  i32 before = chosen - num_pixels;
  for (i32 i = 0; before >= 0 && i < num_leads; ++i) {
    if (shared->lead_costs[i] > shared->bound) continue;
    if (before == 0) shared->taken = shared->leads[i];
    --before;
  }
}

// Finds what a texel takes, as reference.cpp does: the best pixel and all that are nearly as good. Where more of those
// were hit than there is room for, the window is looked at again: how many there are, and which one chance chose.
WINDOW_INLINE void find_place(const WindowTables* tables, const WindowNumbers* numbers, i64 texel,
                              global const ushort* target, local SharedWindow* shared, i32 num_leads,
                              SearchWindow window, i32 lane) {
  ItemBest best = {kNoCost, kNoLimit};
  queue_leads(tables, shared, num_leads, window, lane);
  for (i32 what = kFindBest; what <= kFindChosen; ++what) {
    const bool is_found = shared->best_pixel != kNoLimit;
    if (lane == 0 && is_found && what == kCountWithin)
      shared->bound = loosened_cost(shared->best_cost, numbers->epsilon);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (is_found && what == kCountWithin) cost_leads(tables, target, shared, num_leads, lane);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lane == 0 && is_found && what == kCountWithin) bound_good(tables, numbers, shared, num_leads);
    if (lane == 0 && is_found && what == kFindChosen) choose_good(numbers, texel, shared, num_leads);
    barrier(CLK_LOCAL_MEM_FENCE);
    const bool is_chosen = what == kFindChosen && is_found && shared->num_before >= 0;
    const bool are_kept = shared->num_hits <= kMostQueued;
    if (is_chosen && are_kept) choose_hit(shared, shared->num_before, lane);
    drop_costly_hits(shared, what == kCountWithin, lane);
    if (lane == 0 && what == kFindChosen) shared->num_hits = 0;
    const bool is_searched =
        what == kFindBest || (what == kCountWithin && is_found && !are_kept) || (is_chosen && !are_kept);
    SearchWindow searched = window;
    if (!is_searched) searched.y1 = searched.y0;
    barrier(CLK_LOCAL_MEM_FENCE);
    scan_window(tables, target, shared, searched, what, numbers->epsilon, &best, lane);
    find_least(shared, lane, best.cost, best.pixel);
    if (lane == 0) {
      shared->best_cost = shared->cost[0];
      shared->best_pixel = shared->rank[0];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  // A piece that goes on keeps its fractions.
  for (i32 i = lane; i < num_leads; i += kItems) {
    if (shared->leads[i].pixel == shared->chosen) atomic_min(&shared->same_lead, i);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0 && shared->taken.pixel < 0 && shared->chosen >= 0)
    shared->taken =
        shared->same_lead != kNoLimit ? shared->leads[shared->same_lead] : middle_of(&tables->source, shared->chosen);
}

// A texel of a front gets its place (reference.h). No texel of a front sees another.
kernel __attribute__((reqd_work_group_size(PATINATE_WINDOW_ITEMS, 1, 1))) void place_front(
    const WindowNumbers numbers, global const short* appearance, global const ushort* controls,
    global const uchar* is_usable, global const short* weights, global const long* coherence_scales,
    global const long* control_scales, global const short* offsets, global const uchar* quarter,
    global const ushort* first_controls, global const short* whole, global const short* quarters,
    global const short* whole_rows, global const short* quarter_rows, global const int* usable,
    global const int* first_with, global const int* grid_cell, global const int* grid_begin,
    global const int* grid_pixels, global const ushort* targets, global const int* row, global const ulong* is_stored,
    global const uint* begin, global const PackedNeighbor* stored, global const int* triangle,
    global const int* steps_of, global const PackedNeighbor* steps, global const uint* texels, global int* pixels,
    global char* beside) {
  local SharedWindow shared;
  const i32 lane = (i32)get_local_id(0), num_leads = numbers.num_neighbors + 1;
  const i64 texel = texels[(i64)numbers.first + (i64)get_group_id(0)];
  const WindowTables tables = {
      {appearance, controls, is_usable, 0, numbers.source_width, numbers.source_height},
      {weights, coherence_scales, control_scales, numbers.num_neighbors, numbers.radius_px, numbers.num_controls},
      offsets,
      quarter,
      first_controls,
      {whole, quarters},
      {whole_rows, quarter_rows}};
  const NeighborTables neighbors = {
      numbers.num_neighbors + kTexelsBeside, row, is_stored, begin, stored, triangle, steps_of, steps};
  const PlaceTables places = {pixels, beside, numbers.source_width, numbers.shift, numbers.reciprocal};
  const AlikeTables alike = {usable,      first_with,         grid_cell,           grid_begin,
                             grid_pixels, numbers.num_usable, numbers.num_controls};
  global const ushort* target = targets + texel * numbers.num_controls;
  clear_shared(&shared, lane);
  for (i32 k = lane; k < numbers.num_neighbors; k += kItems) {
    const PixelNeighbor n = texel_neighbor(&neighbors, texel, k);
    take_neighbor(&tables, pixels, texel, n, k, &shared);
    take_lead(&tables, &places, n, k, &shared);
  }
  if (lane == 0) {
    shared.leads[0].pixel = -1;
    if (pixels[texel] >= 0) shared.leads[0] = place_of_texel(&places, texel);
  }
  begin_search(&tables, target, &shared, lane);
  drop_repeated_leads(num_leads, &shared, lane);
  const i32 center = find_center(&numbers, alike_pixels(&alike, target, numbers.tolerance), texel, &shared, lane);
  const SearchWindow window = window_around(center % numbers.source_width, center / numbers.source_width,
                                            numbers.window_px, numbers.source_width, numbers.source_height);
  find_place(&tables, &numbers, texel, target, &shared, num_leads, window, lane);
  if (lane != 0 || shared.taken.pixel < 0) return;
  pixels[texel] = shared.taken.pixel;
  beside[2 * texel] = (char)beside_middle(shared.taken.x);
  beside[2 * texel + 1] = (char)beside_middle(shared.taken.y);
}
