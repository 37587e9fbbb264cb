// How a group of items searches a texel's window, behind window_kernel.inl. Its items look at the window's pixels in
// turn; those that may cost little enough wait in a queue until there is one for each item.

// Calls would put structs that are passed by address into memory.
#define WINDOW_INLINE static inline __attribute__((always_inline))

enum {
  kItems = PATINATE_WINDOW_ITEMS,
  kPixelsEach = 4,  // Between two looks at the queue,
  kMostQueued = (kPixelsEach + 1) * kItems,
  kMostLeads = PATINATE_MOST_NEIGHBORS + 1,
  kHalfBits = 12,  // Of the lower of two words that a sum of places is in.
  kCeilingBits = 20,
  kNoLimit = 0x7FFFFFFF
};

// What the items of a group have together of their texel.
typedef struct SharedWindow {
  KnownNeighbors known;
  i32 num_known, sum_of_weights;
  i32 num_in_place[kNeighborhoodQuarters];
  FixedPlace leads[kMostLeads];  // Places that may be good; pixel -1 = none.
  i64 lead_costs[kMostLeads];
  i32 mean_weights, mean_high[2], mean_low[2];
  i32 tried[kWindowTries], num_rejected, num_words;
  u32 quarters;  // Whose projections are compared; 0: controls are.
  i32 sums[kProjectedValues];
  i16 query[kProjectedValues];
  ProjectionReach reach;
  i32 limit;    // Of squared distances: of projections, or of controls; kNoLimit = none.
  i32 ceiling;  // Costs over 2^kCeilingBits that are low enough; kNoLimit = all.
  i32 num_queued, queue[kMostQueued];
  i32 num_hits, hits[kMostQueued];
  i64 hit_costs[kMostQueued];
  i32 num_before, chosen, same_lead;
  i64 best_cost, bound;
  i32 best_pixel;
  FixedPlace taken;
  i64 cost[kItems];
  i32 rank[kItems];
} SharedWindow;

// What all searches of a source read.
typedef struct WindowTables {
  SourceTables source;
  CostTables cost;
  global const short* offsets;  // x, y by neighbor, and
  global const uchar* quarter;  // its quarter.
  global const ushort* first_controls;
  global const short* projections[2];  // By pixel: whole, by quarters.
  global const short* rows[2];         // Of projections: kProjectedValues by value of the list of appearances.
} WindowTables;

WINDOW_INLINE void clear_shared(local SharedWindow* shared, i32 lane) {
  if (lane < kProjectedValues) shared->sums[lane] = 0;
  if (lane == 0) {
    shared->num_known = 0;
    shared->sum_of_weights = 0;
    for (i32 q = 0; q < kNeighborhoodQuarters; ++q) shared->num_in_place[q] = 0;
    shared->mean_weights = 0;
    for (i32 i = 0; i < 2; ++i) {
      shared->mean_high[i] = 0;
      shared->mean_low[i] = 0;
    }
    shared->num_rejected = 0;
    shared->limit = kNoLimit;
    shared->ceiling = kNoLimit;
    shared->num_queued = 0;
    shared->num_hits = 0;
    shared->num_before = -1;
    shared->chosen = -1;
    shared->taken.pixel = -1;
    shared->best_pixel = kNoLimit;
    shared->same_lead = kNoLimit;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// The k-th neighbor is compared.
WINDOW_INLINE void take_neighbor(const WindowTables* tables, global const int* coordinates, i64 texel, PixelNeighbor n,
                                 i32 k, local SharedWindow* shared) {
  if (!know_neighbor(&tables->source, &tables->cost, coordinates, texel, n, k, k, &shared->known)) {
    forget_neighbor(&shared->known, k);
    return;
  }
  atomic_inc(&shared->num_known);
  atomic_add(&shared->sum_of_weights, (i32)tables->cost.weights[k]);
  if (lies_at(n, tables->offsets[2 * k], tables->offsets[2 * k + 1]))
    atomic_inc(&shared->num_in_place[tables->quarter[k]]);
}

// Sums of weight * place are below 2^41: two words of each, whose order does not matter.
WINDOW_INLINE void add_to_mean(i32 weight, i32 place, i32 axis, local SharedWindow* shared) {
  atomic_add(&shared->mean_high[axis], weight * (place >> kHalfBits));
  atomic_add(&shared->mean_low[axis], weight * (place & ((1 << kHalfBits) - 1)));
}

// Where the k-th neighbor leads, and what it adds to the mean of where it would put the texel.
WINDOW_INLINE void take_lead(const WindowTables* tables, const PlaceTables* places, PixelNeighbor n, i32 k,
                             local SharedWindow* shared) {
  local FixedPlace* lead = &shared->leads[k + 1];
  lead->pixel = -1;
  if (!has_place(places->pixels, n)) return;
  const FixedPlace place = led_place(&tables->source, places, n);
  *lead = place;
  const i32 weight = tables->cost.weights[k];
  atomic_add(&shared->mean_weights, weight);
  add_to_mean(weight, place.x, 0, shared);
  add_to_mean(weight, place.y, 1, shared);
}

// Of each pixel the first.
WINDOW_INLINE void drop_repeated_leads(i32 num_leads, local SharedWindow* shared, i32 lane) {
  for (i32 i = lane; i < num_leads; i += kItems) {
    i64 is_repeated = 0;
    for (i32 j = 0; j < i; ++j) is_repeated |= shared->leads[j].pixel == shared->leads[i].pixel ? 1 : 0;
    shared->lead_costs[i] = is_repeated;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (i32 i = lane; i < num_leads; i += kItems) {
    if (shared->lead_costs[i] != 0) shared->leads[i].pixel = -1;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// What is to be compared, of the neighbors that were taken.
WINDOW_INLINE void begin_search(const WindowTables* tables, global const ushort* target, local SharedWindow* shared,
                                i32 lane) {
  const CostTables* cost = &tables->cost;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0) {
    shared->known.num = cost->num_neighbors;
    shared->known.coherence_scale = cost->coherence_scales[shared->sum_of_weights];
    u32 quarters = 0u;
    for (i32 q = 0; q < kNeighborhoodQuarters; ++q)
      quarters |= kNeighborhoodQuarters * shared->num_in_place[q] == cost->num_neighbors ? 1u << q : 0u;
    if (!compares_projections(shared->known.coherence_scale, quarters, shared->num_known, cost->num_neighbors))
      quarters = 0u;
    if (quarters != 0u) shared->reach = reach_of(shared->known.coherence_scale, cost->control_scales[0], target[0]);
    shared->quarters = quarters;
  }
  barrier(CLK_LOCAL_MEM_FENCE);

  const u32 quarters = shared->quarters;
  const i32 by_quarters = quarters == kEveryQuarter ? 0 : 1;
  const i32 of_part = by_quarters != 0 ? kProjectedValues / kNeighborhoodQuarters : kProjectedValues;
  const i32 value = lane % kProjectedValues;
  if (quarters != 0u) {
    const bool is_rest = value % of_part == of_part - 1;
    global const short* rows = (by_quarters != 0 ? tables->rows[1] : tables->rows[0]) + value;
    i32 sum = 0;
    for (i32 i = lane / kProjectedValues; i < cost->num_neighbors * kComponents; i += kItems / kProjectedValues)
      sum += projection_term(shared->known.appearance[i], rows[i * kProjectedValues], is_rest);
    atomic_add(&shared->sums[value], sum);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (quarters != 0u && lane < kProjectedValues) {
    if (value % of_part == of_part - 1) {
      i64 left = squared_length(shared->sums[value]);
      for (i32 j = value + 1 - of_part; j < value; ++j) left -= (i64)shared->sums[j] * shared->sums[j];
      shared->query[value] = projected_rest(left);
    } else {
      shared->query[value] = projected_value(shared->sums[value]);
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// The squared distance within which pixels must be that cost at most `bound`.
WINDOW_INLINE i32 limit_of(const WindowTables* tables, local const SharedWindow* shared, i64 bound) {
  if (shared->quarters != 0u) {
    const ProjectionReach reach = shared->reach;
    return (i32)at_most(reach_within(&reach, bound), kNoLimit);
  }
  const i64 scale = tables->cost.control_scales[0];
  return scale == 0 ? kNoLimit : (i32)at_most(bound / scale, kNoLimit);
}

// An item's best.
typedef struct ItemBest {
  i64 cost;
  i32 pixel;
} ItemBest;

// What is looked for: the best pixel; how many cost at most `bound`; one of those.
enum { kFindBest, kCountWithin, kFindChosen };

// A pixel that waited in the queue. While the best is looked for, whatever costs at most 1 + epsilon of the best so far
// is hit as well: the window need not be looked at again, unless there are more than there is room for.
WINDOW_INLINE void look_at(const WindowTables* tables, global const ushort* target, local SharedWindow* shared,
                           i32 what, double epsilon, bool is_hit, i32 pixel, ItemBest* best) {
  i64 bound = shared->bound;
  if (what == kFindBest) {
    const i32 ceiling = shared->ceiling;
    bound = ceiling == kNoLimit ? kNoCost - 1 : loosened_cost((((i64)ceiling + 1) << kCeilingBits) - 1, epsilon);
  }
  const i64 cost = cost_of_pixel(&tables->source, &tables->cost, target, &shared->known, pixel, bound + 1);
  if (cost > bound) return;
  if (is_hit) {
    const i32 at = atomic_inc(&shared->num_hits);
    if (at < kMostQueued) {
      shared->hits[at] = pixel;
      shared->hit_costs[at] = cost;
    }
  }
  if (what != kFindBest || cost > best->cost || (cost == best->cost && pixel > best->pixel)) return;
  best->cost = cost;
  best->pixel = pixel;
  atomic_min(&shared->limit, limit_of(tables, shared, loosened_cost(cost, epsilon)));
  atomic_min(&shared->ceiling, (i32)at_most(cost >> kCeilingBits, kNoLimit));
}

// The least cost of all items, of several the least rank: in cost[0] and rank[0].
WINDOW_INLINE void find_least(local SharedWindow* shared, i32 lane, i64 cost, i32 rank) {
  barrier(CLK_LOCAL_MEM_FENCE);
  shared->cost[lane] = cost;
  shared->rank[lane] = rank;
  for (i32 apart = kItems / 2; apart > 0; apart /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    const i32 other = lane + apart;
    if (lane < apart && (shared->cost[other] < shared->cost[lane] ||
                         (shared->cost[other] == shared->cost[lane] && shared->rank[other] < shared->rank[lane]))) {
      shared->cost[lane] = shared->cost[other];
      shared->rank[lane] = shared->rank[other];
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// Can the pixel be as near as it must be?
WINDOW_INLINE bool is_in_reach(const WindowTables* tables, const ProjectionReach* reach, short16 query, u32 quarters,
                               i32 limit, i32 target, i32 pixel) {
  const i32 control = tables->first_controls[pixel];
  if (control == kNotUsable) return false;
  if (limit == kNoLimit) return true;
  if (quarters == 0u) return (control - target) * (control - target) <= limit;
  const i64 taken = reach_taken(reach, control, control);
  if (taken > limit) return false;
  global const short* projections = quarters == kEveryQuarter ? tables->projections[0] : tables->projections[1];
  return taken + projected_distance(query, projections + (i64)pixel * kProjectedValues, quarters) <= limit;
}

// Only those that cost at most shared->bound stay hit, if all are kept.
WINDOW_INLINE void drop_costly_hits(local SharedWindow* shared, bool is_done, i32 lane) {
  i32 stay[kPixelsEach + 1], num_stay = 0;
  const i32 num = shared->num_hits;
  for (i32 i = lane; is_done && num <= kMostQueued && i < num; i += kItems) {
    if (shared->hit_costs[i] <= shared->bound) stay[num_stay++] = shared->hits[i];
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0 && is_done) shared->num_hits = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (i32 i = 0; i < num_stay; ++i) shared->hits[atomic_inc(&shared->num_hits)] = stay[i];
  barrier(CLK_LOCAL_MEM_FENCE);
}

// Of the pixels that were hit, all of which are kept, the one before which `num_before` come.
WINDOW_INLINE void choose_hit(local SharedWindow* shared, i32 num_before, i32 lane) {
  const i32 num = shared->num_hits;
  for (i32 i = lane; i < num; i += kItems) {
    i32 rank = 0;
    for (i32 j = 0; j < num; ++j) rank += shared->hits[j] < shared->hits[i] ? 1 : 0;
    if (rank == num_before) shared->chosen = shared->hits[i];
  }
}

// The leads of the window come first: what they cost bounds all others. They are hit when their turn comes.
WINDOW_INLINE void queue_leads(const WindowTables* tables, local SharedWindow* shared, i32 num_leads,
                               SearchWindow window, i32 lane) {
  for (i32 i = lane; i < num_leads; i += kItems) {
    const i32 pixel = shared->leads[i].pixel;
    if (pixel >= 0 && tables->first_controls[pixel] != kNotUsable && window_holds(window, pixel, tables->source.width))
      shared->queue[atomic_inc(&shared->num_queued)] = pixel;
  }
}

// Looks at what is in the queue, then at all pixels of the window: in row order, but for those that are in the queue at
// once. All items meet every barrier, whatever there is to do: some drivers err where a barrier stands in a branch,
// even if all take it.
WINDOW_INLINE void scan_window(const WindowTables* tables, global const ushort* target, local SharedWindow* shared,
                               SearchWindow window, i32 what, double epsilon, ItemBest* best, i32 lane) {
  const i32 kAtOnce = kPixelsEach * kItems;
  const short16 query = vload16(0, shared->query);
  const ProjectionReach reach = shared->reach;
  const u32 quarters = shared->quarters;
  const i32 first_target = target[0], width = window.x1 - window.x0;
  const i64 num = (i64)width * (window.y1 - window.y0);
  i32 x = window.x0 + lane % width, y = window.y0 + lane / width;
  for (i64 begin = -kAtOnce; begin < num; begin += kAtOnce) {
    const i32 limit = shared->limit;
    for (i32 i = 0; begin >= 0 && i < kPixelsEach; ++i) {
      const i32 pixel = y * tables->source.width + x;
      if (y < window.y1 && is_in_reach(tables, &reach, query, quarters, limit, first_target, pixel))
        shared->queue[atomic_inc(&shared->num_queued)] = pixel;
      x += kItems % width;
      y += kItems / width;
      if (x >= window.x1) {
        x -= width;
        ++y;
      }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    const i32 num_queued = shared->num_queued;
    const bool is_due = num_queued >= kItems || begin < 0 || begin + kAtOnce >= num;
    for (i32 i = lane; is_due && i < num_queued; i += kItems)
      look_at(tables, target, shared, what, epsilon, what != kFindBest || (begin >= 0 && epsilon > 0.0),
              shared->queue[i], best);
    barrier(CLK_LOCAL_MEM_FENCE);
    const i32 num_before = shared->num_before, num_hits = shared->num_hits;
    if (what == kFindChosen && is_due && num_before >= 0 && num_before < num_hits) choose_hit(shared, num_before, lane);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lane == 0 && is_due) {
      shared->num_queued = 0;
      if (what == kFindChosen) {
        shared->num_before -= num_hits;
        shared->num_hits = 0;
      }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}
