// What one contact moves between a gammaton and a texel, and how the parts of a splat share one: transfer.h, pieces.h.
// In the dialect of kernel_language.inl, behind philox.inl and portable_math.inl.

typedef struct TransferShares {
  PATINATE_MEMBER(double, up, 0.0);    // [0, 1].
  PATINATE_MEMBER(double, down, 0.0);  // [0, 1] / weight.
} TransferShares;

PATINATE_CONSTANT(u32, kMedianTexelWeight, 256u);       // SurfaceAtlas::kMedianWeight,
PATINATE_CONSTANT(u32, kMostQuanta, 65535u);            // kMaxAmount,
PATINATE_CONSTANT(u32, kWholeSplat, 65536u);            // SplatShape::kWhole,
PATINATE_CONSTANT(u32, kMostParts, 720u);               // SplatShape::kMaxParts.
PATINATE_CONSTANT(u32, kTransferPurpose, 0x74726E73u);  // Keeps this use of the scene's seed apart from others.
PATINATE_CONSTANT(u32, kDealPurpose, 0xFFFFu);          // More than any part's number.

PATINATE_INLINE TransferShares transfer_shares_of(double ratio, double rate, double contact, u32 weight,
                                                  double area_share) {
  const double area = area_share * (double)kMedianTexelWeight / (double)weight;
  const double rising = area * (1.0 - ratio);
  const double lambda = rising + ratio;  // > 0: area is
  const double gone = portable_decayed(rate * lambda * contact);
  TransferShares shares;
  shares.up = rising / lambda * gone;
  shares.down = ratio / lambda * gone / (double)weight;
  return shares;
}

// The closed form rounded to floor(x + random / 2^32), and bounded by what is there.
PATINATE_INLINE i32 moved_quanta(const TransferShares shares, u32 amount, u32 weight, u32 mass, u32 random, u32 limit) {
  const double exact = shares.up * (double)amount - shares.down * (double)mass;
  const double shifted = exact + (double)random * 0x1p-32;
  i64 n = (i64)shifted;
  if ((double)n > shifted) --n;
  if (n > 0) {
    if (n > (i64)amount) n = (i64)amount;
    if ((u64)n * weight > limit - mass) n = (i64)((limit - mass) / weight);
  } else if (n < 0) {
    if (-n > (i64)(kMostQuanta - amount)) n = (i64)amount - (i64)kMostQuanta;
    if ((u64)(-n) * weight > mass) n = -(i64)(mass / weight);
  }
  return (i32)n;
}

// All that is carried, below 0: as much of it as fits.
PATINATE_INLINE i32 deposited_quanta(u32 amount, u32 weight, u32 mass) {
  const u32 room = kMostQuanta - amount, whole = mass / weight;
  return -(i32)(whole < room ? whole : room);
}

// Another random number of one: uniform where it is, and without a visible relation to it.
PATINATE_INLINE u32 mixed_with(u32 random, u32 purpose) {
  u32 x = random + purpose * 0x9E3779B9u;
  x = (x ^ x >> 16) * 0x7FEB352Du;
  x = (x ^ x >> 15) * 0x846CA68Bu;
  return x ^ x >> 16;
}

// What a part of a splat may hold that carries `mass`: all parts together no more than their gammaton may.
PATINATE_INLINE u32 limit_of_part(u32 whole, u32 mass) { return mass + (0xFFFFFFFFu - whole) / kMostParts; }

// Where dealing out begins, and how many of `quanta` the parts have whose shares sum to `share`.
PATINATE_INLINE u32 deal_start(u32 random) { return mixed_with(random, kDealPurpose) % kWholeSplat; }
PATINATE_INLINE u64 dealt_to(u64 quanta, u64 share, u32 start) { return (quanta * share + start) / kWholeSplat; }

// Random numbers of one contact, four materials at a time. @param numbers  4.
PATINATE_INLINE void transfer_random_block(u64 seed, u32 gammaton, u64 key, u32 piece, u32 block, u32* numbers) {
  numbers[0] = (u32)key;
  numbers[1] = gammaton;
  numbers[2] = piece << 1 | block;
  numbers[3] = (u32)(key >> 32);
  philox4x32_10(numbers, (u32)seed ^ kTransferPurpose, (u32)(seed >> 32));
}

// A splat's share where areas differ: no more than comes back from there (SplatShape::balanced).
PATINATE_INLINE u32 balanced_share(u32 share, u32 weight, u32 other) {
  return other >= weight ? share : share * other / weight;
}
