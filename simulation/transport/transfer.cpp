#include "simulation/transport/transfer.h"

#include "simulation/transport/splat.h"

namespace patinate::simulation {

static_assert(transfer_kernel::kMedianTexelWeight == SurfaceAtlas::kMedianWeight);
static_assert(transfer_kernel::kMostQuanta == kMaxAmount);
static_assert(transfer_kernel::kWholeSplat == SplatShape::kWhole);
static_assert(transfer_kernel::kMostParts == SplatShape::kMaxParts);

TransferShares transfer_shares(double ratio, double rate, double contact, std::uint32_t weight, double area_share) {
  return transfer_kernel::transfer_shares_of(ratio, rate, contact, weight, area_share);
}

std::array<std::uint32_t, kMaxMaterials> transfer_randoms(std::uint64_t seed, std::uint32_t gammaton,
                                                          std::int64_t iteration, std::uint32_t piece,
                                                          int num_materials) {
  std::array<std::uint32_t, kMaxMaterials> out{};
  for (std::uint32_t block = 0; static_cast<int>(4 * block) < num_materials; ++block) {
    transfer_kernel::transfer_random_block(seed, gammaton, static_cast<std::uint64_t>(iteration), piece, block,
                                           out.data() + 4 * block);
  }
  return out;
}

}  // namespace patinate::simulation
