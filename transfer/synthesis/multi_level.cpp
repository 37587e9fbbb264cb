#include "transfer/synthesis/multi_level.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <optional>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "transfer/synthesis/amounts.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/search_device.h"
#include "transfer/synthesis/similar_pixels.h"

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

/// How much more than their share the pixels around each pixel are used, in quarters of that share, or of one copy of
/// them where the share is less: [0, kQuarters * kMaxReuse].
class SourceUse {
 public:
  static constexpr int kCell_px = 4;
  static constexpr std::int32_t kQuarters = search_kernel::kReuseQuarters, kMaxReuse = 8;

  SourceUse(const SynthesisLevel& level, const PlaceMap& places) {
    const int width = level.source.width(), num_columns = (width + kCell_px - 1) / kCell_px;
    const auto cell = [&](int x, int y) { return static_cast<std::size_t>(y / kCell_px * num_columns + x / kCell_px); };
    std::vector<std::int64_t> uses(cell(0, level.source.height() - 1 + kCell_px));
    for (TexelId t : level.destination.texels) {
      const FixedPoint p = places.point(t);
      ++uses[cell(whole_pixels(p.x), whole_pixels(p.y))];
    }
    const auto num_texels = static_cast<std::int64_t>(level.destination.texels.size());
    const auto num_usable = static_cast<std::int64_t>(level.source.usable.size());
    const std::int64_t share = num_texels * kCell_px * kCell_px / num_usable,
                       unit = std::max<std::int64_t>(kCell_px * kCell_px, share);
    reuse_.reserve(level.source.is_usable.size());
    for (int y = 0; y < level.source.height(); ++y) {
      for (int x = 0; x < width; ++x) {
        reuse_.push_back(static_cast<std::uint8_t>(
            std::clamp<std::int64_t>(kQuarters * (uses[cell(x, y)] - share) / unit, 0, kQuarters * kMaxReuse)));
      }
    }
  }
  /// By pixel.
  [[nodiscard]] const std::vector<std::uint8_t>& reuse() const { return reuse_; }

 private:
  std::vector<std::uint8_t> reuse_;
};

using search_kernel::Preferences;

constexpr Preferences kEnergyAlone{};

Preferences preferences_of(const MultiLevelOptions& o) {
  constexpr double kAmounts = 2.0;
  constexpr auto kOne = static_cast<double>(search_kernel::kOfOne);
  return {.bonus = static_cast<std::int32_t>(o.coherence_bonus * kOne),
          .penalty = static_cast<std::int32_t>(o.reuse_penalty * kOne),
          .amounts = static_cast<std::int32_t>(kAmounts * kOne),
          .leaves_quiet = 1};
}

/// Improves the places on one level, pass by pass. The atlas is worked on in squares: what lies together on the surface
/// is together in memory.
class Improver {
 public:
  Improver(const SynthesisLevel& level, const Neighborhood& neighborhood, const SimilarPixels& similar,
           const EnergyScale& scale, int num_random, std::uint64_t seed, const SearchDevice* device)
      : level_(level),
        map_(*level.destination.map),
        neighborhood_(neighborhood),
        similar_(similar),
        scale_(scale),
        num_random_(num_random),
        seed_(seed),
        device_(device),
        amounts_(level.source),
        squares_x_((map_.width() + kSquare - 1) / kSquare),
        changed_near_(static_cast<std::size_t>(map_.num_texels()), 0) {
    const int num_squares = squares_x_ * ((map_.height() + kSquare - 1) / kSquare);
    std::vector<std::uint8_t> is_covered(static_cast<std::size_t>(num_squares), 0);
    for (TexelId t : level.destination.texels)
      is_covered[static_cast<std::size_t>(t / map_.width() / kSquare * squares_x_ + t % map_.width() / kSquare)] = 1;
    for (int i = 0; i < num_squares; ++i) {
      if (is_covered[static_cast<std::size_t>(i)] != 0) squares_.push_back(i);
    }
  }

  [[nodiscard]] bool has_device() const { return device_ != nullptr; }

  /// Four interleaved sets, each decided from the state before it. A texel near which nothing has changed since its
  /// last turn is skipped.
  /// @param is_whole  Every texel has its turn; the first pass is whole.
  void pass(const Preferences& preferences, bool is_whole, std::uint32_t stream, PlaceMap& places,
            const RunControl& control) {
    const std::optional<SourceUse> use =
        preferences.penalty > 0 ? std::make_optional<SourceUse>(level_, places) : std::nullopt;
    if (preferences.amounts > 0) amounts_.measure(level_.destination, places, control);
    const DevicePass device_pass{.factors = preferences,
                                 .reuse = use ? std::span(use->reuse()) : std::span<const std::uint8_t>(),
                                 .looks = amounts_.looks(),
                                 .excess = amounts_.excess(),
                                 .num_random = num_random_,
                                 .seed = seed_,
                                 .stream = stream,
                                 .is_whole = is_whole,
                                 .first_turn = turn_};
    if (passed_on_device(device_pass, places, control)) return;
    const search_kernel::SearchPass pass = {.source = source_with(similar_),
                                            .alike = alike_tables(level_.source),
                                            .cost = cost_tables(neighborhood_, scale_),
                                            .places = places.tables(),
                                            .preferences = {.factors = preferences,
                                                            .reuse = use ? use->reuse().data() : nullptr,
                                                            .look = amounts_.looks().data(),
                                                            .excess = amounts_.excess().data()},
                                            .targets = level_.destination.controls.data(),
                                            .num_random = num_random_,
                                            .tolerance = kSimilarTolerance};
    const auto num_squares = static_cast<std::int64_t>(squares_.size());
    std::vector<std::vector<Change>> changes(squares_.size());
    for (int set = 0; set < kNumSets; ++set, ++turn_) {
      parallel_for(num_squares, 1, control, [&](std::int64_t begin, std::int64_t end) {
        TexelNeighborhood::Cursor cursor(*level_.destination.neighbors);
        search_kernel::KnownNeighbors known;
        std::vector<Change> found;
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          found.clear();
          for_each_due(squares_[i], set, is_whole, [&](TexelId t, std::uint16_t in_square) {
            const search_kernel::FixedPlace best = search_kernel::best_place(
                &pass, t, cursor.at(t).data(),
                random_kernel::random_state(seed_, static_cast<std::uint64_t>(t), stream), &known);
            const Place place{best.pixel, {best.x, best.y}};
            if (!(place == places.at(t))) found.push_back({place.pixel, PlaceMap::beside_of(place), in_square});
          });
          changes[i].assign(found.begin(), found.end());  // No more room than it takes.
        }
      });
      parallel_for(num_squares, 16, control, [&](std::int64_t begin, std::int64_t end) {
        TexelNeighborhood::Cursor cursor(*level_.destination.neighbors);
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          for (const Change& c : changes[i]) apply(squares_[i], c, cursor, places);
        }
      });
    }
  }

 private:
  /// @returns false, with nothing changed, where there is no device or it has failed.
  bool passed_on_device(const DevicePass& pass, PlaceMap& places, const RunControl& control) {
    if (device_ == nullptr) return false;
    try {
      if (on_device_ == nullptr)
        on_device_ = std::make_unique<SearchDevice::Level>(*device_, level_, neighborhood_, similar_, scale_, control);
      on_device_->run(pass, places, changed_near_, control);
    } catch (const device::DeviceError& error) {
      device_->report_failure(error);
      on_device_.reset();
      device_ = nullptr;
      return false;
    }
    turn_ += kNumSets;
    return true;
  }

  static constexpr int kNumSets = search_kernel::kInterleavedSets;
  static constexpr int kSquare = 64;  ///< Texels. Even, so that a set begins alike in all.

  struct Change {
    std::int32_t pixel;
    PlaceMap::Beside beside;
    std::uint16_t in_square;  ///< y * kSquare + x.
  };
  static_assert(sizeof(Change) == 8);

  [[nodiscard]] search_kernel::SourceTables source_with(const SimilarPixels& similar) const {
    static_assert(sizeof(SimilarPixels::value_type) == search_kernel::kAlikeCandidates * sizeof(std::int32_t) &&
                  search_kernel::kTexelsBeside == TexelNeighborhood::kNumAdjacent);
    search_kernel::SourceTables tables = source_tables(level_.source);
    tables.similar = similar.data()->data();
    return tables;
  }

  /// Calls visit(t, in_square) for the covered texels of a set whose turn it is.
  template <class Visit>
  void for_each_due(int square, int set, bool is_whole, const Visit& visit) const {
    const int x0 = square % squares_x_ * kSquare, y0 = square / squares_x_ * kSquare;
    for (int y = y0 + set / 2; y < std::min(y0 + kSquare, map_.height()); y += 2) {
      for (int x = x0 + set % 2; x < std::min(x0 + kSquare, map_.width()); x += 2) {
        const TexelId t = TexelId{y} * map_.width() + x;
        if (map_.is_covered(t) && search_kernel::is_due(changed_near_[static_cast<std::size_t>(t)], turn_, is_whole))
          visit(t, static_cast<std::uint16_t>((y - y0) * kSquare + x - x0));
      }
    }
  }
  void apply(int square, const Change& change, TexelNeighborhood::Cursor& cursor, PlaceMap& places) {
    const int x = square % squares_x_ * kSquare + change.in_square % kSquare,
              y = square / squares_x_ * kSquare + change.in_square / kSquare;
    const TexelId texel = TexelId{y} * map_.width() + x;
    if (change.pixel != places.pixels[static_cast<std::size_t>(texel)]) {
      mark(texel);
      for (const PixelNeighbor& n : cursor.at(texel).subspan(level_.destination.neighbors->first_adjacent())) {
        if (n.texel >= 0) mark(n.texel);
      }
    }
    places.set(texel, change.pixel, change.beside);
  }
  /// By several threads at once: all write the same.
  void mark(TexelId t) {
    std::atomic_ref(changed_near_[static_cast<std::size_t>(t)])
        .store(static_cast<std::uint8_t>(turn_), std::memory_order_relaxed);
  }

  const SynthesisLevel& level_;
  const TexelMap& map_;
  const Neighborhood& neighborhood_;
  const SimilarPixels& similar_;
  const EnergyScale& scale_;
  int num_random_;
  std::uint64_t seed_;
  const SearchDevice* device_;  ///< Null from when it has failed.
  std::unique_ptr<SearchDevice::Level> on_device_;
  Amounts amounts_;
  int squares_x_;
  std::vector<int> squares_;                ///< Those with covered texels.
  std::vector<std::uint8_t> changed_near_;  ///< The last turn in which this texel or one beside it changed.
  int turn_ = 0;
};

}  // namespace

PlaceMap synthesize_multi_level(std::vector<SynthesisLevel>& levels, const Neighborhood& neighborhood,
                                double coherence_share, std::span<const double> control_weights, std::uint64_t seed,
                                const MultiLevelOptions& options, const RunControl& control,
                                const LevelRefinement& refinement, const SearchDevice* device) {
  check_ranges(options);
  RunControl silent = control;
  silent.on_progress = nullptr;
  const double first_coherence = options.first_coherence.value_or(kFirstCoherence);
  constexpr std::size_t kMaxSearchedPixels = 17'000;  // Beyond, similar pixels are taken over from the coarser level.
  const std::size_t coarsest = levels.size() - 1;
  PlaceMap places = initial_places(levels[coarsest], seed);
  SimilarPixels similar;
  double done = 0.0, total = 0.0;
  const auto work = [&](std::size_t l) {
    return static_cast<double>(levels[l].destination.texels.size()) *
           ((l == 0 ? options.fine_passes : options.coarse_passes) + refinement.num_passes);
  };
  for (std::size_t l = 0; l < levels.size(); ++l) total += work(l);
  for (std::size_t l = levels.size(); l-- > 0;) {
    SynthesisLevel& level = levels[l];
    if (!level.destination.neighbors) find_neighbors(level.destination, neighborhood, silent);
    const bool is_searched = l == coarsest || level.source.usable.size() <= kMaxSearchedPixels;
    similar = is_searched ? find_similar_pixels(level.source, silent)
                          : refine_similar_pixels(similar, levels[l + 1].source, level.source);
    if (l < coarsest) {
      places = upsample(places, levels[l + 1], level, seed + l);
      levels[l + 1] = {};
    }
    const double ramp = coarsest == 0 ? 1.0 : 1.0 - static_cast<double>(l) / static_cast<double>(coarsest);
    const EnergyScale scale =
        EnergyScale::make(level.source, first_coherence + (coherence_share - first_coherence) * ramp, control_weights);
    const int num_passes = l == 0 ? options.fine_passes : options.coarse_passes;
    Improver improver(level, neighborhood, similar, scale, options.num_random, seed, device);
    for (int pass = 0; pass < num_passes; ++pass) {
      const bool is_last = l == 0 && pass + 1 == num_passes;  // The last word is the energy's.
      improver.pass(is_last ? kEnergyAlone : preferences_of(options), is_last,
                    static_cast<std::uint32_t>(200 + 32 * l + static_cast<std::size_t>(pass)), places, silent);
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
    if (l > 0) level.destination.neighbors.reset();
  }
  control.report(1.0);
  return places;
}

}  // namespace patinate::transfer
