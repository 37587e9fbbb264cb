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

/// Where a fine texel lies in its parent, by the fine level's pixels. One for each thread.
class StepsInParent {
 public:
  StepsInParent(const SynthesisLevel& fine, const SynthesisLevel& coarse)
      : fine_(fine), coarse_(coarse), turns_(fine.destination.placement.turns.get()) {}

  /// Looks up the triangles that both are in.
  void visit(TexelId texel, TexelId parent) {
    const int triangle = fine_.destination.map->triangle(texel);
    if (triangle != triangle_) {
      triangle_ = triangle;
      half_step_ = fine_.destination.neighbors->pixels_per_texel(triangle) * (0.5 * static_cast<double>(kPlaceUnit));
    }
    turn_ = turns_ == nullptr ? Turn{0} : turns_->between(coarse_.destination.map->triangle(parent), triangle);
    const std::int64_t width = fine_.destination.map->width(), coarse_width = coarse_.destination.map->width();
    // Middles of pixels are whole numbers, so that a coarse pixel's middle lies half a fine pixel beside one.
    beside_ = half_step_ * Vec2(static_cast<double>(2 * (texel % width - 2 * (parent % coarse_width)) - 1),
                                static_cast<double>(2 * (texel / width - 2 * (parent / coarse_width)) - 1));
  }
  /// The texel's place by its parent's.
  [[nodiscard]] Place below(const Place& parent) const {
    const Turn turn = sum_of(parent.turn, turn_);
    const FixedPoint step = this->step(turn);
    const auto doubled = [&](std::int32_t along) {
      return 2 * (along - coarse_.source.margin_px * kPlaceUnit) + kPlaceUnit / 2 + fine_.source.margin_px * kPlaceUnit;
    };
    return place_at(fine_.source, {doubled(parent.point.x) + step.x, doubled(parent.point.y) + step.y}, turn);
  }
  /// The parent's place by the texel's.
  [[nodiscard]] Place above(const Place& texel) const {
    const FixedPoint step = this->step(texel.turn);
    const auto halved = [&](std::int32_t along) {
      return ((along - kPlaceUnit / 2 - fine_.source.margin_px * kPlaceUnit) >> 1) +
             coarse_.source.margin_px * kPlaceUnit;
    };
    return place_at(coarse_.source, {halved(texel.point.x - step.x), halved(texel.point.y - step.y)},
                    difference_of(texel.turn, turn_));
  }

 private:
  [[nodiscard]] FixedPoint step(Turn turn) const {
    return turned({rounded_to_step(beside_.x()), rounded_to_step(beside_.y())}, turn);
  }

  const SynthesisLevel &fine_, &coarse_;
  const FrameTurns* turns_;
  int triangle_ = -1;
  Eigen::Matrix2d half_step_ = Eigen::Matrix2d::Zero();  ///< Half step of half a fine texel.
  Vec2 beside_{0.0, 0.0};
  Turn turn_ = 0;  ///< Between the frames of both.
};

/// The first covered texel that lies in a coarse one and has a place, one of its chart before others; -1 if there is
/// none.
TexelId child_of(const TexelMap& fine, const TexelMap& coarse, const PlaceMap& places, TexelId t) {
  const auto x = static_cast<int>(t % coarse.width()), y = static_cast<int>(t / coarse.width());
  TexelId first = -1;
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      if (!fine.rect().contains(2 * x + dx, 2 * y + dy)) continue;
      const TexelId child = TexelId{2 * y + dy} * fine.width() + 2 * x + dx;
      if (!fine.is_covered(child) || places.pixels[child] < 0) continue;
      if (fine.chart(child) == coarse.chart(t)) return child;
      if (first < 0) first = child;
    }
  }
  return first;
}

/// Calls visit(texel) for some texels, in chunks. @param start  Makes what a thread visits with.
template <class Start>
void for_texels(const TexelSet& texels, const RunControl& control, const Start& start) {
  parallel_for(static_cast<std::int64_t>(texels.size()), kPlaceChunk, control,
               [&](std::int64_t begin, std::int64_t end) {
                 auto visit = start();
                 auto at = texels.from(static_cast<std::size_t>(begin));
                 for (std::int64_t i = begin; i < end; ++i, ++at) visit(*at);
               });
}

}  // namespace

void set_initial_places(const SynthesisLevel& level, const TexelSet& texels, std::uint64_t seed, PlaceMap& places,
                        const RunControl& control) {
  for_texels(texels, control, [&] {
    return [&](TexelId t) {
      RandomStream random(seed, static_cast<std::uint64_t>(t), 100);
      const auto similar = level.source.similar(level.destination.target(t), kSimilarTolerance);
      places.set(t, place_of(level.source, similar[random.below(static_cast<std::uint32_t>(similar.size()))]));
    };
  });
}

PlaceMap initial_places(const SynthesisLevel& level, std::uint64_t seed, const RunControl& control) {
  PlaceMap places(level.destination.map->num_texels(), level.source.width());
  set_initial_places(level, level.destination.texels, seed, places, control);
  return places;
}

void upsample_texels(const PlaceMap& coarse, const SynthesisLevel& coarse_level, const SynthesisLevel& fine_level,
                     const TexelSet& texels, PlaceMap& fine, const RunControl& control) {
  const TexelMap &fine_map = *fine_level.destination.map, &coarse_map = *coarse_level.destination.map;
  for_texels(texels, control, [&] {
    return [&, steps = StepsInParent(fine_level, coarse_level)](TexelId t) mutable {
      const TexelId above = parent_of(fine_map, coarse_map, coarse, t);
      if (above < 0) return;
      steps.visit(t, above);
      const Place place = steps.below(coarse.at(above));
      if (place.pixel >= 0) fine.set(t, place);
    };
  });
}

PlaceMap upsample(const PlaceMap& coarse, const SynthesisLevel& coarse_level, const SynthesisLevel& fine_level,
                  std::uint64_t seed, const RunControl& control) {
  PlaceMap fine = initial_places(fine_level, seed, control);
  if (fine_level.destination.placement.turns != nullptr) fine.keep_turns();
  upsample_texels(coarse, coarse_level, fine_level, fine_level.destination.texels, fine, control);
  return fine;
}

void downsample_texels(const PlaceMap& fine, const SynthesisLevel& fine_level, const SynthesisLevel& coarse_level,
                       const TexelSet& texels, PlaceMap& coarse, const RunControl& control) {
  const TexelMap &fine_map = *fine_level.destination.map, &coarse_map = *coarse_level.destination.map;
  for_texels(texels, control, [&] {
    return [&, steps = StepsInParent(fine_level, coarse_level)](TexelId t) mutable {
      const TexelId child = child_of(fine_map, coarse_map, fine, t);
      if (child < 0) return;
      steps.visit(child, t);
      const Place place = steps.above(fine.at(child));
      if (place.pixel >= 0) coarse.set(t, place);
    };
  });
}

}  // namespace patinate::transfer
