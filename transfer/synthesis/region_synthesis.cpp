#include "transfer/synthesis/region_synthesis.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "transfer/synthesis/energy.h"
#include "transfer/synthesis/multi_level.h"

namespace patinate::transfer {

namespace {

/// A region begins on the coarsest level on which it has so many texels, 8 x 8: fewer hold no neighborhood.
constexpr std::size_t kFewestTexels = 64;

/// The coarse texel that a fine one lies in; -1 where the coarse map ends before it.
TexelId texel_above(const TexelMap& fine, const TexelMap& coarse, TexelId t) {
  const TexelId x = t % fine.width() / 2, y = t / fine.width() / 2;
  return x < coarse.width() && y < coarse.height() ? y * coarse.width() + x : -1;
}

/// Mean of the controls of the covered texels that lie in a coarse one, as halve() rounds it. Without any, nothing.
void halve_target(const DestinationLevel& fine, TexelId t, DestinationLevel& coarse) {
  const int x = static_cast<int>(t % coarse.map->width()), y = static_cast<int>(t / coarse.map->width());
  for (int c = 0; c < coarse.num_controls(); ++c) {
    int sum = 0, n = 0;
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) {
        const int fx = 2 * x + dx, fy = 2 * y + dy;
        if (!fine.controls.contains(fx, fy) || !fine.map->is_covered(TexelId{fy} * fine.map->width() + fx)) continue;
        sum += fine.controls.at(fx, fy, c);
        ++n;
      }
    }
    if (n > 0) coarse.controls.at(x, y, c) = static_cast<std::uint16_t>((sum + n / 2) / n);
  }
}

}  // namespace

RegionSynthesis::RegionSynthesis(PreparedTransfer prepared, PlaceMap places, const RunControl& control)
    : prepared_(std::move(prepared)), structures_(refined_structures(prepared_, control.silent())) {
  const RunControl silent = control.silent();
  const std::size_t coarsest = prepared_.levels.size() - 1;
  std::vector<SimilarPixels> similar(coarsest + 1);
  for (std::size_t l = coarsest + 1; l-- > 0;) {
    SynthesisLevel& level = prepared_.levels[l];
    if (!level.destination.neighbors) find_neighbors(level.destination, prepared_.neighborhood, silent);
    const SourceLevel* const coarser = l == coarsest ? nullptr : &prepared_.levels[l + 1].source;
    similar[l] = similar_of_level(level.source, coarser, coarser == nullptr ? SimilarPixels() : similar[l + 1], silent);
    control.report(0.9 * static_cast<double>(coarsest + 1 - l) / static_cast<double>(coarsest + 1));
  }
  for (std::size_t l = 0; l <= coarsest; ++l) {
    const SynthesisLevel& level = prepared_.levels[l];
    const double share = coherence_of_level(l, coarsest, *prepared_.used.coherence_share, prepared_.used.multi_level);
    states_.push_back(
        {.similar = std::move(similar[l]),
         .scale = EnergyScale::make(level.source, share, prepared_.weights),
         .amounts = Amounts(level.source),
         .places = l == 0 ? std::move(places) : PlaceMap(level.destination.map->num_texels(), level.source.width())});
    if (level.destination.placement.turns != nullptr && states_[l].places.turns().empty())
      states_[l].places.keep_turns();
  }
  std::vector<TexelSet> whole;
  for (const SynthesisLevel& level : prepared_.levels) whole.push_back(level.destination.texels);
  halve_places(whole);
  control.report(1.0);
}

std::span<std::uint16_t> RegionSynthesis::target(TexelId t) {
  DestinationLevel& level = prepared_.levels[0].destination;
  const auto n = static_cast<std::size_t>(level.num_controls());
  return {level.controls.data() + static_cast<std::size_t>(t) * n, n};
}

TexelSet RegionSynthesis::with_reach(std::span<const TexelId> texels) const {
  std::vector<TexelId> reached(texels.begin(), texels.end());
  TexelNeighborhood::Cursor cursor(*destination().neighbors);
  for (const TexelId t : texels) {
    for (const PixelNeighbor& n : cursor.at(t)) {
      if (n.texel >= 0) reached.push_back(n.texel);
    }
  }
  return {destination().map->num_texels(), reached};
}

std::vector<TexelSet> RegionSynthesis::parts_of(const TexelSet& region) const {
  std::vector<TexelSet> parts{region};
  for (std::size_t l = 1; l < prepared_.levels.size(); ++l) {
    const TexelMap &fine = *prepared_.levels[l - 1].destination.map, &coarse = *prepared_.levels[l].destination.map;
    std::vector<TexelId> above;
    for (const TexelId t : parts.back()) {
      const TexelId parent = texel_above(fine, coarse, t);
      if (parent >= 0 && coarse.is_covered(parent)) above.push_back(parent);
    }
    parts.emplace_back(coarse.num_texels(), above);
  }
  return parts;
}

void RegionSynthesis::halve_targets(const std::vector<TexelSet>& parts) {
  for (std::size_t l = 1; l < parts.size(); ++l) {
    for (const TexelId t : parts[l])
      halve_target(prepared_.levels[l - 1].destination, t, prepared_.levels[l].destination);
  }
}

void RegionSynthesis::halve_places(const std::vector<TexelSet>& parts) {
  const auto seed = static_cast<std::uint64_t>(prepared_.used.seed);
  for (std::size_t l = 1; l < parts.size(); ++l) {
    set_initial_places(prepared_.levels[l], parts[l], seed, states_[l].places);
    downsample_texels(states_[l - 1].places, prepared_.levels[l - 1], prepared_.levels[l], parts[l], states_[l].places);
  }
}

void RegionSynthesis::reset_missed(std::size_t l, const TexelSet& part, std::uint64_t seed) {
  const SynthesisLevel& level = prepared_.levels[l];
  const auto misses = [&](TexelId t) {
    const auto target = level.destination.target(t);
    const auto pixel = static_cast<std::int64_t>(states_[l].places.pixels[t]);
    for (std::size_t c = 0; c < target.size(); ++c) {
      const auto at = pixel * static_cast<std::int64_t>(target.size()) + static_cast<std::int64_t>(c);
      if (std::abs(int{level.source.controls.data()[at]} - int{target[c]}) > kSimilarTolerance) return true;
    }
    return false;
  };
  std::vector<TexelId> missed;
  std::copy_if(part.begin(), part.end(), std::back_inserter(missed), misses);
  set_initial_places(level, {level.destination.map->num_texels(), missed}, seed, states_[l].places);
}

void RegionSynthesis::search(std::size_t l, const TexelSet& part, std::uint64_t seed, const RunControl& control) {
  const SynthesisLevel& level = prepared_.levels[l];
  const MultiLevelOptions& options = prepared_.used.multi_level;
  State& state = states_[l];
  const std::vector<Place> before = places_of(l, part);
  const SearchedPart searched{.texels = part, .amounts = state.amounts};
  Improver improver(level, prepared_.neighborhood, state.similar, state.scale, options.num_random, seed, nullptr,
                    &searched);
  const int num_passes = l == 0 ? options.fine_passes : options.coarse_passes;
  for (int pass = 0; pass < num_passes; ++pass) {
    const bool is_last = l == 0 && pass + 1 == num_passes;  // The last word is the energy's.
    // A part changes little of what the whole surface has: it is counted once.
    improver.pass(is_last ? kEnergyAlone : preferences_of(options), is_last, stream_of(l, pass),
                  pass == 0 && !is_last ? improver.count(state.places, control) : PlaceCounts{}, state.places, control);
  }
  if (level.destination.placement.turns == nullptr) return;
  for (const TexelId t : moved(l, part, before)) {  // Passes know no turns.
    Place place = state.places.at(t);
    place.turn = 0;
    state.places.set(t, place);
  }
}

std::vector<Place> RegionSynthesis::places_of(std::size_t l, const TexelSet& part) const {
  std::vector<Place> places;
  places.reserve(part.size());
  for (const TexelId t : part) places.push_back(states_[l].places.at(t));
  return places;
}

TexelSet RegionSynthesis::moved(std::size_t l, const TexelSet& part, const std::vector<Place>& before) const {
  std::vector<TexelId> texels;
  std::size_t i = 0;
  for (const TexelId t : part) {
    if (!(states_[l].places.at(t) == before[i++])) texels.push_back(t);
  }
  return {prepared_.levels[l].destination.map->num_texels(), texels};
}

TexelSet RegionSynthesis::children(std::size_t l, const TexelSet& part, const TexelSet& parents) const {
  const TexelMap &fine = *prepared_.levels[l].destination.map, &coarse = *prepared_.levels[l + 1].destination.map;
  std::vector<TexelId> texels;
  for (const TexelId t : part) {
    const TexelId parent = texel_above(fine, coarse, t);
    if (parent >= 0 && parents.contains(parent)) texels.push_back(t);
  }
  return {fine.num_texels(), texels};
}

void RegionSynthesis::synthesize(const TexelSet& region, RegionWork work, std::uint64_t seed,
                                 const RunControl& control) {
  const std::vector<TexelSet> parts = parts_of(region);
  halve_targets(parts);
  std::size_t first = 0;
  while (first + 1 < parts.size() && parts[first + 1].size() >= kFewestTexels) ++first;
  TransferOptions options = prepared_.used;
  options.seed = static_cast<std::int64_t>(seed);
  const LevelRefinement refinement = work == RegionWork::Structure
                                         ? refinement_of(structures_, options, prepared_.weights, &parts)
                                         : LevelRefinement{};
  TexelSet above;  // Texels of the coarser level that have moved.
  for (std::size_t l = first + 1; l-- > 0;) {
    SynthesisLevel& level = prepared_.levels[l];
    const std::vector<Place> before = places_of(l, parts[l]);
    if (l < first) {
      upsample_texels(states_[l + 1].places, prepared_.levels[l + 1], level, children(l, parts[l], above),
                      states_[l].places, control);
    } else {
      reset_missed(l, parts[l], seed + l);
    }
    const bool turns = level.destination.placement.turns != nullptr && l + 1 < refinement.num_levels && l < first;
    if (!turns) search(l, parts[l], seed, control);
    if (refinement.refine) refinement.refine(l, level, states_[l].similar, states_[l].places, control.silent());
    above = moved(l, parts[l], before);
  }
  halve_places(parts);
}

void RegionSynthesis::update(const TexelSet& region) {
  const std::vector<TexelSet> parts = parts_of(region);
  halve_targets(parts);
  halve_places(parts);
}

EnergyReport RegionSynthesis::energy(const RunControl& control) const {
  const SynthesisLevel& level = prepared_.levels[0];
  return measure_energy(level.source, level.destination, prepared_.neighborhood, states_[0].places.pixels,
                        *prepared_.used.coherence_share, prepared_.weights, control, nullptr,
                        states_[0].places.turns());
}

}  // namespace patinate::transfer
