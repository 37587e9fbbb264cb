#include "libcommon/output/cushions.h"

#include <array>
#include <cmath>

#include "libcommon/core/random.h"
#include "libcommon/output/sampling.h"

namespace patinate {

namespace {

constexpr std::uint32_t kCushion = 35;  // Purpose of random streams.
constexpr double kMinRadius = 0.17;     // Share of a cube's side; the largest have half of it.

}  // namespace

CushionPlace cushion_at(const Vec3& position, double size) {
  CushionPlace best;
  const Vec3 scaled = position / size;
  const Vec3 cell = scaled.array().floor();
  for (int k = 0; k < 27; ++k) {
    const Vec3 near = cell + Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    std::uint64_t item = 0;
    for (int c = 0; c < 3; ++c)
      item = item * 0x1FFFFFu + static_cast<std::uint64_t>(static_cast<std::int64_t>(near[c]) + 0x100000);
    RandomStream random(kRenderSeed, item, kCushion);
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    const double share = random.uniform(), radius = kMinRadius + (0.5 - kMinRadius) * share * share;
    const Vec3 outward = (scaled - near - Vec3(x, y, z)) / radius;
    const double depth = 1.0 - outward.squaredNorm(), height = depth * radius / 0.5;
    const double tone = random.uniform();
    if (height > best.height) best = {.depth = depth, .height = height, .outward = outward, .tone = tone};
  }
  return best;
}

}  // namespace patinate
