/// \file
/// The few controls whose weighted mean follows a reference best.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/explanation/surface_blocks.h"

namespace patinate::analysis {

inline constexpr int kMixFolds = 8;  ///< Parts of the surface, each left out once.

struct MixMember {
  std::size_t candidate = 0;
  bool is_inverse = false;  ///< 1 - value takes part in place of the value.
  double weight = 0.0;      ///< > 0; those of a mix sum to 1.
};
using Mix = std::vector<MixMember>;

/// Candidates of a mix and the surface's parts. Each part is blocks drawn at random, so that what is left out is no
/// neighbor of what was fitted, but for blocks' borders.
class MixProblem {
 public:
  /// @param values  Of each candidate at every sample, in [0, 1]: ranks, to follow the reference's ranks whatever the
  /// candidate's scale is.
  MixProblem(std::vector<std::vector<double>> values, const SurfaceBlocks& blocks, std::uint64_t seed);

  struct Found {
    Mix mix;
    double explained = 0.0;  ///< Share of the reference's variance that mixes of the other parts predict of each left
                             ///< out part; 1 = all, <= 0 = nothing.
    std::vector<double> predicted;  ///< At every sample, by a mix that has not seen its part.
  };
  /// Weighted means of values or inverse values that follow the reference's ranks best in least squares [forward
  /// selection; weights > 0, so that each member helps in the direction in which it is related]. A further member is
  /// taken when it explains at least half a percent more of the left out parts, and by more than that gain's standard
  /// error over them [the rule of one standard error, Breiman et al. 1984, over pairs].
  /// @param ranks  Of the reference, one a sample. @param most  Members; [1, 8].
  [[nodiscard]] Found find(std::span<const double> ranks, int most) const;

 private:
  struct Sums;
  struct Fit;
  [[nodiscard]] std::vector<Sums> part_sums(std::span<const double> ranks) const;
  [[nodiscard]] Fit grown(const Sums& sums, const Fit& from) const;
  [[nodiscard]] static double error_of(const Sums& part, const Fit& fit);

  std::vector<std::vector<double>> values_;
  std::vector<std::uint8_t> part_of_;       ///< Part of every sample.
  std::vector<std::vector<double>> outer_;  ///< For each part: sums of products of two candidates, row by row.
  std::vector<std::vector<double>> sum_;    ///< For each part: sums of candidates.
  std::vector<double> count_;               ///< Samples of each part.
};

/// Gives the same members the weights that their values, which maps have in place of ranks, ask for: least squares
/// against the reference's ranks, or where that would turn one round, as strong as among ranks. Whole hundredths that
/// sum to 1, the heaviest first. @param chosen  Not empty. @param values  Of the candidates, in [0, 1].
[[nodiscard]] Mix weighted_mix(const Mix& chosen, const std::vector<std::vector<double>>& values,
                               std::span<const double> ranks);

/// The mix as an expression of control maps: "0.7*!height + 0.3*facing". @param names  Of the candidates; those that
/// are more than a name get parentheses.
[[nodiscard]] std::string mix_expression(const Mix& mix, std::span<const std::string> names);

}  // namespace patinate::analysis
