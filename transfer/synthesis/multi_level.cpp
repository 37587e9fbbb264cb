#include "transfer/synthesis/multi_level.h"

#include <algorithm>
#include <array>
#include <limits>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
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

constexpr int kSimilarTolerance = kControlSteps / 50;

/// Every covered texel gets a source pixel of similar control value.
CoordinateMap initial_coordinates(const SynthesisLevel& level, std::uint64_t seed) {
  const DestinationLevel& destination = level.destination;
  CoordinateMap coordinates(static_cast<std::size_t>(destination.map->num_texels()), -1);
  for (TexelId t : destination.texels) {
    RandomStream random(seed, static_cast<std::uint64_t>(t), 100);
    const auto similar = level.source.similar(destination.target(t), kSimilarTolerance);
    coordinates[static_cast<std::size_t>(t)] = similar[random.below(static_cast<std::uint32_t>(similar.size()))];
  }
  return coordinates;
}

/// Doubles coordinates: a fine texel takes the matching quarter of its parent's pixel. Texels whose parent is not covered
/// or leads outside take one of similar control value.
CoordinateMap upsample(const CoordinateMap& coarse, const SynthesisLevel& coarse_level, const SynthesisLevel& fine_level,
                       std::uint64_t seed) {
  CoordinateMap fine = initial_coordinates(fine_level, seed);
  const int fine_width = fine_level.destination.map->width(), coarse_width = coarse_level.destination.map->width();
  const int coarse_height = coarse_level.destination.map->height();
  for (TexelId t : fine_level.destination.texels) {
    const int x = static_cast<int>(t % fine_width), y = static_cast<int>(t / fine_width);
    const int px = std::min(x / 2, coarse_width - 1), py = std::min(y / 2, coarse_height - 1);
    const std::int32_t parent = coarse[static_cast<std::size_t>(py) * static_cast<std::size_t>(coarse_width) + static_cast<std::size_t>(px)];
    if (parent < 0) continue;
    const int sx = 2 * (parent % coarse_level.source.width()) + (x - 2 * px), sy = 2 * (parent / coarse_level.source.width()) + (y - 2 * py);
    if (sx >= fine_level.source.width() || sy >= fine_level.source.height()) continue;
    const std::int32_t candidate = sy * fine_level.source.width() + sx;
    if (fine_level.source.is_usable[static_cast<std::size_t>(candidate)] != 0) fine[static_cast<std::size_t>(t)] = candidate;
  }
  return fine;
}

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
      : source_(level.source), destination_(level.destination), neighborhood_(neighborhood), similar_(similar), use_(use),
        preferences_(options), num_random_(options.num_random), cost_(level.source, level.destination, neighborhood) {
    for (std::size_t k = 0; k < neighborhood.offsets.size(); ++k) {
      const Offset& o = neighborhood.offsets[k];
      if (std::abs(o.x) <= 1 && std::abs(o.y) <= 1) adjacent_.push_back(k);
    }
  }

  std::int32_t best(TexelId t, const CoordinateMap& coordinates, const EnergyScale& scale, RandomStream random) {
    cost_.prepare(t, coordinates, scale);
    const std::int32_t current = coordinates[static_cast<std::size_t>(t)];
    best_ = current;
    best_cost_ = std::numeric_limits<std::int64_t>::max();
    num_tried_ = 0;
    for (std::size_t k : adjacent_) {
      const TexelId n = cost_.neighbor(k);
      if (n < 0) continue;
      const std::int32_t s = coordinates[static_cast<std::size_t>(n)];
      const int x = s % source_.width() - neighborhood_.offsets[k].x, y = s / source_.width() - neighborhood_.offsets[k].y;
      if (x < 0 || y < 0 || x >= source_.width() || y >= source_.height()) continue;
      const std::int32_t candidate = y * source_.width() + x;
      if (source_.is_usable[static_cast<std::size_t>(candidate)] == 0 || !remember(candidate)) continue;
      consider(candidate, 0);
      try_similar(candidate);
    }
    if (remember(current)) {
      consider(current, preferences_.bonus);
      try_similar(current);
    }
    const auto alike = source_.similar(destination_.target(t), kSimilarTolerance);
    for (int i = 0; i < num_random_; ++i) {
      consider(alike[random.below(static_cast<std::uint32_t>(alike.size()))], preferences_.bonus);
    }
    return best_;
  }

 private:
  void consider(std::int32_t candidate, std::int64_t bonus) {
    const std::int64_t factor = Preferences::kOne + bonus + preferences_.penalty * use_.overuse(candidate);
    const std::int64_t cost = cost_.total(candidate, best_cost_ / factor + 1) * factor;
    if (cost < best_cost_) {
      best_cost_ = cost;
      best_ = candidate;
    }
  }
  void try_similar(std::int32_t pixel) {
    for (std::int32_t other : similar_[static_cast<std::size_t>(pixel)]) {
      if (other >= 0) consider(other, preferences_.bonus);
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
  const Neighborhood& neighborhood_;
  const SimilarPixels& similar_;
  const SourceUse& use_;
  Preferences preferences_;
  int num_random_;
  TexelCost cost_;
  std::vector<std::size_t> adjacent_;
  std::array<std::int32_t, 9> tried_{};
  std::ptrdiff_t num_tried_ = 0;
  std::int32_t best_ = -1;
  std::int64_t best_cost_ = 0;
};

/// One pass: four interleaved sets, each decided from the state before it.
void improve(const SynthesisLevel& level, const Neighborhood& neighborhood, const SimilarPixels& similar,
             const MultiLevelOptions& options, const EnergyScale& scale, std::uint64_t seed, std::uint32_t pass, CoordinateMap& coordinates, const RunControl& control) {
  const DestinationLevel& destination = level.destination;
  const int width = destination.map->width();
  const SourceUse use(level, coordinates);
  for (int set = 0; set < 4; ++set) {
    std::vector<TexelId> members;
    for (TexelId t : destination.texels) {
      if (static_cast<int>(t % width % 2 + 2 * (t / width % 2)) == set) members.push_back(t);
    }
    std::vector<std::int32_t> decided(members.size());
    parallel_for(static_cast<std::int64_t>(members.size()), 2048, control, [&](std::int64_t begin, std::int64_t end) {
      CandidateSearch search(level, neighborhood, similar, use, options);
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
        decided[i] = search.best(members[i], coordinates, scale, RandomStream(seed, static_cast<std::uint64_t>(members[i]), pass));
      }
    });
    for (std::size_t i = 0; i < members.size(); ++i) coordinates[static_cast<std::size_t>(members[i])] = decided[i];
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
  CoordinateMap coordinates = initial_coordinates(levels[coarsest], seed);
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
    if (l < coarsest) coordinates = upsample(coordinates, levels[l + 1], level, seed + l);
    const double ramp = coarsest == 0 ? 1.0 : 1.0 - static_cast<double>(l) / static_cast<double>(coarsest);
    const EnergyScale scale = EnergyScale::make(
        level.source, options.first_coherence + (coherence_share - options.first_coherence) * ramp, control_weights);
    const int num_passes = l == 0 ? options.fine_passes : options.coarse_passes;
    for (int pass = 0; pass < num_passes; ++pass) {
      MultiLevelOptions preferences = options;
      if (l == 0 && pass + 1 == num_passes) preferences.coherence_bonus = preferences.reuse_penalty = 0.0;  // The last word is the energy's.
      improve(level, neighborhood, similar, preferences, scale, seed, static_cast<std::uint32_t>(200 + 32 * l + static_cast<std::size_t>(pass)),
              coordinates, silent);
      done += work(l) / num_passes;
      control.report(std::min(0.999, done / std::max(1.0, total)));
    }
  }
  control.report(1.0);
  return coordinates;
}

}  // namespace patinate
