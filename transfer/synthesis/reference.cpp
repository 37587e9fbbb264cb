#include "transfer/synthesis/reference.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/wavefronts.h"
#include "transfer/synthesis/window_search.h"

namespace patinate::transfer {

void describe(OptionVisitor& v, ReferenceOptions& o) {
  v.visit({"window", "reference: side of the search window", "px", between(8, 4096)}, o.window_px);
  v.visit({"tolerance", "reference: largest difference in control value between a texel and the center of its window",
           "", between(0, 1)},
          o.tolerance);
  v.visit({"reference_passes", "reference: passes over the atlas", "", between(1, 8)}, o.num_passes);
  v.visit({"epsilon", "reference: choose at random among pixels that cost at most (1 + this) times the least cost", "",
           between(0, 1)},
          o.epsilon);
  v.visit(
      {"first_coherence", "reference: coherence share of the first pass; default: the final one", "", between(0, 1)},
      o.first_coherence);
}

namespace {

constexpr std::int64_t kReferenceChunk = 16;  // Texels: about a millisecond.

struct Position {
  std::int64_t x = 0, y = 0;
};

/// Weighted mean of where the known neighbors would put this texel; nothing when none is known.
std::optional<Position> mean_position(const Neighborhood& neighborhood, const TexelCost& cost, const PlaceMap& places) {
  const search_kernel::PlaceTables tables = places.tables();
  std::int64_t x = 0, y = 0, weights = 0;
  for (std::size_t k = 0; k < neighborhood.offsets.size(); ++k) {
    const PixelNeighbor& n = cost.neighbor(k);
    if (!window_kernel::has_place(tables.pixels, n)) continue;
    const FixedPoint from = places.point(n.texel);
    x += neighborhood.weights[k] * std::int64_t{from.x - n.x};
    y += neighborhood.weights[k] * std::int64_t{from.y - n.y};
    weights += neighborhood.weights[k];
  }
  if (weights == 0) return std::nullopt;
  return Position{window_kernel::mean_place(x, weights), window_kernel::mean_place(y, weights)};
}

/// Center of a window: of 64 pixels of similar control value, the one nearest to the mean position.
Position window_center(const SourceLevel& source, std::span<const std::uint16_t> target, int tolerance,
                       const std::optional<Position>& mean, RandomStream& random) {
  const auto similar = source.similar(target, tolerance);
  Position best;
  std::int64_t best_distance = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < (mean ? window_kernel::kWindowTries : 1); ++i) {
    const std::int32_t p = similar[random.below(static_cast<std::uint32_t>(similar.size()))];
    const std::int64_t distance = mean ? window_kernel::squared_apart(p, source.width(), mean->x, mean->y) : 0;
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = {p % source.width(), p / source.width()};
  }
  return best;
}

/// Places of the texel from the pass before, and where the known neighbors would put it, the nearest first.
void likely_places(const SourceLevel& source, const Neighborhood& neighborhood, const TexelCost& cost,
                   const PlaceMap& places, TexelId own, std::vector<Place>& out) {
  const search_kernel::SourceTables from = source_tables(source);
  const search_kernel::PlaceTables tables = places.tables();
  out.clear();
  if (const Place now = places.at(own); now.pixel >= 0) out.push_back(now);
  for (std::size_t k = 0; k < neighborhood.offsets.size(); ++k) {
    const PixelNeighbor& n = cost.neighbor(k);
    if (!window_kernel::has_place(tables.pixels, n)) continue;
    const search_kernel::FixedPlace place = window_kernel::led_place(&from, &tables, n);
    if (place.pixel >= 0 &&
        std::none_of(out.begin(), out.end(), [&](const Place& p) { return p.pixel == place.pixel; }))
      out.push_back({place.pixel, {place.x, place.y}});
  }
}

/// Data that one thread needs.
struct Worker {
  TexelCost cost;
  std::vector<Place> likely = {};
  std::vector<std::int32_t> likely_pixels = {};
};

/// A piece that goes on keeps its fractions, so that it keeps its shape on turned and stretched texels.
Place with_fraction(const SourceLevel& source, std::int32_t pixel, const std::vector<Place>& likely) {
  const auto same = std::find_if(likely.begin(), likely.end(), [&](const Place& p) { return p.pixel == pixel; });
  return same != likely.end() ? *same : place_of(source, pixel);
}

/// A place of a piece that goes on beside the middles of pixels, and what it costs there.
struct FractionalPlace {
  Place place;
  std::int64_t cost = 0;
};

/// Those of the likely places that lie beside the middle of their pixel and cost at most `bound` there.
std::vector<FractionalPlace> fractional_within(const TexelCost& cost, const std::vector<Place>& likely,
                                               std::int64_t bound) {
  std::vector<FractionalPlace> found;
  for (const Place& place : likely) {
    const PlaceMap::Beside beside = PlaceMap::beside_of(place);
    if (beside.x == 0 && beside.y == 0) continue;
    const std::int64_t there = cost.total_beside(place.pixel, beside.x, beside.y, bound + 1);
    if (there <= bound) found.push_back({place, there});
  }
  return found;
}

/// One of all that cost at most 1 + epsilon of the least, by chance: pixels of the window, and places of pieces that go
/// on. @param best  Of the window and the likely pixels.
Place choose_good(const WindowSearch& search, const TexelCost& cost, const SearchWindow& window,
                  const WindowOptimum& best, const SourceLevel& source, const std::vector<Place>& likely,
                  double epsilon, RandomStream& random) {
  const auto loosened = [&](std::int64_t least) { return window_kernel::loosened_cost(least, epsilon); };
  std::vector<FractionalPlace> going_on = fractional_within(cost, likely, loosened(best.cost));
  std::int64_t least = best.cost;
  for (const FractionalPlace& p : going_on) least = std::min(least, p.cost);
  std::erase_if(going_on, [&](const FractionalPlace& p) { return p.cost > loosened(least); });
  std::vector<std::int32_t> pixels;
  if (epsilon > 0.0)
    pixels = search.find_within(cost, window, loosened(least));
  else if (going_on.empty())
    pixels.push_back(best.pixel);
  const auto chosen =
      random.below(static_cast<std::uint32_t>(std::max<std::size_t>(1, pixels.size() + going_on.size())));
  if (chosen < pixels.size()) return with_fraction(source, pixels[chosen], likely);
  if (chosen - pixels.size() < going_on.size()) return going_on[chosen - pixels.size()].place;
  return with_fraction(source, best.pixel, likely);
}

/// Searches for all texels of a front at the same time.
class FrontSearch {
 public:
  FrontSearch(const SourceLevel& source, const DestinationLevel& destination, const Neighborhood& neighborhood,
              std::uint64_t seed, const ReferenceOptions& options, const RunControl& control)
      : source_(source),
        destination_(destination),
        neighborhood_(neighborhood),
        seed_(seed),
        options_(options),
        control_(control),
        search_(source, neighborhood, options.window_px, control) {}

  /// The texels of a front get places.
  void place(const std::vector<TexelId>& front, const EnergyScale& scale, int pass, PlaceMap& places) {
    parallel_for(static_cast<std::int64_t>(front.size()), kReferenceChunk, control_,
                 [&](std::int64_t begin, std::int64_t end) {
                   Worker worker{.cost = TexelCost(source_, destination_, neighborhood_)};
                   for (std::int64_t i = begin; i < end; ++i) {
                     const TexelId t = front[i];
                     worker.cost.prepare(t, places.pixels, scale);
                     place(t, RandomStream(seed_, static_cast<std::uint64_t>(t), static_cast<std::uint32_t>(pass)),
                           worker, places);
                   }
                 });
  }

 private:
  void place(TexelId t, RandomStream random, Worker& worker, PlaceMap& places) const {
    const int tolerance = static_cast<int>(options_.tolerance * kControlSteps);
    const Position center = window_center(source_, destination_.target(t), tolerance,
                                          mean_position(neighborhood_, worker.cost, places), random);
    likely_places(source_, neighborhood_, worker.cost, places, t, worker.likely);
    worker.likely_pixels.clear();
    for (const Place& p : worker.likely) worker.likely_pixels.push_back(p.pixel);
    const SearchWindow window = search_.window(center.x, center.y, options_.window_px);
    const WindowOptimum best = search_.find(worker.cost, window, worker.likely_pixels);
    if (best.pixel < 0) return;
    places.set(t, choose_good(search_, worker.cost, window, best, source_, worker.likely, options_.epsilon, random));
  }

  const SourceLevel& source_;
  const DestinationLevel& destination_;
  const Neighborhood& neighborhood_;
  std::uint64_t seed_;
  const ReferenceOptions& options_;
  const RunControl& control_;
  WindowSearch search_;
};

}  // namespace

CoordinateMap synthesize_reference(const SourceLevel& source, const DestinationLevel& destination,
                                   const Neighborhood& neighborhood, double coherence_share,
                                   std::span<const double> control_weights, std::uint64_t seed,
                                   const ReferenceOptions& options, const RunControl& control) {
  check_ranges(options);
  PlaceMap places(destination.map->num_texels(), source.width());
  const std::vector<std::vector<TexelId>> fronts = wavefronts(destination);
  RunControl silent = control;
  silent.on_progress = nullptr;
  FrontSearch search(source, destination, neighborhood, seed, options, silent);
  const double first_coherence = options.first_coherence.value_or(coherence_share);
  for (int pass = 0; pass < options.num_passes; ++pass) {
    const double ramp = options.num_passes == 1 ? 1.0 : pass / (options.num_passes - 1.0);
    const EnergyScale scale =
        EnergyScale::make(source, first_coherence + (coherence_share - first_coherence) * ramp, control_weights);
    for (std::size_t f = 0; f < fronts.size(); ++f) {
      search.place(fronts[f], scale, pass, places);
      control.report((pass + static_cast<double>(f + 1) / static_cast<double>(fronts.size() + 1)) / options.num_passes);
    }
  }
  control.report(1.0);
  return std::move(places.pixels);
}

}  // namespace patinate::transfer
