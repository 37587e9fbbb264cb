// What a splat's texels give and take, a block of lanes at a time, in loops that compilers turn into vector code.
// Included by splat_kernel_baseline.cpp, _avx2.cpp and _avx512.cpp inside a namespace of their own; nothing of the
// standard library, whose copies the linker would mix.
//
// Loops that clamp stand apart from those that convert to integers: in one, compilers branch on the clamp and do not
// use vectors.

namespace {

using namespace ::patinate::kernel_types;

constexpr i32 kMaxQuanta = 65535;
constexpr double kBeyond = 65536.0;  // More than any amount.
constexpr u32 kDealPurpose = 0xFFFFu;

// mixed_with() of transfer_kernel.inl.
inline u32 mixed_bits(u32 random, u32 purpose) {
  u32 x = random + purpose * 0x9E3779B9u;
  x = (x ^ x >> 16) * 0x7FEB352Du;
  x = (x ^ x >> 15) * 0x846CA68Bu;
  return x ^ x >> 16;
}

// Exact; as vectors, which have signed conversions alone.
inline double double_of(u32 x) { return (double)(i32)(x ^ 0x80000000u) + 2147483648.0; }

// Whole quanta of 0 <= x, or kMaxQuanta and one more; a quotient of integers below 2^32 rounds to no other integer.
inline void whole_quanta(const double* __restrict x, i32* __restrict out) {
  alignas(64) double least[kLaneBlock];
  for (int l = 0; l < kLaneBlock; ++l) least[l] = x[l] < kBeyond ? x[l] : kBeyond;
  for (int l = 0; l < kLaneBlock; ++l) out[l] = (i32)least[l];
}

struct Dealt {
  alignas(64) u32 mass[kLaneBlock];
  alignas(64) i32 most_down[kLaneBlock];  // Quanta that the part can give,
  alignas(64) i32 most_up[kLaneBlock];    // and take.
};

// Deals what is carried out to the lanes: deal() of pieces.h.
inline void deal_block(const bool is_even, const SplatLanes& in, int first, u32 quanta, u32 start, Dealt& out) {
  const u32* __restrict before = in.before + first;
  const u32* __restrict after = in.after + first;
  const u16* __restrict weight = in.weight + first;
  alignas(64) u32 part[kLaneBlock];
  for (int l = 0; l < kLaneBlock; ++l) {
    const u64 until = ((u64)quanta * (u64)after[l] + start) >> 16;
    const u64 dealt = ((u64)quanta * (u64)before[l] + start) >> 16;
    part[l] = (u32)(until - dealt);
  }
  for (int l = 0; l < kLaneBlock; ++l) out.mass[l] = part[l] * in.middle_weight;
  if (in.middle >= first && in.middle < first + kLaneBlock) out.mass[in.middle - first] += in.whole % in.middle_weight;
  if (is_even) {
    const u32 room = in.room / in.middle_weight;
    const i32 most_up = (i32)(room < (u32)kMaxQuanta ? room : (u32)kMaxQuanta);
    for (int l = 0; l < kLaneBlock; ++l) {
      out.most_down[l] = (i32)(part[l] < (u32)kMaxQuanta ? part[l] : (u32)kMaxQuanta);
      out.most_up[l] = most_up;
    }
    return;
  }
  alignas(64) double quotient[kLaneBlock];
  for (int l = 0; l < kLaneBlock; ++l) quotient[l] = double_of(out.mass[l]) / (double)(i32)weight[l];
  whole_quanta(quotient, out.most_down);
  const double room = double_of(in.room);
  for (int l = 0; l < kLaneBlock; ++l) quotient[l] = room / (double)(i32)weight[l];
  whole_quanta(quotient, out.most_up);
}

// floor(what the closed form moves + a random number).
inline void wish_block(const SplatLanes& in, int first, const u32* __restrict mass, i32* __restrict wished) {
  const u32* __restrict number = in.number + first;
  const u16* __restrict amount = in.amount + first;
  const double* __restrict up = in.up + first;
  const double* __restrict down = in.down + first;
  alignas(64) u32 random[kLaneBlock];
  alignas(64) double shifted[kLaneBlock];
  for (int l = 0; l < kLaneBlock; ++l) random[l] = mixed_bits(in.random, number[l]);
  for (int l = 0; l < kLaneBlock; ++l) {
    const double exact = up[l] * (double)(i32)amount[l] - down[l] * double_of(mass[l]);
    shifted[l] = exact + double_of(random[l]) * 0x1p-32;
  }
  // What lies beyond all amounts is cut to them anyway.
  for (int l = 0; l < kLaneBlock; ++l) shifted[l] = shifted[l] < kBeyond ? shifted[l] : kBeyond;
  for (int l = 0; l < kLaneBlock; ++l) shifted[l] = shifted[l] > -kBeyond ? shifted[l] : -kBeyond;
  for (int l = 0; l < kLaneBlock; ++l) wished[l] = (i32)shifted[l];
  for (int l = 0; l < kLaneBlock; ++l) wished[l] -= (double)wished[l] > shifted[l] ? 1 : 0;
}

inline void exchange_block(const bool is_even, const SplatLanes& in, int first, u32 quanta, u32 start,
                           SplatSums& sums) {
  Dealt dealt;
  deal_block(is_even, in, first, quanta, start, dealt);
  alignas(64) i32 wished[kLaneBlock];
  wish_block(in, first, dealt.mass, wished);
  const u16* __restrict amount = in.amount + first;
  const u16* __restrict weight = in.weight + first;
  i32* __restrict out = in.quanta + first;
  u16* __restrict left = in.left + first;
  u16* __restrict any = in.any + first;
  for (int l = 0; l < kLaneBlock; ++l) {
    const i32 there = amount[l];
    const i32 most = there < dealt.most_up[l] ? there : dealt.most_up[l];
    const i32 fits = kMaxQuanta - there;
    const i32 least = fits < dealt.most_down[l] ? fits : dealt.most_down[l];
    const i32 cut = wished[l] < most ? wished[l] : most;
    out[l] = cut > -least ? cut : -least;
  }
  for (int l = 0; l < kLaneBlock; ++l) {
    left[l] = (u16)((i32)amount[l] - out[l]);
    any[l] = (u16)(any[l] | (out[l] != 0 ? 1 : 0));
  }
  if (is_even) {
    i32 up = 0, down = 0;
    for (int l = 0; l < kLaneBlock; ++l) up += out[l] > 0 ? out[l] : 0;
    for (int l = 0; l < kLaneBlock; ++l) down += out[l] < 0 ? -out[l] : 0;
    sums.picked_up += (i64)up * (i64)in.middle_weight;
    sums.dropped += (i64)down * (i64)in.middle_weight;
    return;
  }
  i64 up = 0, down = 0;
  for (int l = 0; l < kLaneBlock; ++l) up += (i64)(out[l] > 0 ? out[l] : 0) * (i64)weight[l];
  for (int l = 0; l < kLaneBlock; ++l) down += (i64)(out[l] < 0 ? -out[l] : 0) * (i64)weight[l];
  sums.picked_up += up;
  sums.dropped += down;
}

void exchange_lanes(const SplatLanes& in, SplatSums& sums) {
  const u32 quanta = in.whole / in.middle_weight, start = mixed_bits(in.random, kDealPurpose) & 0xFFFFu;
  for (int first = 0; first < in.num; first += kLaneBlock) {
    if (in.is_even) {
      exchange_block(true, in, first, quanta, start, sums);
    } else {
      exchange_block(false, in, first, quanta, start, sums);
    }
  }
}

}  // namespace

extern const SplatKernel kKernel;
const SplatKernel kKernel = exchange_lanes;
