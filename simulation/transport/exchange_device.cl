// The last entry of an exchange, behind lay_device.cl: of the pieces in a texel's list the one that hung last exchanges all
// of them, in the order of gammatons. What pieces exchange is added to their gammaton's cargo and to the tally.

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
    const uint material = call->materials[a], mass = masses[(ulong)p * n + a];
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
