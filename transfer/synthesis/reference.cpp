#include "transfer/synthesis/reference.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "libcommon/core/random.h"

namespace patinate {

void describe(OptionVisitor& v, ReferenceOptions& o) {
  v.visit({"window", "reference: side of the search window", "px", between(8, 4096)}, o.window_px);
  v.visit({"tolerance", "reference: how near a window's centre must be in control value", "", between(0, 1)}, o.tolerance);
  v.visit({"reference_passes", "reference: passes over the atlas", "", between(1, 8)}, o.num_passes);
  v.visit({"first_coherence", "reference: coherence share of the first pass", "", between(0, 1)}, o.first_coherence);
}

namespace {

struct Position {
  std::int64_t x = 0, y = 0;
};

/// Weighted mean of where the known neighbours would put this texel; nothing when none is known.
std::optional<Position> mean_position(const SourceLevel& source, const Neighborhood& neighborhood, const TexelCost& cost,
                                      const CoordinateMap& coordinates) {
  std::int64_t x = 0, y = 0, weights = 0;
  for (std::size_t k = 0; k < neighborhood.offsets.size(); ++k) {
    const TexelId n = cost.neighbor(k);
    const std::int32_t s = n < 0 ? -1 : coordinates[static_cast<std::size_t>(n)];
    if (s < 0) continue;
    x += neighborhood.weights[k] * std::int64_t{s % source.width() - neighborhood.offsets[k].x};
    y += neighborhood.weights[k] * std::int64_t{s / source.width() - neighborhood.offsets[k].y};
    weights += neighborhood.weights[k];
  }
  if (weights == 0) return std::nullopt;
  return Position{x / weights, y / weights};
}

/// Of 64 pixels of similar control value, the one nearest to the mean position.
Position window_centre(const SourceLevel& source, std::span<const std::uint16_t> target, int tolerance, const std::optional<Position>& mean,
                       RandomStream& random) {
  constexpr int kTries = 64;
  const auto similar = source.similar(target, tolerance);
  Position best;
  std::int64_t best_distance = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < (mean ? kTries : 1); ++i) {
    const std::int32_t p = similar[random.below(static_cast<std::uint32_t>(similar.size()))];
    const Position candidate{p % source.width(), p / source.width()};
    const std::int64_t dx = mean ? candidate.x - mean->x : 0, dy = mean ? candidate.y - mean->y : 0;
    if (dx * dx + dy * dy < best_distance) {
      best_distance = dx * dx + dy * dy;
      best = candidate;
    }
  }
  return best;
}

std::int32_t search_window(const SourceLevel& source, const TexelCost& cost, const Position& centre, int side) {
  const std::int64_t x0 = std::clamp<std::int64_t>(centre.x - side / 2, 0, std::max(0, source.width() - side));
  const std::int64_t y0 = std::clamp<std::int64_t>(centre.y - side / 2, 0, std::max(0, source.height() - side));
  const std::int64_t x1 = std::min<std::int64_t>(source.width(), x0 + side), y1 = std::min<std::int64_t>(source.height(), y0 + side);
  std::int32_t best = -1;
  std::int64_t best_cost = std::numeric_limits<std::int64_t>::max();
  for (std::int64_t y = y0; y < y1; ++y) {
    for (std::int64_t x = x0; x < x1; ++x) {
      const auto p = static_cast<std::int32_t>(y * source.width() + x);
      if (source.is_usable[static_cast<std::size_t>(p)] == 0) continue;
      const std::int64_t c = cost.total(p, best_cost);
      if (c < best_cost) {
        best_cost = c;
        best = p;
      }
    }
  }
  return best;
}

}  // namespace

CoordinateMap synthesise_reference(const SourceLevel& source, const DestinationLevel& destination,
                                   const Neighborhood& neighborhood, double coherence_share,
                                   std::span<const double> control_weights, std::uint64_t seed,
                                   const ReferenceOptions& options, const RunControl& control) {
  check_ranges(options);
  CoordinateMap coordinates(static_cast<std::size_t>(destination.map->num_texels()), -1);
  TexelCost cost(source, destination, neighborhood);
  const int tolerance = static_cast<int>(options.tolerance * kControlSteps);
  const std::size_t n = destination.texels.size();
  for (int pass = 0; pass < options.num_passes; ++pass) {
    const double ramp = options.num_passes == 1 ? 1.0 : pass / (options.num_passes - 1.0);
    const EnergyScale scale = EnergyScale::make(
        source, options.first_coherence + (coherence_share - options.first_coherence) * ramp, control_weights);
    for (std::size_t i = 0; i < n; ++i) {
      control.throw_if_stopped();
      if (i % 64 == 0) {
        control.report((pass + static_cast<double>(i) / static_cast<double>(n)) / options.num_passes);
      }
      const TexelId t = destination.texels[i];
      cost.prepare(t, coordinates, scale);
      RandomStream random(seed, static_cast<std::uint64_t>(t), static_cast<std::uint32_t>(pass));
      const Position centre =
          window_centre(source, destination.target(t), tolerance, mean_position(source, neighborhood, cost, coordinates), random);
      coordinates[static_cast<std::size_t>(t)] = search_window(source, cost, centre, options.window_px);
    }
  }
  control.report(1.0);
  return coordinates;
}

}  // namespace patinate
