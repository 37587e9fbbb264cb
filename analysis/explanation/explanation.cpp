#include "analysis/explanation/explanation.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "analysis/explanation/block_shuffle.h"
#include "analysis/explanation/ranks.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

void describe(OptionVisitor& v, ExplanationOptions& o) {
  v.visit({"num_samples", "Places on the surface that are looked at", "", between(500, 100000)}, o.num_samples);
  v.visit({"block",
           "Side of the surface blocks that count as independent; default: 2.5 times the reference's correlation range",
           "mm", above(0)},
          o.block_mm);
  v.visit({"max_members", "Largest number of controls in the mix", "", between(1, 8)}, o.max_members);
  v.visit({"resamples", "Number of bootstrap resamples for the intervals", "", between(50, 10000)}, o.resamples);
  v.visit({"shuffles", "Number of block permutations for the p values", "", between(99, 100000)}, o.shuffles);
}

void check_shuffles(const ExplanationOptions& options, std::size_t num_candidates) {
  const double needed = static_cast<double>(num_candidates) / kExplains;
  if (options.shuffles + 1 < needed)
    throw InvalidInput("explain: " + std::to_string(options.shuffles) + " shuffles cannot tell " +
                       std::to_string(num_candidates) + " candidates from chance; at least " +
                       number_text(needed - 1.0) + " are needed");
}

namespace {

constexpr double kEven = 1e-3;       ///< Values of [0, 1] that differ by no more are the same, as for control maps.
constexpr double k95Percent = 1.96;  ///< Standard errors of a 95 % interval.

void check(const ExplanationInput& input, const ExplanationOptions& options) {
  const std::size_t n = input.positions_mm.size();
  const auto is_finite = [](const std::vector<double>& list) {
    return std::all_of(list.begin(), list.end(), [](double v) { return std::isfinite(v); });
  };
  if (n < kFewestPlaces)
    throw InvalidInput("explain: " + std::to_string(n) + " places are too few; at least " +
                       std::to_string(kFewestPlaces) + " are needed");
  std::set<std::string> names;
  for (const ExplanationCandidate& c : input.candidates) {
    if (c.values.size() != n || !is_finite(c.values) || !names.insert(c.name).second)
      throw InvalidInput("explain: `" + c.name + "` needs a name of its own and a finite value at every place");
  }
  if (input.reference.size() != n || !is_finite(input.reference))
    throw InvalidInput("explain: the reference needs a finite value at every place");
  const auto [least, greatest] = std::minmax_element(input.reference.begin(), input.reference.end());
  if (!(*greatest > *least))
    throw InvalidInput("explain: the reference is " + short_number_text(*least) +
                       " everywhere: there is nothing to explain");
  check_shuffles(options, input.candidates.size());
  if (!(input.area_mm2 > 0.0)) throw InvalidInput("explain: the surface has no area");
}

bool is_even(const std::vector<double>& values) {
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  return *greatest - *least <= kEven;
}

/// Data that all figures stand on.
struct Work {
  const ExplanationInput& input;
  const ExplanationOptions& options;
  std::uint64_t seed;
  RankedValues reference;
  std::vector<double> reference_ranks = {};
  std::vector<std::size_t> used = {};  ///< Candidates that are not even.
  SurfaceBlocks blocks = {};
  Correlograms correlograms = {};  ///< Correlograms of the reference's ranks, then of those of the candidates in use.
};

/// On which differences of correlations are comparable.
double fisher_z(double correlation) { return std::atanh(std::clamp(correlation, -0.999999, 0.999999)); }

/// Correlations of several lists with the reference, and their 95 % intervals.
std::vector<ExplanationFigures> correlated(const Work& work, const std::vector<std::vector<double>>& lists,
                                           const RunControl& control) {
  std::vector<RankedValues> ranked;
  std::vector<ExplanationFigures> figures(lists.size());
  for (std::size_t i = 0; i < lists.size(); ++i) {
    ranked.emplace_back(lists[i]);
    figures[i].correlation = weighted_correlation(ranked[i].ranks(), work.reference_ranks);
  }
  const BlockGrid grid = work.blocks.grid(work.reference.size());
  const auto of_drawn = [&](const std::vector<int>& block_weights, const std::vector<int>&) {
    std::vector<int> weights(grid.block_of.size());
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = block_weights[grid.block_of[i]];
    const std::vector<double> reference = work.reference.ranks(weights);
    std::vector<double> values;
    for (const RankedValues& list : ranked) {
      const double rho = weighted_correlation(list.ranks(weights), reference, weights);
      values.push_back(fisher_z(rho));
    }
    return values;
  };
  const auto errors = block_standard_errors(
      grid, grid, of_drawn, {.resamples = work.options.resamples, .seed = work.seed, .is_paired = true}, control);
  for (std::size_t i = 0; errors && i < figures.size(); ++i) {
    const double z = fisher_z(figures[i].correlation);
    figures[i].low = std::tanh(z - k95Percent * (*errors)[i]);
    figures[i].high = std::tanh(z + k95Percent * (*errors)[i]);
  }
  return figures;
}

/// Figures of shuffled references.
struct Chance {
  std::vector<std::vector<double>> correlations;  ///< Correlations of each list, one a shuffle.
  std::vector<double> explained;                  ///< MixProblem::Found::explained, one a shuffle.
};

Chance chance_of(const Work& work, const std::vector<std::vector<double>>& lists, const MixProblem& problem,
                 const RunControl& control) {
  const auto count = static_cast<std::size_t>(work.options.shuffles);
  const BlockShuffles shuffles(work.input.positions_mm, work.blocks, control.part(0.0, 0.2));
  std::vector<std::vector<double>> ranks;
  for (const auto& list : lists) ranks.push_back(RankedValues(list).ranks());
  Chance chance{std::vector<std::vector<double>>(lists.size(), std::vector<double>(count)), std::vector<double>(count)};
  parallel_for(work.options.shuffles, 4, control.part(0.2, 1.0), [&](std::int64_t begin, std::int64_t end) {
    for (auto s = static_cast<std::size_t>(begin); s < static_cast<std::size_t>(end); ++s) {
      const std::vector<std::uint32_t> from = shuffles.shuffled(work.seed, s);
      std::vector<double> reference(from.size());
      for (std::size_t i = 0; i < from.size(); ++i) reference[i] = work.reference_ranks[from[i]];
      for (std::size_t k = 0; k < lists.size(); ++k)
        chance.correlations[k][s] = weighted_correlation(ranks[k], reference);
      chance.explained[s] = problem.find(reference, work.options.max_members).explained;
    }
  });
  return chance;
}

/// Correction for what blocks have broken: where a reference hangs together more widely than a block, shuffled ones
/// agree with a smooth candidate too rarely. @param shuffled  Correlations. @returns >= 1: how much wider they should
/// spread.
double missing_spread(std::span<const double> shuffled, double chance_variance) {
  double squares = 0.0;
  for (const double rho : shuffled) squares += rho * rho;
  return std::max(1.0, std::sqrt(chance_variance * static_cast<double>(shuffled.size()) / squares));
}

double share_of_as_strong(double z, std::span<const double> by_chance) {
  const auto as_strong = std::count_if(by_chance.begin(), by_chance.end(), [&](double other) { return other >= z; });
  return static_cast<double>(as_strong + 1) / static_cast<double>(by_chance.size() + 1);
}

void judge(ExplanationFigures& figures, std::vector<double> shuffled, double spread) {
  std::vector<double> strengths;
  for (double& rho : shuffled) {
    rho = std::tanh(spread * fisher_z(rho));
    strengths.push_back(std::abs(rho));
  }
  figures.p = share_of_as_strong(std::abs(figures.correlation), strengths);
  std::sort(shuffled.begin(), shuffled.end());
  const std::size_t tail = shuffled.size() / 40;
  figures.shuffled_low = shuffled[tail];
  figures.shuffled_high = shuffled[shuffled.size() - 1 - tail];
}

/// Holm's step-down: the smallest p times the number of candidates, the next times one less, never falling.
void correct(std::vector<ExplanationFigures>& figures) {
  std::vector<ExplanationFigures*> order;
  for (ExplanationFigures& f : figures) order.push_back(&f);
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) { return a->p < b->p; });
  double before = 0.0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    before = std::max(before, std::min(1.0, order[i]->p * static_cast<double>(order.size() - i)));
    order[i]->corrected_p = before;
    order[i]->explains = before <= kExplains;
  }
}

std::vector<double> values_of(const Mix& mix, const std::vector<std::vector<double>>& lists) {
  std::vector<double> values(lists.front().size());
  for (const MixMember& member : mix) {
    const std::vector<double>& own = lists[member.candidate];
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] += member.weight * (member.is_inverse ? 1.0 - own[i] : own[i]);
  }
  return values;
}

/// A mix of one: the strongest. @param singles  Figures of the candidates in use.
Mix strongest_of(const std::vector<ExplanationFigures>& singles) {
  const auto strongest = std::max_element(singles.begin(), singles.end(), [](const auto& a, const auto& b) {
    return std::abs(a.correlation) < std::abs(b.correlation);
  });
  return {{static_cast<std::size_t>(strongest - singles.begin()), strongest->correlation < 0.0, 1.0}};
}

/// Those of the inverse candidate if the correlation is negative.
ExplanationFigures turned_up(ExplanationFigures figures) {
  if (!(figures.correlation < 0.0)) return figures;
  figures.correlation = -figures.correlation;
  std::swap(figures.low, figures.high);
  if (figures.low && figures.high) figures.low = -*figures.low, figures.high = -*figures.high;
  std::swap(figures.shuffled_low, figures.shuffled_high);
  figures.shuffled_low = -figures.shuffled_low, figures.shuffled_high = -figures.shuffled_high;
  return figures;
}

/// @param singles  Figures of the candidates in use. @param spreads  Theirs.
ExplainedMix mixed(const Work& work, const MixProblem& problem, const std::vector<std::vector<double>>& lists,
                   const std::vector<ExplanationFigures>& singles, const std::vector<double>& spreads,
                   const std::vector<double>& explained_by_chance, const RunControl& control) {
  const MixProblem::Found found = problem.find(work.reference_ranks, work.options.max_members);
  const Mix single = strongest_of(singles);
  ExplainedMix mix;
  mix.members = single;
  if (found.mix.size() > 1) {
    const Mix several = weighted_mix(found.mix, lists, work.reference_ranks);
    const double strength_of_mix =
        weighted_correlation(RankedValues(values_of(several, lists)).ranks(), work.reference_ranks);
    // Members of one mind in their ranks may differ in their values.
    if (strength_of_mix > std::abs(singles[single.front().candidate].correlation)) mix.members = several;
  }
  const bool is_single = mix.members.size() == 1;
  mix.figures = is_single ? turned_up(singles[single.front().candidate])
                          : correlated(work, {values_of(mix.members, lists)}, control).front();
  double spread = 1.0;
  for (MixMember& member : mix.members) {
    spread = std::max(spread, spreads[member.candidate]);
    member.candidate = work.used[member.candidate];
  }
  std::vector<std::string> names;
  for (const ExplanationCandidate& c : work.input.candidates) names.push_back(c.name);
  mix.expression = mix_expression(mix.members, names);
  mix.left_out_correlation = weighted_correlation(RankedValues(found.predicted).ranks(), work.reference_ranks);
  if (is_single) return mix;
  const auto strength = [](double explained) { return fisher_z(std::sqrt(std::clamp(explained, 0.0, 1.0))); };
  std::vector<double> by_chance;
  for (const double explained : explained_by_chance) by_chance.push_back(spread * strength(explained));
  mix.figures.p = share_of_as_strong(strength(found.explained), by_chance);
  mix.figures.corrected_p = mix.figures.p;
  mix.figures.explains = mix.figures.p <= kExplains;
  return mix;
}

void add_figures(Explanation& out, const Work& work, const RunControl& control) {
  std::vector<std::vector<double>> lists;
  for (const std::size_t c : work.used) lists.push_back(work.input.candidates[c].values);
  std::vector<ExplanationFigures> figures = correlated(work, lists, control.part(0.0, 0.3));
  std::vector<std::vector<double>> ranks;  // In [0, 1].
  for (const auto& list : lists) {
    ranks.push_back(RankedValues(list).ranks());
    for (double& rank : ranks.back()) rank /= static_cast<double>(list.size() - 1);
  }
  const MixProblem problem(ranks, work.blocks, work.seed);
  const Chance chance = chance_of(work, lists, problem, control.part(0.3, 0.9));
  std::vector<double> spreads;
  for (std::size_t k = 0; k < figures.size(); ++k) {
    spreads.push_back(
        missing_spread(chance.correlations[k], work.correlograms.chance_variance(0, k + 1, work.reference.size())));
    judge(figures[k], chance.correlations[k], spreads[k]);
  }
  correct(figures);
  out.mix = mixed(work, problem, lists, figures, spreads, chance.explained, control.part(0.9, 1.0));
  for (std::size_t k = 0; k < figures.size(); ++k)
    out.candidates.push_back({.name = work.input.candidates[work.used[k]].name, .figures = figures[k]});
  std::stable_sort(out.candidates.begin(), out.candidates.end(), [](const auto& a, const auto& b) {
    return std::abs(a.figures.correlation) > std::abs(b.figures.correlation);
  });
}

}  // namespace

Explanation explain(const ExplanationInput& input, const ExplanationOptions& options, std::uint64_t seed,
                    const RunControl& control) {
  check_ranges(options);
  check(input, options);
  Work work{.input = input, .options = options, .seed = seed, .reference = RankedValues(input.reference)};
  work.reference_ranks = work.reference.ranks();
  std::vector<std::vector<double>> lists{work.reference_ranks};
  for (std::size_t c = 0; c < input.candidates.size(); ++c) {
    if (is_even(input.candidates[c].values)) continue;
    work.used.push_back(c);
    lists.push_back(RankedValues(input.candidates[c].values).ranks());
  }
  work.correlograms = correlograms(input.positions_mm, lists, control.part(0.0, 0.05));
  Explanation out;
  out.range_mm = work.correlograms.range_mm(0);
  int count = suited_block_count(out.range_mm, input.area_mm2);
  if (options.block_mm)
    count = static_cast<int>(
        std::clamp(input.area_mm2 / (*options.block_mm * *options.block_mm), double{kMinBlocks}, double{kMaxBlocks}));
  work.blocks = make_surface_blocks(input.positions_mm, count, input.area_mm2);
  out.num_blocks = static_cast<int>(work.blocks.members.size());
  out.block_mm = work.blocks.edge_mm;
  out.is_coarse = out.block_mm < 0.99 * kRangesInBlock * out.range_mm;
  if (!work.used.empty()) add_figures(out, work, control.part(0.05, 1.0));
  for (const ExplanationCandidate& c : input.candidates) {
    if (is_even(c.values)) out.candidates.push_back({.name = c.name, .is_even = true});
  }
  control.report(1.0);
  return out;
}

}  // namespace patinate::analysis
