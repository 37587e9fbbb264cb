#include "transfer/synthesis/multi_level.h"

#include <algorithm>

#include "transfer/synthesis/passes.h"

namespace patinate::transfer {

void describe(OptionVisitor& v, MultiLevelOptions& o) {
  v.visit({"levels", "fast: resolutions, from coarse to fine", "", between(1, 8)}, o.num_levels);
  v.visit({"coarse_passes", "fast: passes on each level but the finest", "", between(1, 16)}, o.coarse_passes);
  v.visit({"fine_passes", "fast: passes on the finest level", "", between(1, 16)}, o.fine_passes);
  v.visit({"random_candidates", "fast: candidates of similar control value a texel and pass", "", between(0, 64)},
          o.num_random);
  v.visit({"coarse_coherence",
           "fast: coherence share on the coarsest level; default 0.2, 0.6 where the source has structure", "",
           between(0, 1)},
          o.first_coherence);
  v.visit({"coherence_bonus", "fast: preference for continuing pieces of the source", "", between(0, 8)},
          o.coherence_bonus);
  v.visit({"reuse_penalty", "fast: preference for sources that are used rarely", "", between(0, 8)}, o.reuse_penalty);
}

namespace {

/// Rises from the coarsest level to the finest.
double coherence_of_level(std::size_t level, std::size_t coarsest, double coherence_share,
                          const MultiLevelOptions& options) {
  const double first = options.first_coherence.value_or(kFirstCoherence);
  const double ramp = coarsest == 0 ? 1.0 : 1.0 - static_cast<double>(level) / static_cast<double>(coarsest);
  return first + (coherence_share - first) * ramp;
}

/// Pixels that look alike, taken over from the coarser level where there are many. @param coarser  Null: the coarsest.
SimilarPixels similar_of_level(const SourceLevel& source, const SourceLevel* coarser, const SimilarPixels& of_coarser,
                               const RunControl& control) {
  constexpr std::size_t kMaxSearchedPixels = 17'000;
  const bool is_searched = coarser == nullptr || source.usable.size() <= kMaxSearchedPixels;
  return is_searched ? find_similar_pixels(source, control) : refine_similar_pixels(of_coarser, *coarser, source);
}

/// Of random numbers, of a pass.
std::uint32_t stream_of(std::size_t level, int pass) {
  return static_cast<std::uint32_t>(200 + 32 * level + static_cast<std::size_t>(pass));
}

}  // namespace

PlaceMap synthesize_multi_level(std::vector<SynthesisLevel>& levels, const Neighborhood& neighborhood,
                                double coherence_share, std::span<const double> control_weights, std::uint64_t seed,
                                const MultiLevelOptions& options, const RunControl& control,
                                const LevelRefinement& refinement, const SearchDevice* device,
                                std::unique_ptr<SearchDevice::Level>* kept) {
  check_ranges(options);
  RunControl silent = control;
  silent.on_progress = nullptr;
  const std::size_t coarsest = levels.size() - 1;
  PlaceMap places = initial_places(levels[coarsest], seed, silent);
  SimilarPixels similar;
  double done = 0.0, total = 0.0;
  const auto passes_on = [&](std::size_t l) {
    if (l + 1 < refinement.num_levels && levels[l].destination.placement.turns != nullptr) return 0;
    return l == 0 ? options.fine_passes : options.coarse_passes;
  };
  const auto work = [&](std::size_t l) {
    return static_cast<double>(levels[l].destination.texels.size()) * (passes_on(l) + refinement.num_passes);
  };
  for (std::size_t l = 0; l < levels.size(); ++l) total += work(l);
  for (std::size_t l = levels.size(); l-- > 0;) {
    SynthesisLevel& level = levels[l];
    if (!level.destination.neighbors) find_neighbors(level.destination, neighborhood, silent);
    similar = similar_of_level(level.source, l == coarsest ? nullptr : &levels[l + 1].source, similar, silent);
    if (l < coarsest) {
      places = upsample(places, levels[l + 1], level, seed + l, silent);
      levels[l + 1] = {};
    }
    const EnergyScale scale =
        EnergyScale::make(level.source, coherence_of_level(l, coarsest, coherence_share, options), control_weights);
    const int num_passes = passes_on(l);
    Improver improver(level, neighborhood, similar, scale, options.num_random, seed, device);
    for (int pass = 0; pass < num_passes; ++pass) {
      const bool is_last = l == 0 && pass + 1 == num_passes;  // The last word is the energy's.
      improver.pass(is_last ? kEnergyAlone : preferences_of(options), is_last, stream_of(l, pass),
                    is_last ? PlaceCounts{} : improver.count(places, silent), places, silent);
      if (!improver.has_device()) device = nullptr;
      done += work(l) / (num_passes + refinement.num_passes);
      control.report(std::min(0.999, done / std::max(1.0, total)));
    }
    if (refinement.refine) {
      const double end = done + work(l) * refinement.num_passes / (num_passes + refinement.num_passes);
      refinement.refine(l, level, similar, places,
                        control.part(std::min(0.999, done / total), std::min(0.999, end / total)));
      done = end;
    }
    if (l == 0 && kept != nullptr) *kept = improver.take_device_level();
    if (l > 0) level.destination.neighbors.reset();
  }
  control.report(1.0);
  return places;
}

}  // namespace patinate::transfer
