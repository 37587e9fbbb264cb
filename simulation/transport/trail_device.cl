// Trails on a device, laid out by groups of items: pieces.cpp's append_trail(). Behind lay_device.cl's dealing.

// Shares along a trail, summed by texel: tiles by a hash, with a bit and a share for each of their texels; all 0 between
// trails.
typedef struct TrailTiles {
  uint num_slots;
  global uint* tiles;    // By slot: 1 + the tile.
  global uint* texels;   // Two words each.
  global uint* shares;   // 64 each.
  global uint* used;     // Slots in the order in which they were taken,
  global uint* ordered;  // and in that of tiles: slot, shares and texels before it.
} TrailTiles;

ALL_INLINE void add_share(const TrailTiles* t, uint texel, uint share, local uint* num_used) {
  const uint key = 1u + (texel >> 6), l = texel & 63u;
  uint s = (key * 0x9E3779B1u >> 8) & (t->num_slots - 1u);
  bool is_there = false;
  for (uint tries = 0u; tries < t->num_slots && !is_there; ++tries) {
    const uint found = atomic_cmpxchg(t->tiles + s, 0u, key);
    if (found == 0u) t->used[atomic_inc(num_used)] = s;
    is_there = found == 0u || found == key;
    if (!is_there) s = (s + 1u) & (t->num_slots - 1u);
  }
  if (is_there) {
    atomic_or(t->texels + 2u * s + (l >> 5), 1u << (l & 31u));
    atomic_add(t->shares + 64u * s + l, share);
  } else {
    *num_used = t->num_slots;  // No room: the caller sees how many are used.
  }
}

// Finds the places of trails, an item each, and those that are to be walked. endings: gammatons, so many as the tally says
// of `which`; places: 16 by ending, num_places: how many there are.
kernel void find_places(const ExchangeCall call, SPLAT_ARRAYS, global const Trail* trails, global const uint* endings,
                        const uint which, global TrailPlace* places, global uint* num_places, global Walk* walks,
                        global uint* tally) {
  SPLAT_SURFACE_OF_ARRAYS;
  const uint num = tally[kNumEndings + which];
  for (uint first = 0u; first < 16u * num; first += (uint)get_global_size(0)) {
    const uint item = first + (uint)get_global_id(0), e = item / 16u, i = item % 16u;
    if (e >= num) continue;
    global const Trail* trail = trails + endings[e];
    const uint n = trail_size(trail->num_added);
    if (i >= n) continue;
    // The newest first; a texel that comes again adds to where it came first.
    const uint texel = trail->texel[trail_place(trail->num_added, n - 1u - i)];
    uint place = 0u, share = 0u, num_all = 0u;
    bool is_first = true;
    for (uint k = 0u; k < n; ++k) {
      const uint other = trail->texel[trail_place(trail->num_added, n - 1u - k)];
      bool is_new = true;
      for (uint before = 0u; before < k; ++before)
        is_new = is_new && trail->texel[trail_place(trail->num_added, n - 1u - before)] != other;
      if (is_new) ++num_all;
      if (is_new && k < i) ++place;
      if (other == texel) {
        share += n - k;
        is_first = is_first && k >= i;
      }
    }
    if (i == 0u) num_places[e] = num_all;
    if (!is_first) continue;
    TrailPlace of = {texel, share, size_there(&surface, call.width * stain_width(n), texel), kNoPiece};
    if (of.size > 0 && !is_plain_there(&surface, texel, stencils[of.size].reach))
      of.walk = min(list_walk(&call, texel, of.size, walks, tally), call.most_walks - 1u);
    places[16u * e + place] = of;
  }
}

// What a group has of a trail.
typedef struct LocalTrail {
  TrailPlace places[16];
  uint first[17];  // By place: its parts among those of all.
  uint all[16];    // Shares of all parts of a stencil but the middle.
  uint num, whole, rest, num_used, middle_share, num_parts;
} LocalTrail;

ALL_INLINE void begin_trail(const SplatSurface* s, global const Trail* trail, global const TrailPlace* places, uint num,
                            global const Walk* walks, local LocalTrail* t) {
  const uint lane = (uint)get_local_id(0);
  if (lane < num) {
    const TrailPlace of = places[lane];
    t->places[lane] = of;
    t->all[lane] = 0u;
    t->first[lane + 1u] = of.walk != kNoPiece ? walks[of.walk].num : of.size > 0 ? s->stencils[of.size].num : 1u;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u) {
    t->first[0] = 0u;
    for (uint p = 0u; p < num; ++p) t->first[p + 1u] += t->first[p];
    t->num = num;
    t->whole = trail_whole(trail_size(trail->num_added));
    t->rest = kWholeSplat;
    t->num_used = 0u;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// The splats of all places, added to the tiles.
ALL_INLINE void add_places(const SplatSurface* s, const TrailTiles* tiles, global const Walk* walks,
                           global const uint* part_texel, global const uint* part_share, local LocalTrail* t) {
  const uint lane = (uint)get_local_id(0), num_parts = t->first[t->num];
  uint given = 0u;
  EACH_IN_TURN(k, num_parts, kTrailItems) {
    uint p = 0u;
    for (uint other = 1u; other < 16u; ++other) p = other < t->num && k >= t->first[other] ? other : p;
    const TrailPlace place = t->places[p];
    const uint part = k - t->first[p];
    uint there, share = 0u;
    if (place.walk != kNoPiece) {
      there = part_texel[walks[place.walk].first + part];
      share = part_share[walks[place.walk].first + part];
    } else if (part > 0u) {  // The middle has what the others leave.
      share = stencil_share(s, place.texel, s->weights[place.texel], s->stencils[place.size].first + part, &there);
      if (share != 0u) atomic_add(t->all + p, share);
    }
    if (share != 0u) {
      const uint own = trail_share(share, place.share, t->whole);
      add_share(tiles, there, own, &t->num_used);
      given += own;
    }
  }
  if (given != 0u) atomic_sub(&t->rest, given);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane < t->num && t->places[lane].walk == kNoPiece) {
    const uint own = trail_share(kWholeSplat - t->all[lane], t->places[lane].share, t->whole);
    add_share(tiles, t->places[lane].texel, own, &t->num_used);
    atomic_sub(&t->rest, own);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u) add_share(tiles, t->places[0].texel, t->rest, &t->num_used);
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

// Orders the tiles, and counts what lies before each. The middle is counted apart.
ALL_INLINE void order_tiles(const TrailTiles* t, local LocalTrail* places) {
  const uint lane = (uint)get_local_id(0), middle = places->places[0].texel, num = places->num_used;
  EACH_IN_TURN(k, num, kTrailItems) {
    const uint slot = t->used[k], key = t->tiles[slot];
    uint rank = 0u, texels = popcount(t->texels[2u * slot]) + popcount(t->texels[2u * slot + 1u]), shares = 0u;
    for (uint other = 0u; other < num; ++other) rank += t->tiles[t->used[other]] < key ? 1u : 0u;
    for (uint l = 0u; l < 64u; ++l) shares += t->shares[64u * slot + l];
    if (key == 1u + (middle >> 6)) {
      places->middle_share = t->shares[64u * slot + (middle & 63u)];
      shares -= places->middle_share;
      --texels;
    }
    t->ordered[3u * rank] = slot;
    t->ordered[3u * rank + 1u] = shares;
    t->ordered[3u * rank + 2u] = texels;
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  if (lane == 0u) {
    uint before = places->middle_share, number = 1u;
    for (uint k = 0u; k < num; ++k) {
      const uint shares = t->ordered[3u * k + 1u], texels = t->ordered[3u * k + 2u];
      t->ordered[3u * k + 1u] = before;
      t->ordered[3u * k + 2u] = number;
      before += shares;
      number += texels;
    }
    places->num_parts = number;
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

// Puts the pieces, the middle first, then by texel; and clears the tiles.
ALL_INLINE void put_trail(const ExchangeCall* call, const Pieces* to, const TrailTiles* t,
                             local const LocalTrail* places, local const Dealing* dealing) {
  const uint lane = (uint)get_local_id(0), middle = places->places[0].texel;
  const bool has_room = dealing->first != kNoPiece;
  if (lane == 0u && has_room) put_piece(call, to, dealing, middle, 0u, places->middle_share, 0u);
  EACH_IN_TURN(k, places->num_used, kTrailItems) {
    const uint slot = t->ordered[3u * k], tile = t->tiles[slot] - 1u;
    uint before = t->ordered[3u * k + 1u], number = t->ordered[3u * k + 2u];
    for (uint l = 0u; l < 64u; ++l) {
      if ((t->texels[2u * slot + (l >> 5)] >> (l & 31u) & 1u) == 0u) continue;
      const uint share = t->shares[64u * slot + l];
      t->shares[64u * slot + l] = 0u;
      if (64u * tile + l == middle) continue;
      if (has_room) put_piece(call, to, dealing, 64u * tile + l, number, share, before);
      ++number;
      before += share;
    }
    t->tiles[slot] = 0u;
    t->texels[2u * slot] = 0u;
    t->texels[2u * slot + 1u] = 0u;
  }
}

// slots: by group, of TrailTiles, 5 + 64 words each and 3 more for their order.
kernel __attribute__((reqd_work_group_size(PATINATE_TRAIL_ITEMS, 1, 1))) void lay_endings(
    const ExchangeCall call, SPLAT_ARRAYS, global const Trail* trails, global const uint* endings, const uint which,
    PIECE_ARRAYS, global const TrailPlace* places, global const uint* num_places, global const Walk* walks,
    global const uint* part_texel, global const uint* part_share, global uint* slots) {
  local Dealing dealing;
  local LocalTrail trail;
  SPLAT_SURFACE_OF_ARRAYS;
  PIECES_OF_ARRAYS;
  const uint group = (uint)get_group_id(0), lane = (uint)get_local_id(0), num = tally[kNumEndings + which],
             n = call.num_slots;
  global uint* mine = slots + (ulong)group * n * 71u;
  const TrailTiles tiles = {n, mine, mine + n, mine + 3u * n, mine + 67u * n, mine + 68u * n};
  for (uint e = group; e < num; e += (uint)get_num_groups(0)) {
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    const uint gammaton = endings[e];
    begin_trail(&surface, trails + gammaton, places + 16u * e, num_places[e], walks, &trail);
    add_places(&surface, &tiles, walks, part_texel, part_share, &trail);
    if (trail.num_used >= n) {
      if (lane == 0u) atomic_or(tally + kHasOverflown, 2u);
      return;
    }
    order_tiles(&tiles, &trail);
    begin_dealing(&call, &to, gammaton, weights[trail.places[0].texel], &dealing);
    if (lane == 0u) (void)take_room(&call, &to, trail.num_parts, &dealing);
    barrier(CLK_LOCAL_MEM_FENCE);
    put_trail(&call, &to, &tiles, &trail, &dealing);
  }
}

