#include "transfer/synthesis/places.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"

namespace patinate::transfer {

namespace {

constexpr std::int32_t kPlaceUnit = PixelNeighbor::kOne;

std::int32_t rounded_to_step(double v) { return static_cast<std::int32_t>(std::floor(v + 0.5)); }

constexpr std::int64_t kPlaceChunk = 16384;  // Texels.

}  // namespace

PlaceMap initial_places(const SynthesisLevel& level, std::uint64_t seed, const RunControl& control) {
  const DestinationLevel& destination = level.destination;
  PlaceMap places(destination.map->num_texels(), level.source.width(), destination.part != nullptr);
  parallel_for(static_cast<std::int64_t>(destination.texels.size()), kPlaceChunk, control,
               [&](std::int64_t begin, std::int64_t end) {
                 auto at = destination.texels.from(static_cast<std::size_t>(begin));
                 for (std::int64_t i = begin; i < end; ++i, ++at) {
                   const TexelId t = *at;
                   RandomStream random(seed, static_cast<std::uint64_t>(t), 100);
                   const auto similar = level.source.similar(destination.target(t), kSimilarTolerance);
                   places.set(
                       t, place_of(level.source, similar[random.below(static_cast<std::uint32_t>(similar.size()))]));
                 }
               });
  return places;
}

PlaceMap upsample(const PlaceMap& coarse, const SynthesisLevel& coarse_level, const SynthesisLevel& fine_level,
                  std::uint64_t seed, const RunControl& control) {
  PlaceMap fine = initial_places(fine_level, seed, control);
  const TexelMap &fine_map = *fine_level.destination.map, &coarse_map = *coarse_level.destination.map;
  const auto place_some = [&](std::int64_t begin, std::int64_t end) {
    Eigen::Matrix2d half_step = Eigen::Matrix2d::Zero();  // Of half a fine texel.
    int triangle = -1;
    auto at = fine_level.destination.texels.from(static_cast<std::size_t>(begin));
    for (std::int64_t i = begin; i < end; ++i, ++at) {
      const TexelId t = *at;
      const int x = static_cast<int>(t % fine_map.width()), y = static_cast<int>(t / fine_map.width());
      const int px = std::min(x / 2, coarse_map.width() - 1), py = std::min(y / 2, coarse_map.height() - 1);
      const Place parent = coarse.at(TexelId{py} * coarse_map.width() + px);
      if (parent.pixel < 0) continue;
      if (fine_map.triangle(t) != triangle) {
        triangle = fine_map.triangle(t);
        half_step =
            fine_level.destination.neighbors->pixels_per_texel(triangle) * (0.5 * static_cast<double>(kPlaceUnit));
      }
      // Middles of pixels are whole numbers, so that a coarse pixel's middle lies half a fine pixel beside one.
      const Vec2 beside = half_step * Vec2(2 * (x - 2 * px) - 1, 2 * (y - 2 * py) - 1);
      const auto doubled = [&](std::int32_t along) {
        return 2 * (along - coarse_level.source.margin_px * kPlaceUnit) + kPlaceUnit / 2 +
               fine_level.source.margin_px * kPlaceUnit;
      };
      const Place place = place_at(fine_level.source, {doubled(parent.point.x) + rounded_to_step(beside.x()),
                                                       doubled(parent.point.y) + rounded_to_step(beside.y())});
      if (place.pixel >= 0) fine.set(t, place);
    }
  };
  parallel_for(static_cast<std::int64_t>(fine_level.destination.texels.size()), kPlaceChunk, control, place_some);
  return fine;
}

}  // namespace patinate::transfer
