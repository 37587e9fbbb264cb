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

/// The coarse texel that a fine one lies in; at a chart's border, where that has no place, the nearest beside it that
/// has one and is of the same chart; -1 if there is none.
TexelId parent_of(const TexelMap& fine, const TexelMap& coarse, const PlaceMap& places, TexelId t) {
  const int x = static_cast<int>(t % fine.width()), y = static_cast<int>(t / fine.width());
  const int px = std::min(x / 2, coarse.width() - 1), py = std::min(y / 2, coarse.height() - 1);
  const auto has_place = [&](TexelId p) { return places.pixels[p] >= 0; };
  const TexelId above = TexelId{py} * coarse.width() + px;
  if (has_place(above)) return above;
  TexelId nearest = -1;
  int least = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int u = px + dx, v = py + dy;
      if (u < 0 || v < 0 || u >= coarse.width() || v >= coarse.height()) continue;
      const TexelId p = TexelId{v} * coarse.width() + u;
      if (!coarse.is_covered(p) || !has_place(p) || coarse.chart(p) != fine.chart(t)) continue;
      const int across = 2 * (x - 2 * u) - 1, down = 2 * (y - 2 * v) - 1, distance = across * across + down * down;
      if (nearest < 0 || distance < least) nearest = p, least = distance;
    }
  }
  return nearest;
}

}  // namespace

PlaceMap initial_places(const SynthesisLevel& level, std::uint64_t seed, const RunControl& control) {
  const DestinationLevel& destination = level.destination;
  PlaceMap places(destination.map->num_texels(), level.source.width());
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
  const FrameTurns* const frame_turns = fine_level.destination.placement.turns.get();
  if (frame_turns != nullptr) fine.keep_turns();
  const TexelMap &fine_map = *fine_level.destination.map, &coarse_map = *coarse_level.destination.map;
  const auto place_some = [&](std::int64_t begin, std::int64_t end) {
    Eigen::Matrix2d half_step = Eigen::Matrix2d::Zero();  // Half step of half a fine texel.
    int triangle = -1;
    auto at = fine_level.destination.texels.from(static_cast<std::size_t>(begin));
    for (std::int64_t i = begin; i < end; ++i, ++at) {
      const TexelId t = *at;
      const int x = static_cast<int>(t % fine_map.width()), y = static_cast<int>(t / fine_map.width());
      const TexelId above = parent_of(fine_map, coarse_map, coarse, t);
      if (above < 0) continue;
      const int px = static_cast<int>(above % coarse_map.width()), py = static_cast<int>(above / coarse_map.width());
      const Place parent = coarse.at(above);
      if (fine_map.triangle(t) != triangle) {
        triangle = fine_map.triangle(t);
        half_step =
            fine_level.destination.neighbors->pixels_per_texel(triangle) * (0.5 * static_cast<double>(kPlaceUnit));
      }
      // Middles of pixels are whole numbers, so that a coarse pixel's middle lies half a fine pixel beside one.
      const Vec2 beside = half_step * Vec2(2 * (x - 2 * px) - 1, 2 * (y - 2 * py) - 1);
      const Turn turn = frame_turns == nullptr
                            ? Turn{0}
                            : sum_of(parent.turn, frame_turns->between(coarse_map.triangle(above), triangle));
      const FixedPoint step = turned({rounded_to_step(beside.x()), rounded_to_step(beside.y())}, turn);
      const auto doubled = [&](std::int32_t along) {
        return 2 * (along - coarse_level.source.margin_px * kPlaceUnit) + kPlaceUnit / 2 +
               fine_level.source.margin_px * kPlaceUnit;
      };
      const Place place =
          place_at(fine_level.source, {doubled(parent.point.x) + step.x, doubled(parent.point.y) + step.y}, turn);
      if (place.pixel >= 0) fine.set(t, place);
    }
  };
  parallel_for(static_cast<std::int64_t>(fine_level.destination.texels.size()), kPlaceChunk, control, place_some);
  return fine;
}

}  // namespace patinate::transfer
