#include "transfer/synthesis/multi_level.h"

#include <algorithm>
#include <atomic>
#include <functional>

#include "libcommon/core/parallel.h"

namespace patinate::transfer {

namespace {

constexpr int kCell_px = 4;  ///< Side of the cells in which uses of the source are counted.
/// Overuse is counted in quarters of an even share, up to eight shares.
constexpr std::int32_t kQuarters = search_kernel::kReuseQuarters, kMaxReuse = 8;

std::size_t pass_cell_of(const SourceLevel& source, int x, int y) {
  const int num_columns = (source.width() + kCell_px - 1) / kCell_px;
  return static_cast<std::size_t>(y / kCell_px * num_columns + x / kCell_px);
}

template <class Sums, class More>
void add_pass(Sums& sums, const More& more) {
  std::transform(more.begin(), more.end(), sums.begin(), sums.begin(), std::plus<>());
}

std::vector<std::int64_t> count_uses(const SynthesisLevel& level, const PlaceMap& places, const RunControl& control) {
  const TexelSet& texels = level.destination.texels;
  const std::vector<std::int64_t> none(pass_cell_of(level.source, 0, level.source.height() - 1 + kCell_px));
  return parallel_reduce(
      static_cast<std::int64_t>(texels.size()), texels_a_count(none.size()), control, none,
      [&](std::int64_t begin, std::int64_t end) {
        std::vector<std::int64_t> uses = none;
        auto at = texels.from(static_cast<std::size_t>(begin));
        for (std::int64_t i = begin; i < end; ++i, ++at) {
          const FixedPoint p = places.point(*at);
          ++uses[pass_cell_of(level.source, whole_pixels(p.x), whole_pixels(p.y))];
        }
        return uses;
      },
      [](std::vector<std::int64_t> all, const std::vector<std::int64_t>& uses) {
        add_pass(all, uses);
        return all;
      });
}

/// By pixel: how much more than their share the pixels around it are used, in quarters of that share, or of one copy of
/// them where the share is less: [0, kQuarters * kMaxReuse].
std::vector<std::uint8_t> reuse_of(const SourceLevel& source, const PlaceCounts& counts) {
  const auto num_usable = static_cast<std::int64_t>(source.usable.size());
  const std::int64_t share = counts.amounts.num_texels * kCell_px * kCell_px / num_usable,
                     unit = std::max<std::int64_t>(kCell_px * kCell_px, share);
  std::vector<std::uint8_t> reuse;
  reuse.reserve(source.is_usable.size());
  for (int y = 0; y < source.height(); ++y) {
    for (int x = 0; x < source.width(); ++x) {
      reuse.push_back(static_cast<std::uint8_t>(std::clamp<std::int64_t>(
          kQuarters * (counts.uses[pass_cell_of(source, x, y)] - share) / unit, 0, kQuarters * kMaxReuse)));
    }
  }
  return reuse;
}

}  // namespace

using search_kernel::Preferences;

double coherence_of_level(std::size_t level, std::size_t coarsest, double coherence_share,
                          const MultiLevelOptions& options) {
  const double first = options.first_coherence.value_or(kFirstCoherence);
  const double ramp = coarsest == 0 ? 1.0 : 1.0 - static_cast<double>(level) / static_cast<double>(coarsest);
  return first + (coherence_share - first) * ramp;
}

SimilarPixels similar_of_level(const SourceLevel& source, const SourceLevel* coarser, const SimilarPixels& of_coarser,
                               const RunControl& control) {
  // Larger levels are not searched exhaustively; speed against quality.
  constexpr std::size_t kMaxSearchedPixels = 17'000;
  const bool is_searched = coarser == nullptr || source.usable.size() <= kMaxSearchedPixels;
  return is_searched ? find_similar_pixels(source, control) : refine_similar_pixels(of_coarser, *coarser, source);
}

std::uint32_t stream_of(std::size_t level, int pass) {
  return static_cast<std::uint32_t>(200 + 32 * level + static_cast<std::size_t>(pass));
}

Preferences preferences_of(const MultiLevelOptions& o) {
  constexpr double kAmounts = 2.0;  // Weight of amounts, in units of kOne.
  constexpr auto kOne = static_cast<double>(search_kernel::kOfOne);
  return {.bonus = static_cast<std::int32_t>(o.coherence_bonus * kOne),
          .penalty = static_cast<std::int32_t>(o.reuse_penalty * kOne),
          .amounts = static_cast<std::int32_t>(kAmounts * kOne),
          .leaves_quiet = 1};
}

Improver::Improver(const SynthesisLevel& level, const Neighborhood& neighborhood, const SimilarPixels& similar,
                   const EnergyScale& scale, int num_random, std::uint64_t seed, const SearchDevice* device,
                   const SearchedPart* part)
    : level_(level),
      map_(*level.destination.map),
      neighborhood_(neighborhood),
      similar_(similar),
      scale_(scale),
      num_random_(num_random),
      seed_(seed),
      device_(device),
      texels_(part == nullptr ? level.destination.texels : part->texels),
      amounts_(part == nullptr ? Amounts(level.source) : part->amounts),
      squares_x_((map_.width() + kSquare - 1) / kSquare),
      squares_(find_squares()),
      changed_near_(static_cast<std::size_t>(map_.num_texels())) {}

std::vector<int> Improver::find_squares() const {
  const int num_squares = squares_x_ * ((map_.height() + kSquare - 1) / kSquare);
  std::vector<std::uint8_t> is_there(static_cast<std::size_t>(num_squares), 0);
  for (const TexelId t : texels_) is_there[t / map_.width() / kSquare * squares_x_ + t % map_.width() / kSquare] = 1;
  std::vector<int> squares;
  for (int i = 0; i < num_squares; ++i) {
    if (is_there[i] != 0) squares.push_back(i);
  }
  return squares;
}

PlaceCounts Improver::count(const PlaceMap& places, const RunControl& control) const {
  return {count_uses(level_, places, control), amounts_.count(level_.destination, places, control)};
}

void Improver::pass(const Preferences& preferences, bool is_whole, std::uint32_t stream, const PlaceCounts& counts,
                    PlaceMap& places, const RunControl& control) {
  if (!counts.uses.empty()) {
    reuse_ = reuse_of(level_.source, counts);
    amounts_.set(counts.amounts);
  }
  const std::span<const std::uint8_t> reuse =
      preferences.penalty > 0 ? std::span<const std::uint8_t>(reuse_) : std::span<const std::uint8_t>();
  const DevicePass device_pass{.factors = preferences,
                               .reuse = reuse,
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
                                                          .reuse = reuse.empty() ? nullptr : reuse.data(),
                                                          .look = amounts_.looks().data(),
                                                          .excess = amounts_.excess().data()},
                                          .targets = level_.destination.targets(),
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
              &pass, t, cursor.at(t).data(), random_kernel::random_state(seed_, static_cast<std::uint64_t>(t), stream),
              &known);
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

bool Improver::passed_on_device(const DevicePass& pass, PlaceMap& places, const RunControl& control) {
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

search_kernel::SourceTables Improver::source_with(const SimilarPixels& similar) const {
  static_assert(sizeof(SimilarPixels::value_type) == search_kernel::kAlikeCandidates * sizeof(std::int32_t) &&
                search_kernel::kTexelsBeside == TexelNeighborhood::kNumAdjacent);
  search_kernel::SourceTables tables = source_tables(level_.source);
  tables.similar = similar.data()->data();
  return tables;
}

template <class Visit>
void Improver::for_each_due(int square, int set, bool is_whole, const Visit& visit) const {
  const int x0 = square % squares_x_ * kSquare, y0 = square / squares_x_ * kSquare;
  for (int y = y0 + set / 2; y < std::min(y0 + kSquare, map_.height()); y += 2) {
    for (int x = x0 + set % 2; x < std::min(x0 + kSquare, map_.width()); x += 2) {
      const TexelId t = TexelId{y} * map_.width() + x;
      if (texels_.contains(t) && search_kernel::is_due(changed_near_[t], turn_, is_whole))
        visit(t, static_cast<std::uint16_t>((y - y0) * kSquare + x - x0));
    }
  }
}

void Improver::apply(int square, const Change& change, TexelNeighborhood::Cursor& cursor, PlaceMap& places) {
  const int x = square % squares_x_ * kSquare + change.in_square % kSquare,
            y = square / squares_x_ * kSquare + change.in_square / kSquare;
  const TexelId texel = TexelId{y} * map_.width() + x;
  if (change.pixel != places.pixels[texel]) {
    mark(texel);
    for (const PixelNeighbor& n : cursor.at(texel).subspan(level_.destination.neighbors->first_adjacent())) {
      if (n.texel >= 0) mark(n.texel);
    }
  }
  places.set(texel, change.pixel, change.beside);
}

void Improver::mark(TexelId t) {
  std::atomic_ref(changed_near_[t]).store(static_cast<std::uint8_t>(turn_), std::memory_order_relaxed);
}

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
