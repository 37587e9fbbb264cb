/// \file
/// Which parameter of a surface explains a reference: how far each follows it, with what certainty, and which few
/// together follow it best.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/explanation/sparse_mix.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"

namespace patinate::analysis {

/// Settings of explain().
struct ExplanationOptions {
  int num_samples = 16000;  ///< Places looked at, each for as much of the surface; [500, 100000].
  std::optional<double>
      block_mm{};       ///< Edge of the blocks that count as independent; > 0. Not given: suited_block_count().
  int max_members = 3;  ///< Most members of the mix; [1, 8].
  int resamples = 400;  ///< Surfaces of drawn blocks that give the intervals; [50, 10000].
  int shuffles = 999;   ///< Surfaces of shuffled blocks that give the p values; [99, 100000].
};
void describe(OptionVisitor& v, ExplanationOptions& o);

/// Fewer places than this say nothing.
inline constexpr std::size_t kFewestPlaces = 500;
/// Greatest p value, after correction, of what is called an explanation.
inline constexpr double kExplains = 0.05;

/// A parameter that may explain the reference.
struct ExplanationCandidate {
  std::string name;            ///< Name as an expression says it; unique.
  std::vector<double> values;  ///< At every place, in [0, 1].
};

/// Places on a surface, each for an equal part of it.
struct ExplanationInput {
  std::vector<Vec3> positions_mm;
  double area_mm2 = 0.0;          ///< Area of all the parts together; > 0.
  std::vector<double> reference;  ///< Finite; any unit: only its order counts.
  std::vector<ExplanationCandidate> candidates;
};

/// Spearman's rank correlation and what it is worth.
struct ExplanationFigures {
  double correlation = 0.0;         ///< [-1, 1].
  std::optional<double> low, high;  ///< 95 % interval: blocks drawn again (block_standard_errors()), on the
                                    ///< scale of atanh. Nothing where the bootstrap fails.
  double shuffled_low = 0.0, shuffled_high = 0.0;  ///< Middle 95 % of what shuffled references give.
  double p = 1.0;            ///< Share of shuffled references, this one counted in, with as strong a correlation.
  double corrected_p = 1.0;  ///< By the number of candidates [Holm 1979].
  bool explains = false;     ///< corrected_p <= kExplains.
};

struct ExplainedCandidate {
  std::string name;
  bool is_even = false;  ///< Equal at all places: it can explain nothing, and has no figures.
  ExplanationFigures figures = {};
};

/// The best mix of few candidates.
struct ExplainedMix {
  Mix members;             ///< Into ExplanationInput::candidates; empty when all are even.
  std::string expression;  ///< mix_expression().
  /// Figures of the expression's values. With several members, p comes of the whole search, repeated for every shuffled
  /// reference, and needs no correction; a single one has its own figures, the correlation without sign.
  ExplanationFigures figures;
  double left_out_correlation = 0.0;  ///< Rank correlation of what mixes of the other parts predict of each left out
                                      ///< part: what to expect of another surface aged the same way.
};

struct Explanation {
  std::vector<ExplainedCandidate> candidates;  ///< The strongest first, even ones last.
  ExplainedMix mix;
  int num_blocks = 0;
  double block_mm = 0.0;   ///< SurfaceBlocks::edge_mm.
  double range_mm = 0.0;   ///< correlation_range_mm() of the reference.
  bool is_coarse = false;  ///< The reference hangs together so widely that blocks of kRangesInBlock ranges would be
                           ///< fewer than kMinBlocks, or smaller ones were asked for: intervals promise too much.
};

/// @throws InvalidInput if even the least p value that so many shuffles give would not pass kExplains after correction.
void check_shuffles(const ExplanationOptions& options, std::size_t num_candidates);

/// Correlations of all candidates and their best mix.
///
/// Blocks of the surface are the unit: intervals come of blocks drawn with replacement, p values of references whose
/// blocks were permuted (BlockShuffles), so that neither takes neighboring places, which are alike, for many.
/// @throws InvalidInput if an option is out of range, lists differ in length, there are fewer than kFewestPlaces
/// places, fewer shuffles than can tell so many candidates from chance, a value is not finite, or the reference is the
/// same everywhere.
/// Cost: about 2 s for 16,000 places and 10 candidates. Same bits for any number of threads.
[[nodiscard]] Explanation explain(const ExplanationInput& input, const ExplanationOptions& options, std::uint64_t seed,
                                  const RunControl& control = {});

}  // namespace patinate::analysis
