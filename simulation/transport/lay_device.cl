// Groups of items lay out splats, deal cargo out to their pieces, and hang these into lists of their texels, in any
// order. Behind walk_device.cl. Masses: by piece, then active material.

#define PATINATE_LAY_ITEMS 32
#define PATINATE_TRAIL_ITEMS 128
enum { kLayItems = PATINATE_LAY_ITEMS, kTrailItems = PATINATE_TRAIL_ITEMS };

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

// By all items. @param weight  Of the middle, in whose quanta the cargo is dealt out.
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
  atomic_or(to->tally + kHasOverflown, 1u);
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
    to->masses[(ulong)p * n + a] = (uint)(until - from) * dealing->weight + (number == 0u ? whole % dealing->weight : 0u);
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
  EACH_IN_TURN(k, of.num, kLayItems) {
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

// A splat that is to be walked. @returns its number; kNoPiece without room.
static inline uint list_walk(const ExchangeCall* call, uint texel, int size, global Walk* walks, global uint* tally) {
  const uint number = atomic_inc(tally + kNumWalks + call->phase);
  if (number >= call->most_walks) {
    atomic_or(tally + kHasOverflown, 4u);
    return kNoPiece;
  }
  const Walk walk = {texel, size, 0u, 0u};
  walks[number] = walk;
  return number;
}

// contacts: by gammaton, its texel or kNoPiece. cut: by walk, whose it is.
kernel __attribute__((reqd_work_group_size(PATINATE_LAY_ITEMS, 1, 1))) void lay_contacts(
    const ExchangeCall call, SPLAT_ARRAYS, global const uint* contacts, PIECE_ARRAYS, global Walk* walks,
    global uint* cut) {
  local Dealing dealing;
  local StencilFacts of;
  local uint room[2 * kLayItems], sums[2], is_laid;
  SPLAT_SURFACE_OF_ARRAYS;
  PIECES_OF_ARRAYS;
  const uint gammaton = (uint)get_global_id(0) / kLayItems, texel = contacts[gammaton];
  if (get_local_id(0) == 0) {
    const int size = texel != kNoPiece ? size_there(&surface, call.width, texel) : 0;
    const StencilFacts one = {0u, 1u, 0}, facts = size > 0 ? stencils[size] : one;
    const bool is_plain = size == 0 || is_plain_there(&surface, texel, facts.reach);
    of = facts;
    is_laid = texel != kNoPiece && is_plain ? 1u : 0u;
    const uint walk = is_plain ? kNoPiece : list_walk(&call, texel, size, walks, tally);
    if (walk != kNoPiece) cut[walk] = gammaton;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (is_laid == 0u) return;
  put_stencil(&call, &surface, &to, gammaton, texel, of, &dealing, room, sums);
}

// Contacts whose splats were walked, by groups in turns.
kernel __attribute__((reqd_work_group_size(PATINATE_LAY_ITEMS, 1, 1))) void lay_cut(
    const ExchangeCall call, global const ushort* weights, PIECE_ARRAYS, global const Walk* walks,
    global const uint* part_texel, global const uint* part_share, global const uint* cut) {
  local Dealing dealing;
  local uint room[2 * kLayItems], num_parts;
  PIECES_OF_ARRAYS;
  const uint lane = (uint)get_local_id(0), num_cut = min(tally[kNumWalks + call.phase], call.most_walks);
  for (uint c = (uint)get_group_id(0); c < num_cut; c += (uint)get_num_groups(0)) {
    const Walk walk = walks[c];
    begin_dealing(&call, &to, cut[c], weights[walk.texel], &dealing);
    if (lane == 0u) num_parts = 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    uint mine = 0u;
    EACH_IN_TURN(k, walk.num, kLayItems) mine += part_share[walk.first + k] != 0u || k == 0u ? 1u : 0u;
    atomic_add(&num_parts, mine);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lane == 0u) (void)take_room(&call, &to, num_parts, &dealing);
    barrier(CLK_LOCAL_MEM_FENCE);
    uint before = 0u, number = 0u;
    for (uint k = 0u; k < walk.num; k += kLayItems) {
      const uint share = k + lane < walk.num ? part_share[walk.first + k + lane] : 0u;
      const uint is_part = k + lane < walk.num && (share != 0u || k + lane == 0u) ? 1u : 0u;
      const uint shares = sum_up_to(room, share), numbers = sum_up_to(room + kLayItems, is_part);
      if (is_part != 0u && dealing.first != kNoPiece)
        put_piece(&call, &to, &dealing, part_texel[walk.first + k + lane], number + numbers - 1u, share,
                  before + shares - share);
      before += room[kLayItems - 1];
      number += room[2 * kLayItems - 1];
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

