#include "simulation/transport/transfer.h"

#include "libcommon/core/portable_math.h"
#include "libcommon/core/random.h"

namespace patinate::simulation {

namespace {
constexpr std::uint32_t kTransferPurpose = 0x74726E73u;  // keeps this use of the scene's seed apart from others
}  // namespace

TransferShares transfer_shares(double ratio, double rate, double contact, std::uint32_t weight, double area_share) {
  const double area = area_share * static_cast<double>(SurfaceAtlas::kMedianWeight) / static_cast<double>(weight);
  const double rising = area * (1.0 - ratio);
  const double lambda = rising + ratio;  // > 0: area is
  const double gone = portable_decayed(rate * lambda * contact);
  return {.up = rising / lambda * gone, .down = ratio / lambda * gone / static_cast<double>(weight)};
}

std::array<std::uint32_t, kMaxMaterials> transfer_randoms(std::uint64_t seed, std::uint32_t gammaton,
                                                          std::int64_t iteration, std::uint32_t piece,
                                                          int num_materials) {
  std::array<std::uint32_t, kMaxMaterials> out{};
  const std::array<std::uint32_t, 2> key{static_cast<std::uint32_t>(seed) ^ kTransferPurpose,
                                         static_cast<std::uint32_t>(seed >> 32)};
  const auto time = static_cast<std::uint64_t>(iteration);
  for (std::uint32_t block = 0; static_cast<int>(4 * block) < num_materials; ++block) {
    const std::array<std::uint32_t, 4> four = philox4x32(
        {static_cast<std::uint32_t>(time), gammaton, piece << 1 | block, static_cast<std::uint32_t>(time >> 32)}, key);
    for (std::size_t i = 0; i < 4; ++i) out[4 * block + i] = four[i];
  }
  return out;
}

}  // namespace patinate::simulation
