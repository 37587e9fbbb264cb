// The entries of an exchange: splats are laid out and cargo is dealt (an item a contact); pieces are hung into lists of
// their texels, and whoever hung last exchanges all of a texel in the order of gammatons (an item a piece); what pieces
// carry then is summed (an item a contact). Masses and moved quanta: by piece, then active material.

static inline uint texel_beside(const int width, uint texel, int dx, int dy) {
  const uint pages_x = (uint)((width + 63) / 64), page = texel >> 12;
  const uint x = (page % pages_x << 6 | (texel >> 6 & 7u) << 3 | (texel & 7u)) + (uint)dx,
             y = (page / pages_x << 6 | (texel >> 9 & 7u) << 3 | (texel >> 3 & 7u)) + (uint)dy;
  const uint there = (y >> 6) * pages_x + (x >> 6);
  return there << 12 | (y >> 3 & 7u) << 9 | (x >> 3 & 7u) << 6 | (y & 7u) << 3 | (x & 7u);
}

// @returns how many pieces the contact has; the middle has what the others leave.
static uint lay_stencil(const int width, global const SplatContact* contact, global const StencilPart* parts,
                        global const ushort* weights, uint number, global SplatPiece* pieces) {
  const uint texel = contact->texel, weight = weights[texel];
  uint rest = kWholeSplat, num = 1u;
  for (uint k = 1u; k < contact->num_parts; ++k) {
    global const StencilPart* part = parts + contact->first_part + k;
    const uint there = texel_beside(width, texel, part->x, part->y);
    const uint share = balanced_share(part->share, weight, weights[there]);
    if (share == 0u) continue;
    const SplatPiece piece = {there, number, num, share};
    pieces[num++] = piece;
    rest -= share;
  }
  const SplatPiece middle = {texel, number, 0u, rest};
  pieces[0] = middle;
  return num;
}

static uint lay_cut(global const SplatContact* contact, global const CutPart* parts, uint number,
                    global SplatPiece* pieces) {
  for (uint k = 0u; k < contact->num_parts; ++k) {
    const SplatPiece piece = {parts[contact->first_part + k].texel, number, k, parts[contact->first_part + k].share};
    pieces[k] = piece;
  }
  return contact->num_parts;
}

// cargo and randoms: by contact, then active material.
kernel void lay_splats(const ExchangeCall call, const uint num_contacts, global const SplatContact* contacts,
                       global const StencilPart* stencils, global const CutPart* cut, global const ushort* weights,
                       global const uint* cargo, global uint* randoms, global SplatPiece* pieces, global uint* masses) {
  const uint item = (uint)get_global_id(0);
  if (item >= num_contacts) return;
  global const SplatContact* contact = contacts + item;
  global SplatPiece* mine = pieces + contact->first_piece;
  const uint num = contact->is_cut != 0u ? lay_cut(contact, cut, item, mine)
                                         : lay_stencil(call.width, contact, stencils, weights, item, mine);
  for (uint k = num; k < contact->num_parts; ++k) mine[k].texel = kNoPiece;
  const uint weight = weights[contact->texel], n = call.num_active;
  uint block[4];
  for (uint a = 0u; a < n; ++a) {
    if (a % 4u == 0u)
      transfer_random_block(call.seed, contact->gammaton, call.random_key, call.random_piece, a / 4u, block);
    const uint random = block[a % 4u], whole = cargo[item * n + a], start = deal_start(random);
    const ulong quanta = whole / weight;
    randoms[item * n + a] = random;
    ulong share = 0ul, dealt = 0ul;
    for (uint k = 0u; k < num; ++k) {
      share += mine[k].share;
      const ulong until = dealt_to(quanta, share, start);
      masses[(contact->first_piece + k) * n + a] = (uint)(until - dealt) * weight + (k == 0u ? whole % weight : 0u);
      dealt = until;
    }
  }
}

// heads: by texel, kNoPiece before and after.
kernel void hang_pieces(const uint num_pieces, global const SplatPiece* pieces, global uint* heads, global uint* next) {
  const uint item = (uint)get_global_id(0);
  if (item >= num_pieces || pieces[item].texel == kNoPiece) return;
  next[item] = atomic_xchg(heads + pieces[item].texel, item);
}

// Sorts a list by the numbers of its pieces, which rise with contacts, and these with gammatons: merges runs of 1, 2,
// 4 ... pieces.
static uint sorted_list(uint first, global uint* next) {
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
        const bool takes_a = num_a > 0u && (num_b == 0u || b == kNoPiece || a < b);
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

// amounts: planes of all materials; moved: what left each piece's texel; dirty: by tile, a bit for each material.
kernel void exchange_pieces(const ExchangeCall call, const uint num_pieces, global const SplatPiece* pieces,
                            global const uint* cargo, global const uint* randoms, global const ushort* weights,
                            global uint* heads, global uint* next, global uint* masses, global int* moved,
                            global ushort* amounts, global uint* dirty) {
  const uint item = (uint)get_global_id(0);
  if (item >= num_pieces) return;
  const uint texel = pieces[item].texel;
  if (texel == kNoPiece || heads[texel] != item) return;
  const uint weight = weights[texel], n = call.num_active;
  uint is_dirty = 0u;
  for (uint p = sorted_list(item, next); p != kNoPiece; p = next[p]) {
    const uint contact = pieces[p].contact;
    const double area = call.contact_area * (double)pieces[p].share / (double)kWholeSplat;
    for (uint a = 0u; a < n; ++a) {
      global ushort* amount = amounts + (ulong)call.materials[a] * call.num_texels + texel;
      const uint mass = masses[p * n + a];
      int quanta;
      if (call.is_deposit != 0u) {
        quanta = deposited_quanta(*amount, weight, mass);
      } else {
        const TransferShares shares = transfer_shares_of(call.ratio, call.rates[a], call.contact, weight, area);
        const uint random = randoms[contact * n + a];
        // A contact of one texel takes its number as it is, and may fill the gammaton.
        quanta = moved_quanta(shares, *amount, weight, mass,
                              call.is_wide != 0u ? mixed_with(random, pieces[p].number) : random,
                              call.is_wide != 0u ? limit_of_part(cargo[contact * n + a], mass) : 0xFFFFFFFFu);
      }
      moved[p * n + a] = quanta;
      if (quanta == 0) continue;
      *amount = (ushort)((int)*amount - quanta);
      masses[p * n + a] = mass + (uint)quanta * weight;
      is_dirty |= 1u << call.materials[a];
    }
  }
  if (is_dirty != 0u) atomic_or(dirty + (texel >> 6), is_dirty);
  heads[texel] = kNoPiece;
}

// sums: by active material, what was picked up, what was dropped.
kernel void join_pieces(const uint num_active, const uint num_contacts, global const SplatContact* contacts,
                        global const SplatPiece* pieces, global const ushort* weights, global const uint* masses,
                        global const int* moved, global uint* cargo, global uint* sums) {
  const uint item = (uint)get_global_id(0), lane = (uint)get_local_id(0);
  local uint sum[4 * 8];
  if (lane < 32u) sum[lane] = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint a = 0u; item < num_contacts && a < num_active; ++a) {
    uint mass = 0u;
    ulong picked_up = 0ul, dropped = 0ul;
    for (uint k = 0u; k < contacts[item].num_parts; ++k) {
      const uint p = contacts[item].first_piece + k;
      if (pieces[p].texel == kNoPiece) break;
      mass += masses[p * num_active + a];
      const long change = (long)moved[p * num_active + a] * weights[pieces[p].texel];
      if (change > 0)
        picked_up += (ulong)change;
      else
        dropped += (ulong)(-change);
    }
    cargo[item * num_active + a] = mass;
    add_here(sum + 4u * a, (uint)picked_up, (uint)(picked_up >> 32));
    add_here(sum + 4u * a + 2u, (uint)dropped, (uint)(dropped >> 32));
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane < 2u * num_active) add_everywhere(sums + 2u * lane, sum[2u * lane], sum[2u * lane + 1u]);
}
