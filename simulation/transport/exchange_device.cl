// The entries of an exchange. Groups of items lay out splats and trails, deal cargo out to their pieces, and hang these
// into lists of their texels, in any order; whoever hung last exchanges all of a texel in the order of gammatons. What
// pieces exchange is added to their gammaton's cargo and to the tally. Masses: by piece, then active material.

// Cargo as it is when it is dealt out, and random numbers, both by gammaton, then active material.
#define PIECE_ARRAYS                                                                                              \
  global const uint *cargo, global uint *wholes, global uint *randoms, global SplatPiece *pieces, global uint *masses, \
      global uint *heads, global uint *next, global uint *tally
typedef struct Pieces {
  global const uint* cargo;
  global uint *wholes, *randoms;
  global SplatPiece* pieces;
  global uint *masses, *heads, *next, *tally;
} Pieces;
#define PIECES_OF_ARRAYS const Pieces to = {cargo, wholes, randoms, pieces, masses, heads, next, tally}

// What a group deals out.
typedef struct Dealing {
  uint gammaton, weight, first;
  uint whole[8], random[8];  // By active material.
} Dealing;

// By all items. @param middle  The texel that the gammaton's quanta are counted in.
ALL_INLINE void begin_dealing(const ExchangeCall* call, const Pieces* to, uint gammaton, uint weight,
                                 local Dealing* dealing) {
  const uint a = (uint)get_local_id(0), n = call->num_active;
  if (a == 0u) {
    dealing->gammaton = gammaton;
    dealing->weight = weight;
  }
  if (a < n) {
    uint block[4];
    transfer_random_block(call->seed, gammaton, call->random_key, call->random_piece, a / 4u, block);
    dealing->random[a] = block[a % 4u];
    dealing->whole[a] = to->cargo[gammaton * call->num_materials + call->materials[a]];
    to->randoms[gammaton * n + a] = dealing->random[a];
    to->wholes[gammaton * n + a] = dealing->whole[a];
  }
}

// By one item: room for pieces. @returns whether there is some.
ALL_INLINE bool take_room(const ExchangeCall* call, const Pieces* to, uint num, local Dealing* dealing) {
  const uint first = atomic_add(to->tally + kNumPieces + call->phase, num);
  dealing->first = first;
  if (first <= call->most_pieces && num <= call->most_pieces - first) return true;
  to->tally[kHasOverflown] = 1u;
  dealing->first = kNoPiece;
  return false;
}

// @param before  Shares of those before it.
ALL_INLINE void put_piece(const ExchangeCall* call, const Pieces* to, local const Dealing* dealing, uint texel,
                             uint number, uint share, uint before) {
  const uint p = dealing->first + number, n = call->num_active;
  const SplatPiece piece = {texel, dealing->gammaton, number, share};
  to->pieces[p] = piece;
  for (uint a = 0u; a < n; ++a) {
    const uint whole = dealing->whole[a], start = deal_start(dealing->random[a]);
    const ulong quanta = whole / dealing->weight;
    const ulong from = dealt_to(quanta, before, start), until = dealt_to(quanta, (ulong)before + share, start);
    to->masses[p * n + a] = (uint)(until - from) * dealing->weight + (number == 0u ? whole % dealing->weight : 0u);
  }
  to->next[p] = atomic_xchg(to->heads + texel, p);
}

// A splat that a stencil lays out. @param room  The group's.
ALL_INLINE void put_stencil(const ExchangeCall* call, const SplatSurface* s, const Pieces* to, uint gammaton,
                               uint texel, const StencilFacts of, local Dealing* dealing, local uint* room,
                               local uint* sums) {
  const uint lane = (uint)get_local_id(0), weight = s->weights[texel];
  begin_dealing(call, to, gammaton, weight, dealing);
  if (lane < 2u) sums[lane] = lane == 0u ? 0u : 1u;
  barrier(CLK_LOCAL_MEM_FENCE);
  uint there, all = 0u, num = 0u;
  EACH_IN_TURN(k, of.num) {
    if (k == 0u) continue;
    const uint share = stencil_share(s, texel, weight, of.first + k, &there);
    all += share;
    num += share != 0u ? 1u : 0u;
  }
  if (num != 0u) {
    atomic_add(sums, all);
    atomic_add(sums + 1, num);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u && take_room(call, to, sums[1], dealing))
    put_piece(call, to, dealing, texel, 0u, kWholeSplat - sums[0], 0u);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (dealing->first == kNoPiece) return;
  uint before = kWholeSplat - sums[0], number = 1u;
  for (uint k = 1u; k < of.num; k += kLayItems) {
    const uint share = k + lane < of.num ? stencil_share(s, texel, weight, of.first + k + lane, &there) : 0u;
    // Both at once: shares sum to 2^16 at most, of which at most 32 are here.
    const uint shares = sum_up_to(room, share), numbers = sum_up_to(room + kLayItems, share != 0u ? 1u : 0u);
    if (share != 0u) put_piece(call, to, dealing, there, number + numbers - 1u, share, before + shares - share);
    before += room[kLayItems - 1];
    number += room[2 * kLayItems - 1];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

// contacts: by gammaton, its texel or kNoPiece. Those near seams are listed in `cut`.
kernel __attribute__((reqd_work_group_size(PATINATE_LAY_ITEMS, 1, 1))) void lay_contacts(
    const ExchangeCall call, SPLAT_ARRAYS, global const uint* contacts, PIECE_ARRAYS, global uint* cut) {
  local Dealing dealing;
  local uint room[2 * kLayItems], sums[2], flag;
  SPLAT_SURFACE_OF_ARRAYS;
  PIECES_OF_ARRAYS;
  const uint gammaton = (uint)get_global_id(0) / kLayItems, texel = contacts[gammaton];
  if (texel == kNoPiece) return;
  const int size = size_there(&surface, call.width, texel);
  StencilFacts of = {0u, 1u, 0};
  if (size > 0) {
    of = stencils[size];
    if (!is_plain_there(&surface, texel, of.reach, &flag)) {
      if (get_local_id(0) == 0) cut[atomic_inc(tally + kNumCut)] = gammaton;
      return;
    }
  }
  put_stencil(&call, &surface, &to, gammaton, texel, of, &dealing, room, sums);
}

// Those near seams, by groups in turns.
kernel __attribute__((reqd_work_group_size(PATINATE_LAY_ITEMS, 1, 1))) void lay_cut(
    const ExchangeCall call, SPLAT_ARRAYS, global const uint* contacts, PIECE_ARRAYS, global const uint* cut,
    global WalkRoom* rooms, global uint* link_to, global double* link_flow_to) {
  local LocalWalk walk;
  local Dealing dealing;
  local uint num_links[kLayItems], room[kLayItems];
  SPLAT_SURFACE_OF_ARRAYS;
  PIECES_OF_ARRAYS;
  const uint group = (uint)get_group_id(0), lane = (uint)get_local_id(0), num_cut = tally[kNumCut];
  global WalkRoom* mine = rooms + group;
  for (uint c = group; c < num_cut; c += (uint)get_num_groups(0)) {
    const uint gammaton = cut[c], texel = contacts[gammaton];
    const uint num = walk_there(&surface, texel, size_there(&surface, call.width, texel), &walk, num_links,
                                link_to + group * kLayItems * call.most_links,
                                link_flow_to + group * kLayItems * call.most_links, mine);
    begin_dealing(&call, &to, gammaton, weights[texel], &dealing);
    if (lane == 0u) (void)take_room(&call, &to, num, &dealing);
    barrier(CLK_LOCAL_MEM_FENCE);
    uint before = 0u;
    for (uint k = 0u; dealing.first != kNoPiece && k < num; k += kLayItems) {
      const uint share = k + lane < num ? mine->part_share[k + lane] : 0u, shares = sum_up_to(room, share);
      if (k + lane < num)
        put_piece(&call, &to, &dealing, mine->part_texel[k + lane], k + lane, share, before + shares - share);
      before += room[kLayItems - 1];
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  }
}

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

// What a group has of a trail.
typedef struct TrailPlaces {
  uint texel[16], share[16];
  uint num, whole, rest, num_used, middle_share, num_parts, flag, all;
  double width;
} TrailPlaces;

ALL_INLINE void find_places(const ExchangeCall* call, global const Trail* trail, local TrailPlaces* places) {
  const uint n = trail_size(trail->num_added);
  places->num = 0u;
  for (uint i = n; i-- > 0u;) {
    const uint texel = trail->texel[trail_place(trail->num_added, i)];
    uint p = 0u;
    while (p < places->num && places->texel[p] != texel) ++p;
    if (p == places->num) {
      places->texel[p] = texel;
      places->share[p] = 0u;
      ++places->num;
    }
    places->share[p] += i + 1u;
  }
  places->whole = trail_whole(n);
  places->rest = kWholeSplat;
  places->num_used = 0u;
  places->width = call->width * stain_width(n);
}

// The splat of one place of a trail, added to its tiles.
ALL_INLINE void add_place(const SplatSurface* s, const TrailTiles* tiles, uint p, local TrailPlaces* places,
                             local LocalWalk* walk, local uint* num_links, global uint* to, global double* flow,
                             global WalkRoom* room) {
  const uint lane = (uint)get_local_id(0), texel = places->texel[p], of_place = places->share[p];
  const int size = size_there(s, places->width, texel);
  StencilFacts of = {0u, 1u, 0};
  if (size > 0) of = s->stencils[size];
  const bool is_plain = size == 0 || is_plain_there(s, texel, of.reach, &places->flag);
  uint num = of.num;
  if (!is_plain) num = walk_there(s, texel, size, walk, num_links, to, flow, room);
  if (lane == 0u) places->all = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  const uint weight = s->weights[texel];
  EACH_IN_TURN(k, num) {
    uint there, share;
    if (!is_plain) {
      there = room->part_texel[k];
      share = room->part_share[k];
    } else if (k == 0u) {
      continue;  // It has what the others leave.
    } else {
      share = stencil_share(s, texel, weight, of.first + k, &there);
      if (share == 0u) continue;
      atomic_add(&places->all, share);
    }
    const uint own = trail_share(share, of_place, places->whole);
    add_share(tiles, there, own, &places->num_used);
    atomic_sub(&places->rest, own);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (is_plain && lane == 0u) {
    const uint own = trail_share(kWholeSplat - places->all, of_place, places->whole);
    add_share(tiles, texel, own, &places->num_used);
    atomic_sub(&places->rest, own);
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

// Orders the tiles, and counts what lies before each. The middle is counted apart.
ALL_INLINE void order_tiles(const TrailTiles* t, local TrailPlaces* places) {
  const uint lane = (uint)get_local_id(0), middle = places->texel[0], num = places->num_used;
  EACH_IN_TURN(k, num) {
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
                             local const TrailPlaces* places, local const Dealing* dealing) {
  const uint lane = (uint)get_local_id(0), middle = places->texel[0];
  const bool has_room = dealing->first != kNoPiece;
  if (lane == 0u && has_room) put_piece(call, to, dealing, middle, 0u, places->middle_share, 0u);
  EACH_IN_TURN(k, places->num_used) {
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

// endings: gammatons, so many as the tally says of `which`. slots: by group, of TrailTiles, 5 + 64 words each and 3 more
// for their order.
kernel __attribute__((reqd_work_group_size(PATINATE_LAY_ITEMS, 1, 1))) void lay_endings(
    const ExchangeCall call, SPLAT_ARRAYS, global const Trail* trails, global const uint* endings, const uint which,
    PIECE_ARRAYS, global WalkRoom* rooms, global uint* link_to, global double* link_flow_to, global uint* slots) {
  local LocalWalk walk;
  local Dealing dealing;
  local TrailPlaces places;
  local uint num_links[kLayItems];
  SPLAT_SURFACE_OF_ARRAYS;
  PIECES_OF_ARRAYS;
  const uint group = (uint)get_group_id(0), lane = (uint)get_local_id(0), num = tally[kNumEndings + which],
             n = call.num_slots;
  global uint* mine = slots + (ulong)group * n * 71u;
  const TrailTiles tiles = {n, mine, mine + n, mine + 3u * n, mine + 67u * n, mine + 68u * n};
  for (uint e = group; e < num; e += (uint)get_num_groups(0)) {
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    const uint gammaton = endings[e];
    if (lane == 0u) find_places(&call, trails + gammaton, &places);
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint p = 0u; p < places.num; ++p)
      add_place(&surface, &tiles, p, &places, &walk, num_links, link_to + group * kLayItems * call.most_links,
                link_flow_to + group * kLayItems * call.most_links, rooms + group);
    if (lane == 0u) add_share(&tiles, places.texel[0], places.rest, &places.num_used);
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    if (places.num_used >= n) {
      if (lane == 0u) tally[kHasOverflown] = 2u;
      return;
    }
    order_tiles(&tiles, &places);
    begin_dealing(&call, &to, gammaton, weights[places.texel[0]], &dealing);
    if (lane == 0u) (void)take_room(&call, &to, places.num_parts, &dealing);
    barrier(CLK_LOCAL_MEM_FENCE);
    put_trail(&call, &to, &tiles, &places, &dealing);
  }
}

// Sorts a list by gammatons, each of which has at most one piece of a texel: merges runs of 1, 2, 4 ... pieces.
static uint sorted_list(uint first, global const SplatPiece* pieces, global uint* next) {
  for (uint length = 1u;; length *= 2u) {
    uint rest = first, last = kNoPiece, num_runs = 0u;
    first = kNoPiece;
    while (rest != kNoPiece) {
      uint a = rest, b = rest, num_a = 0u, num_b = length;
      ++num_runs;
      while (num_a < length && b != kNoPiece) {
        ++num_a;
        b = next[b];
      }
      while (num_a > 0u || (num_b > 0u && b != kNoPiece)) {
        const bool takes_a =
            num_a > 0u && (num_b == 0u || b == kNoPiece || pieces[a].gammaton < pieces[b].gammaton);
        const uint one = takes_a ? a : b;
        if (takes_a) {
          a = next[a];
          --num_a;
        } else {
          b = next[b];
          --num_b;
        }
        if (last == kNoPiece)
          first = one;
        else
          next[last] = one;
        last = one;
      }
      rest = b;
    }
    next[last] = kNoPiece;
    if (num_runs <= 1u) return first;
  }
}

// What parameter maps are told, by texel.
typedef struct MapsThere {
  global uint *hits, *last, *residence;
  global ulong* deposited;
} MapsThere;

ALL_INLINE void record_contact(const ExchangeCall* call, const MapsThere* maps, uint texel, uint number) {
  if ((call->maps & kMapHits) != 0u && number == 0u) ++maps->hits[texel];
  if ((call->maps & kMapLast) == 0u) return;
  const uint now = (uint)call->iteration + 1u;
  if ((call->maps & kMapResidence) != 0u && maps->last[texel] != now) ++maps->residence[texel];
  maps->last[texel] = now;
}

// Of one piece. @returns a bit for each material of which something has moved.
ALL_INLINE uint exchange_piece(const ExchangeCall* call, const SplatPiece piece, uint p, uint weight,
                                  global const uint* wholes, global const uint* randoms, global const uint* masses,
                                  global uint* cargo, global ushort* amounts, const MapsThere* maps,
                                  local uint* sums) {
  const uint n = call->num_active, texel = piece.texel;
  const bool is_deposit = call->phase != kPhaseOfContacts;
  const double area = call->contact_area * (double)piece.share / (double)kWholeSplat;
  uint changed = 0u;
  for (uint a = 0u; a < n; ++a) {
    const uint material = call->materials[a], mass = masses[p * n + a];
    global ushort* amount = amounts + (ulong)material * call->num_texels + texel;
    int quanta;
    if (is_deposit) {
      quanta = deposited_quanta(*amount, weight, mass);
    } else {
      const TransferShares shares = transfer_shares_of(call->ratio, call->rates[a], call->contact, weight, area);
      const uint random = randoms[piece.gammaton * n + a];
      // A contact of one texel takes its number as it is, and may fill the gammaton.
      const bool is_wide = call->width > 0.0;
      quanta = moved_quanta(shares, *amount, weight, mass, is_wide ? mixed_with(random, piece.number) : random,
                            is_wide ? limit_of_part(wholes[piece.gammaton * n + a], mass) : 0xFFFFFFFFu);
    }
    if (quanta == 0) continue;
    *amount = (ushort)((int)*amount - quanta);
    atomic_add(cargo + piece.gammaton * call->num_materials + material, (uint)quanta * weight);
    changed |= 1u << material;
    const uint moved = (quanta > 0 ? (uint)quanta : (uint)(-quanta)) * weight;
    add_here(sums + mass_at(quanta > 0 ? kMassPickedUp : kMassDropped, material), moved, 0u);
    if (quanta < 0 && call->map_of[material] != 0u)
      maps->deposited[(ulong)(call->map_of[material] - 1u) * call->num_texels + texel] += moved;
  }
  return changed;
}

// heads: by texel, kNoPiece before and after.
kernel void exchange_pieces(const ExchangeCall call, global const SplatPiece* pieces, global const ushort* weights,
                            global const uint* wholes, global const uint* randoms, global uint* heads,
                            global uint* next, global const uint* masses, global uint* cargo, global ushort* amounts,
                            TILE_ARRAYS, global uint* hits, global uint* last, global uint* residence,
                            global ulong* deposited, global uint* tally) {
  local uint sums[kGroupSums];
  const Tiles tiles = {dirty, changed_in, awake, is_listed, touched};
  const MapsThere maps = {hits, last, residence, deposited};
  clear_sums(sums);
  barrier(CLK_LOCAL_MEM_FENCE);
  const uint num = tally[kHasOverflown] != 0u ? 0u : tally[kNumPieces + call.phase];
  // As many turns for all items: one compiler leaves out whether an item has a first one.
  for (uint first = 0u; first < num; first += (uint)get_global_size(0)) {
    const uint item = first + (uint)get_global_id(0);
    if (item >= num) continue;
    const uint texel = pieces[item].texel;
    if (heads[texel] != item) continue;
    const uint weight = weights[texel];
    uint changed = 0u;
    for (uint p = next[item] == kNoPiece ? item : sorted_list(item, pieces, next); p != kNoPiece; p = next[p]) {
      if (call.phase == kPhaseOfContacts) record_contact(&call, &maps, texel, pieces[p].number);
      changed |= exchange_piece(&call, pieces[p], p, weight, wholes, randoms, masses, cargo, amounts, &maps, sums);
    }
    if (changed != 0u) mark_tile(&tiles, texel >> 6, changed, call.iteration, tally);
    heads[texel] = kNoPiece;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  add_sums(sums, tally);
}
