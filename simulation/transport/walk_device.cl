// Walks near seams, by groups of items (surface_walk.cpp). Behind splat_device.cl.

#define PATINATE_WALK_ITEMS 128
enum { kWalkItems = PATINATE_WALK_ITEMS, kWalkSlots = 2048, kNoEdge = 0xFFFF, kNoNode = 0xFFFF };

// Texels around one by their distance in links, and the links between them, by target too.
typedef struct LocalWalk {
  // While texels are found, by slot of a hash: 1 + the texel; which link of all that are looked at found it first. Later
  // two doubles by node: its share, and the next.
  double values[kWalkSlots];
  uint texel[720];
  ushort nodes[kWalkSlots];  // By slot: 1 + the node; 0: it has no number yet; kNoNode: there is no room.
  ushort first_edge[721];
  uint first_in[720];       // Edges that lead to a node,
  ushort next_in[6 * 720];  // one behind the other,
  ushort source[6 * 720];   // and where they come from.
  uint level_end[24];
  uint room[kWalkItems];
  uint num_nodes, num_edges, num_levels, may_run_dry, first_part, end_part, rest;
  double sum;
} LocalWalk;

// The slot of a texel; kWalkSlots where it is not among them, and is not made.
ALL_INLINE uint walk_slot(local uint* keys, uint texel, bool is_made) {
  uint s = (texel * 0x9E3779B1u >> 16) % kWalkSlots, found = 0u;
  bool is_over = false;
  for (uint tries = 0u; tries < kWalkSlots && !is_over; ++tries) {
    found = is_made ? atomic_cmpxchg(keys + s, 0u, texel + 1u) : keys[s];
    is_over = found == texel + 1u || found == 0u;
    if (!is_over) s = (s + 1u) % kWalkSlots;
  }
  return found == texel + 1u || (found == 0u && is_made) ? s : kWalkSlots;
}

// The links of a texel, and what flows over each. @returns how many.
static inline uint links_there(const SplatSurface* s, uint texel, double share, global uint* to, global double* flow) {
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

// Of the texels [first, first + items) before `end`, one each: their links become edges, and texels that are new nodes,
// numbered as if one link was looked at after the other.
ALL_INLINE void lay_links(const SplatSurface* s, uint first, uint end, bool makes_nodes, double share,
                          local LocalWalk* w, global uint* to, global double* flow, global WalkRoom* room) {
  const uint lane = (uint)get_local_id(0), node = first + lane;
  local uint* keys = (local uint*)w->values;
  local uint* found_by = keys + kWalkSlots;
  const uint num = node < end ? links_there(s, w->texel[node], share, to, flow) : 0u;
  const bool makes = makes_nodes && w->num_nodes < kWalkTexels;
  for (uint l = 0u; l < s->most_links; ++l) {
    if (l >= num) continue;
    to[l] = walk_slot(keys, to[l], makes);
    if (to[l] < kWalkSlots && w->nodes[to[l]] == 0) atomic_min(found_by + to[l], lane * s->most_links + l);
  }
  uint num_new = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint l = 0u; l < s->most_links; ++l) {
    if (l < num && to[l] < kWalkSlots && w->nodes[to[l]] == 0 && found_by[to[l]] == lane * s->most_links + l) ++num_new;
  }
  uint number = w->num_nodes + sum_up_to(w->room, num_new) - num_new;
  const uint num_nodes = w->num_nodes + w->room[kWalkItems - 1];
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint l = 0u; l < s->most_links; ++l) {
    if (l >= num || to[l] >= kWalkSlots || w->nodes[to[l]] != 0 || found_by[to[l]] != lane * s->most_links + l) continue;
    w->nodes[to[l]] = (ushort)(number < kWalkTexels ? number + 1u : kNoNode);
    if (number < kWalkTexels) {
      w->texel[number] = keys[to[l]] - 1u;
      w->first_in[number] = kNoEdge;
    }
    ++number;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  uint num_valid = 0u;
  for (uint l = 0u; l < s->most_links; ++l) {
    if (l < num && to[l] < kWalkSlots && w->nodes[to[l]] != kNoNode) ++num_valid;
  }
  uint edge = w->num_edges + sum_up_to(w->room, num_valid) - num_valid;
  const uint num_edges = w->num_edges + w->room[kWalkItems - 1];
  if (node < end) w->first_edge[node] = (ushort)min(edge, kWalkEdges);
  double all = 0.0;
  for (uint l = 0u; l < s->most_links; ++l) {
    if (l >= num || to[l] >= kWalkSlots || w->nodes[to[l]] == kNoNode || edge >= kWalkEdges) continue;
    room->flow[edge] = flow[l];
    all += flow[l];
    w->source[edge] = (ushort)node;
    w->next_in[edge] = (ushort)atomic_xchg(w->first_in + (w->nodes[to[l]] - 1u), edge);
    ++edge;
  }
  // Far below what rounding could take away.
  if (all > 0.9) w->may_run_dry = 1u;
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  if (lane == 0u) {
    w->num_nodes = min(num_nodes, kWalkTexels);
    w->num_edges = min(num_edges, kWalkEdges);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// Edges that lead to a node, in the order of those that send.
static inline void sort_edges(local LocalWalk* w, uint node) {
  uint rest = w->first_in[node], sorted = kNoEdge;
  while (rest != kNoEdge) {
    const uint edge = rest;
    rest = w->next_in[edge];
    uint before = kNoEdge, behind = sorted;
    while (behind != kNoEdge && behind < edge) {
      before = behind;
      behind = w->next_in[behind];
    }
    w->next_in[edge] = (ushort)behind;
    if (before == kNoEdge)
      sorted = edge;
    else
      w->next_in[before] = (ushort)edge;
  }
  w->first_in[node] = sorted;
}

ALL_INLINE void lay_walk(const SplatSurface* s, uint middle, int depth, WalkLength length, local LocalWalk* w,
                         global uint* to, global double* flow, global WalkRoom* room) {
  const uint lane = (uint)get_local_id(0);
  local uint* keys = (local uint*)w->values;
  EACH_IN_TURN(k, (uint)kWalkSlots, kWalkItems) {
    keys[k] = 0u;
    keys[kWalkSlots + k] = 0xFFFFFFFFu;
    w->nodes[k] = 0;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u) {
    w->nodes[walk_slot(keys, middle, true)] = 1;
    w->texel[0] = middle;
    w->first_in[0] = kNoEdge;
    w->num_nodes = 1u;
    w->num_edges = 0u;
    w->num_levels = 0u;
    w->may_run_dry = 0u;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  uint begin = 0u;
  for (int d = 0; d <= depth; ++d) {
    const uint end = w->num_nodes;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lane == 0u) {
      w->level_end[w->num_levels++] = end;
      if (d >= length.num_steps) w->first_edge[begin] = (ushort)w->num_edges;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (d >= length.num_steps) break;
    for (uint first = begin; first < end; first += kWalkItems)
      lay_links(s, first, end, d < depth, length.share, w, to, flow, room);
    begin = end;
  }
  if (lane == 0u) w->first_edge[w->num_nodes] = (ushort)w->num_edges;
  const uint num = w->num_nodes;
  EACH_IN_TURN(node, num, kWalkItems) sort_edges(w, node);
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

// What a node sends over an edge.
static inline double sent_over(const local LocalWalk* w, global const WalkRoom* room, uint node, uint edge) {
  return w->may_run_dry != 0u ? room->goes[edge] : w->values[node] * room->flow[edge];
}

// One step: what comes to a node and what leaves it, in the order in which nodes send.
ALL_INLINE void step_walk(local LocalWalk* w, global WalkRoom* room, uint there, uint reached) {
  const uint lane = (uint)get_local_id(0);
  local double* next = w->values + 720;
  if (w->may_run_dry != 0u) {  // A node sends no more than it has.
    EACH_IN_TURN(i, there, kWalkItems) {
      double stays = w->values[i];
      for (uint e = w->first_edge[i]; e < w->first_edge[i + 1u]; ++e) {
        const double wished = w->values[i] * room->flow[e], goes = wished < stays ? wished : stays;
        stays -= goes;
        room->goes[e] = goes;
      }
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  EACH_IN_TURN(j, reached, kWalkItems) {
    double value = w->values[j];
    bool has_sent = j >= there;
    for (uint e = w->first_in[j];; e = w->next_in[e]) {
      const bool is_end = e == kNoEdge || w->source[e] >= there;
      if (!has_sent && (is_end || w->source[e] > j)) {
        for (uint own = w->first_edge[j]; own < w->first_edge[j + 1u]; ++own) value -= sent_over(w, room, j, own);
        has_sent = true;
      }
      if (is_end) break;
      value += sent_over(w, room, w->source[e], e);
    }
    next[j] = value;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  EACH_IN_TURN(j, reached, kWalkItems) w->values[j] = next[j];
  barrier(CLK_LOCAL_MEM_FENCE);
}

// walk_surface(): puts its parts behind those that are there, one for each node, with a share of 0 where a node does not
// count.
ALL_INLINE void walk_there(const ExchangeCall* call, const SplatSurface* s, uint middle, int size, local LocalWalk* w,
                           global uint* to, global double* flow, global WalkRoom* room, global Walk* walk,
                           global uint* part_texel, global uint* part_share, global uint* tally) {
  const uint lane = (uint)get_local_id(0);
  const WalkLength length = walk_length(size);
  const double least = least_of_walk(length.num_steps), weight = (double)s->weights[middle];
  lay_walk(s, middle, walk_depth(size, length.num_steps), length, w, to, flow, room);
  const uint num = w->num_nodes, last_level = w->num_levels - 1u;
  local double* counted = w->values + 720;
  EACH_IN_TURN(i, num, kWalkItems) w->values[i] = i == 0u ? 1.0 : 0.0;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint step = 0u; step < (uint)length.num_steps; ++step)
    step_walk(w, room, w->level_end[min(step, last_level)], w->level_end[min(step + 1u, last_level)]);
  EACH_IN_TURN(i, num, kWalkItems) {
    const bool is = i == 0u || is_counted(w->values[i], weight, least, w->values[0], s->weights[w->texel[i]]);
    counted[i] = is ? w->values[i] : 0.0;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u) {
    double sum = 0.0;
    for (uint i = 0u; i < num; ++i) sum += counted[i];
    w->sum = sum;
    const uint first = atomic_add(tally + kNumWalked + call->phase, num);
    const bool has_room = first <= call->most_walked && num <= call->most_walked - first;
    if (!has_room) atomic_or(tally + kHasOverflown, 4u);
    walk->first = has_room ? first : 0u;
    walk->num = has_room ? num : 1u;
    w->first_part = has_room ? first : 0u;
    w->end_part = has_room ? num : 1u;
    w->rest = kWholeSplat;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  uint given = 0u;
  EACH_IN_TURN(i, num, kWalkItems) {
    const uint whole = i > 0u && counted[i] > 0.0 ? whole_share(counted[i], w->sum) : 0u;
    given += whole;
    if (i < w->end_part) {
      part_texel[w->first_part + i] = w->texel[i];
      part_share[w->first_part + i] = whole;
    }
  }
  atomic_sub(&w->rest, given);
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  part_share[w->first_part] = w->rest;  // By all, the same.
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

// Walks of the call's phase, by groups in turns.
kernel __attribute__((reqd_work_group_size(PATINATE_WALK_ITEMS, 1, 1))) void walk_splats(
    const ExchangeCall call, SPLAT_ARRAYS, global Walk* walks, global WalkRoom* rooms, global uint* link_to,
    global double* link_flow_to, global uint* part_texel, global uint* part_share, global uint* tally) {
  local LocalWalk walk;
  SPLAT_SURFACE_OF_ARRAYS;
  const uint group = (uint)get_group_id(0), num = min(tally[kNumWalks + call.phase], call.most_walks),
             own = (group * kWalkItems + (uint)get_local_id(0)) * call.most_links;
  for (uint k = group; k < num; k += (uint)get_num_groups(0)) {
    walk_there(&call, &surface, walks[k].texel, walks[k].size, &walk, link_to + own, link_flow_to + own, rooms + group,
               walks + k, part_texel, part_share, tally);
  }
}
