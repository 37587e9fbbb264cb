#include "transfer/synthesis/multi_level.h"

#include <algorithm>
#include <array>
#include <limits>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/similar_pixels.h"

namespace patinate {

void describe(OptionVisitor& v, MultiLevelOptions& o) {
  v.visit({"levels", "fast: resolutions, from coarse to fine", "", between(1, 8)}, o.num_levels);
  v.visit({"coarse_passes", "fast: passes on each level but the finest", "", between(1, 16)}, o.coarse_passes);
  v.visit({"fine_passes", "fast: passes on the finest level", "", between(1, 16)}, o.fine_passes);
  v.visit({"random_candidates", "fast: candidates of similar control value a texel and pass", "", between(0, 64)}, o.num_random);
  v.visit({"coarse_coherence", "fast: coherence share on the coarsest level", "", between(0, 1)}, o.first_coherence);
  v.visit({"coherence_bonus", "fast: preference for continuing pieces of the source", "", between(0, 8)}, o.coherence_bonus);
  v.visit({"reuse_penalty", "fast: preference for sources that are used rarely", "", between(0, 8)}, o.reuse_penalty);
}

namespace {

/// How often the sources around a pixel are used more than their share: integers in [0, kMaxOveruse] per cell of pixels.
class SourceUse {
 public:
  static constexpr int kCell_px = 4;
  static constexpr std::int64_t kMaxOveruse = 8;

  SourceUse(const SynthesisLevel& level, const CoordinateMap& coordinates)
      : source_width_(level.source.width()), width_((level.source.width() + kCell_px - 1) / kCell_px) {
    const int height = (level.source.height() + kCell_px - 1) / kCell_px;
    overuse_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height), 0);
    for (TexelId t : level.destination.texels) ++overuse_[cell(coordinates[static_cast<std::size_t>(t)])];
    const auto num_texels = static_cast<std::int64_t>(level.destination.texels.size());
    const auto num_usable = static_cast<std::int64_t>(level.source.usable.size());
    const std::int64_t share = std::max<std::int64_t>(1, num_texels * kCell_px * kCell_px / num_usable);
    for (std::int64_t& n : overuse_) n = std::clamp<std::int64_t>(n / share - 1, 0, kMaxOveruse);
  }
  [[nodiscard]] std::int64_t overuse(std::int32_t pixel) const { return overuse_[cell(pixel)]; }

 private:
  [[nodiscard]] std::size_t cell(std::int32_t pixel) const {
    return static_cast<std::size_t>(pixel / source_width_ / kCell_px * width_ + pixel % source_width_ / kCell_px);
  }
  int source_width_;
  int width_;
  std::vector<std::int64_t> overuse_;
};

/// Factors on costs, in sixteenths: at most 16 (1 + 8 + 8 * 8) = 1168, so that products stay below 2^62.
struct Preferences {
  static constexpr std::int64_t kOne = 16;
  std::int64_t bonus = 0;
  std::int64_t penalty = 0;
  explicit Preferences(const MultiLevelOptions& o)
      : bonus(static_cast<std::int64_t>(o.coherence_bonus * kOne)), penalty(static_cast<std::int64_t>(o.reuse_penalty * kOne)) {}
};

/// The best of the candidates of one texel.
class CandidateSearch {
 public:
  CandidateSearch(const SynthesisLevel& level, const Neighborhood& neighborhood, const SimilarPixels& similar,
                  const SourceUse& use, const MultiLevelOptions& options)
      : source_(level.source), destination_(level.destination), similar_(similar), use_(use),
        preferences_(options), num_random_(options.num_random), cost_(level.source, level.destination, neighborhood) {}

  Place best(TexelId t, const PlaceMap& places, const EnergyScale& scale, RandomStream random) {
    cost_.prepare(t, places.pixels, scale);
    const Place current = places.at(t);
    best_ = current;
    best_cost_ = std::numeric_limits<std::int64_t>::max();
    num_tried_ = 0;
    for (const PixelNeighbor& n : cost_.adjacent()) {
      if (n.texel < 0 || n.texel == t) continue;
      const FixedPoint from = fixed_point(source_, places.at(n.texel));
      const Place candidate = place_at(source_, {from.x - n.x, from.y - n.y});
      if (candidate.pixel < 0 || !remember(candidate.pixel)) continue;
      consider(candidate, 0);
      try_similar(candidate.pixel);
    }
    if (remember(current.pixel)) {
      consider(current, preferences_.bonus);
      try_similar(current.pixel);
    }
    const auto alike = source_.similar(destination_.target(t), kSimilarTolerance);
    for (int i = 0; i < num_random_; ++i) {
      consider({alike[random.below(static_cast<std::uint32_t>(alike.size()))]}, preferences_.bonus);
    }
    return best_;
  }

 private:
  void consider(const Place& candidate, std::int64_t bonus) {
    const std::int64_t factor = Preferences::kOne + bonus + preferences_.penalty * use_.overuse(candidate.pixel);
    const std::int64_t cost = cost_.total(candidate.pixel, best_cost_ / factor + 1) * factor;
    if (cost < best_cost_) {
      best_cost_ = cost;
      best_ = candidate;
    }
  }
  void try_similar(std::int32_t pixel) {
    for (std::int32_t other : similar_[static_cast<std::size_t>(pixel)]) {
      if (other >= 0) consider({other}, preferences_.bonus);
    }
  }
  /// False if this coherent candidate was there before: in coherent regions all eight neighbours agree.
  bool remember(std::int32_t candidate) {
    const auto end = tried_.begin() + num_tried_;
    if (std::find(tried_.begin(), end, candidate) != end) return false;
    if (num_tried_ < static_cast<std::ptrdiff_t>(tried_.size())) tried_[static_cast<std::size_t>(num_tried_++)] = candidate;
    return true;
  }

  const SourceLevel& source_;
  const DestinationLevel& destination_;
  const SimilarPixels& similar_;
  const SourceUse& use_;
  Preferences preferences_;
  int num_random_;
  TexelCost cost_;
  std::array<std::int32_t, 9> tried_{};
  std::ptrdiff_t num_tried_ = 0;
  Place best_;
  std::int64_t best_cost_ = 0;
};

/// One pass: four interleaved sets, each decided from the state before it.
void improve(const SynthesisLevel& level, const Neighborhood& neighborhood, const SimilarPixels& similar,
             const MultiLevelOptions& options, const EnergyScale& scale, std::uint64_t seed, std::uint32_t pass, PlaceMap& places, const RunControl& control) {
  const DestinationLevel& destination = level.destination;
  const int width = destination.map->width();
  const SourceUse use(level, places.pixels);
  for (int set = 0; set < 4; ++set) {
    std::vector<TexelId> members;
    for (TexelId t : destination.texels) {
      if (static_cast<int>(t % width % 2 + 2 * (t / width % 2)) == set) members.push_back(t);
    }
    std::vector<Place> decided(members.size());
    parallel_for(static_cast<std::int64_t>(members.size()), 2048, control, [&](std::int64_t begin, std::int64_t end) {
      CandidateSearch search(level, neighborhood, similar, use, options);
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
        decided[i] = search.best(members[i], places, scale, RandomStream(seed, static_cast<std::uint64_t>(members[i]), pass));
      }
    });
    for (std::size_t i = 0; i < members.size(); ++i) places.set(members[i], decided[i]);
  }
}

}  // namespace

CoordinateMap synthesise_multi_level(const std::vector<SynthesisLevel>& levels, const Neighborhood& neighborhood,
                                     double coherence_share, std::span<const double> control_weights, std::uint64_t seed,
                                     const MultiLevelOptions& options, const RunControl& control) {
  check_ranges(options);
  RunControl silent = control;
  silent.on_progress = nullptr;
  constexpr std::size_t kMaxSearchedPixels = 70'000;  // Beyond, similar pixels are taken over from the coarser level.
  const std::size_t coarsest = levels.size() - 1;
  PlaceMap places = initial_places(levels[coarsest], seed);
  SimilarPixels similar;
  double done = 0.0, total = 0.0;
  const auto work = [&](std::size_t l) {
    return static_cast<double>(levels[l].destination.texels.size()) * (l == 0 ? options.fine_passes : options.coarse_passes);
  };
  for (std::size_t l = 0; l < levels.size(); ++l) total += work(l);
  for (std::size_t l = levels.size(); l-- > 0;) {
    const SynthesisLevel& level = levels[l];
    const bool is_searched = l == coarsest || level.source.usable.size() <= kMaxSearchedPixels;
    similar = is_searched ? find_similar_pixels(level.source, silent)
                          : refine_similar_pixels(similar, levels[l + 1].source, level.source);
    if (l < coarsest) places = upsample(places, levels[l + 1], level, seed + l);
    const double ramp = coarsest == 0 ? 1.0 : 1.0 - static_cast<double>(l) / static_cast<double>(coarsest);
    const EnergyScale scale = EnergyScale::make(
        level.source, options.first_coherence + (coherence_share - options.first_coherence) * ramp, control_weights);
    const int num_passes = l == 0 ? options.fine_passes : options.coarse_passes;
    for (int pass = 0; pass < num_passes; ++pass) {
      MultiLevelOptions preferences = options;
      if (l == 0 && pass + 1 == num_passes) preferences.coherence_bonus = preferences.reuse_penalty = 0.0;  // The last word is the energy's.
      improve(level, neighborhood, similar, preferences, scale, seed, static_cast<std::uint32_t>(200 + 32 * l + static_cast<std::size_t>(pass)),
              places, silent);
      done += work(l) / num_passes;
      control.report(std::min(0.999, done / std::max(1.0, total)));
    }
  }
  control.report(1.0);
  return std::move(places.pixels);
}

}  // namespace patinate
