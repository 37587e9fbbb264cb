#include "transfer/synthesis/reference.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "transfer/synthesis/wavefronts.h"
#include "transfer/synthesis/window_search.h"

namespace patinate::transfer {

void describe(OptionVisitor& v, ReferenceOptions& o) {
  v.visit({"window", "reference: side of the search window", "px", between(8, 4096)}, o.window_px);
  v.visit({"tolerance", "reference: how near a window's center must be in control value", "", between(0, 1)},
          o.tolerance);
  v.visit({"reference_passes", "reference: passes over the atlas", "", between(1, 8)}, o.num_passes);
  v.visit({"first_coherence", "reference: coherence share of the first pass", "", between(0, 1)}, o.first_coherence);
}

namespace {

constexpr std::int64_t kChunk = 16;  // Texels: about a millisecond.

struct Position {
  std::int64_t x = 0, y = 0;
};

/// Weighted mean of where the known neighbors would put this texel; nothing when none is known.
std::optional<Position> mean_position(const SourceLevel& source, const Neighborhood& neighborhood,
                                      const TexelCost& cost, const CoordinateMap& coordinates) {
  std::int64_t x = 0, y = 0, weights = 0;
  for (std::size_t k = 0; k < neighborhood.offsets.size(); ++k) {
    const PixelNeighbor& n = cost.neighbor(k);
    const std::int32_t s = n.texel < 0 ? -1 : coordinates[static_cast<std::size_t>(n.texel)];
    if (s < 0) continue;
    x += neighborhood.weights[k] * std::int64_t{s % source.width() - whole_pixels(n.x)};
    y += neighborhood.weights[k] * std::int64_t{s / source.width() - whole_pixels(n.y)};
    weights += neighborhood.weights[k];
  }
  if (weights == 0) return std::nullopt;
  return Position{x / weights, y / weights};
}

/// Of 64 pixels of similar control value, the one nearest to the mean position.
Position window_center(const SourceLevel& source, std::span<const std::uint16_t> target, int tolerance,
                       const std::optional<Position>& mean, RandomStream& random) {
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

/// What the texel has from the pass before, and where the known neighbors would put it.
void likely_pixels(const SourceLevel& source, const Neighborhood& neighborhood, const TexelCost& cost,
                   const CoordinateMap& coordinates, std::int32_t own, std::vector<std::int32_t>& out) {
  out.assign(1, own);
  for (std::size_t k = 0; k < neighborhood.offsets.size(); ++k) {
    const PixelNeighbor& n = cost.neighbor(k);
    const std::int32_t s = n.texel < 0 ? -1 : coordinates[static_cast<std::size_t>(n.texel)];
    if (s < 0) continue;
    const int x = s % source.width() - whole_pixels(n.x), y = s / source.width() - whole_pixels(n.y);
    if (x < 0 || y < 0 || x >= source.width() || y >= source.height()) continue;
    const std::int32_t p = y * source.width() + x;
    if (std::find(out.begin(), out.end(), p) == out.end()) out.push_back(p);
  }
}

/// What one thread needs.
struct Worker {
  TexelCost cost;
  std::vector<std::int32_t> likely = {};
};

}  // namespace

CoordinateMap synthesize_reference(const SourceLevel& source, const DestinationLevel& destination,
                                   const Neighborhood& neighborhood, double coherence_share,
                                   std::span<const double> control_weights, std::uint64_t seed,
                                   const ReferenceOptions& options, const RunControl& control) {
  check_ranges(options);
  CoordinateMap coordinates(static_cast<std::size_t>(destination.map->num_texels()), -1);
  const int tolerance = static_cast<int>(options.tolerance * kControlSteps);
  const std::vector<std::vector<TexelId>> fronts = wavefronts(destination);
  RunControl silent = control;
  silent.on_progress = nullptr;
  const WindowSearch search(source, neighborhood, options.window_px, silent);
  for (int pass = 0; pass < options.num_passes; ++pass) {
    const double ramp = options.num_passes == 1 ? 1.0 : pass / (options.num_passes - 1.0);
    const EnergyScale scale = EnergyScale::make(
        source, options.first_coherence + (coherence_share - options.first_coherence) * ramp, control_weights);
    const auto place = [&](TexelId t, Worker& worker) {
      worker.cost.prepare(t, coordinates, scale);
      RandomStream random(seed, static_cast<std::uint64_t>(t), static_cast<std::uint32_t>(pass));
      const Position center = window_center(source, destination.target(t), tolerance,
                                            mean_position(source, neighborhood, worker.cost, coordinates), random);
      std::int32_t& own = coordinates[static_cast<std::size_t>(t)];
      likely_pixels(source, neighborhood, worker.cost, coordinates, own, worker.likely);
      own = search.find(worker.cost, search.window(center.x, center.y, options.window_px), worker.likely).pixel;
    };
    for (std::size_t f = 0; f < fronts.size(); ++f) {
      parallel_for(static_cast<std::int64_t>(fronts[f].size()), kChunk, silent,
                   [&](std::int64_t begin, std::int64_t end) {
                     Worker worker{.cost = TexelCost(source, destination, neighborhood)};
                     for (std::int64_t i = begin; i < end; ++i) place(fronts[f][static_cast<std::size_t>(i)], worker);
                   });
      control.report((pass + static_cast<double>(f + 1) / static_cast<double>(fronts.size() + 1)) / options.num_passes);
    }
  }
  control.report(1.0);
  return coordinates;
}

}  // namespace patinate::transfer
