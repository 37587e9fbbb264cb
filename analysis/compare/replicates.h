/// \file
/// Several histories of one process against several of another: is what is between them more than what is within?
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/figures/compared_pair.h"
#include "analysis/figures/group_test.h"
#include "patinate/core/json.h"

namespace patinate::analysis {

/// One figure of two replicates as a distance: >= 0, and the same whichever comes first.
struct PairDistance {
  std::string name = {};  ///< snake_case.
  std::string title = {};
  std::string unit = {};
  std::string section = {};
  std::optional<double> value = {};
  std::string undefined = {};  ///< Why there is no value; "" when there is one.
};
/// Figures of a comparison of the two that are distances: figures of the pair as they are (SSIM as 1 - SSIM), and
/// of figures of each side the absolute difference. Left out is what has a direction (clock, delay), medians beside
/// the distance of their distributions, and cracks by halves of a control.
[[nodiscard]] std::vector<PairDistance> pair_distances(const ComparedPair& pair, const CompareOptions& options,
                                                       const RunControl& control = {});
[[nodiscard]] Json pair_distance_json(const PairDistance& distance);
/// The inverse; for files of our own only.
[[nodiscard]] PairDistance pair_distance_from_json(const Json& json);

/// One figure of all replicates.
struct ReplicateFigure {
  PairDistance what = {};              ///< Without value; `undefined` where some pair has none.
  std::vector<double> distances = {};  ///< Distances of all pairs, see pair_index(); empty when undefined.
  std::optional<GroupDifference> difference = {};
  double p_corrected = 1.0;  ///< By Holm, for the number of defined figures.
};

struct ReplicateComparison {
  std::vector<ReplicateFigure> figures = {};
  std::size_t size_a = 0, size_b = 0;
  std::size_t num_labelings = 0;
  bool is_exact = true;  ///< All labelings were looked at.
  double smallest_p = 1.0;
  double smallest_p_corrected = 1.0;  ///< Smallest p corrected of one figure that differs alone.
  double overall_p = 1.0;             ///< That no figure differs.
  std::size_t num_defined = 0;
  /// Replicates a side from which on one figure alone can be below 0.05 after the correction.
  std::size_t enough_a_side = 0;
};
/// Labelings up to this are all looked at.
inline constexpr std::size_t kMaxLabelings = 20000;

/// @param pairs  Distances of all pairs, see pair_index(): the replicates of A come first. @throws InvalidInput if a
/// side has fewer than two.
[[nodiscard]] ReplicateComparison compare_replicates(const std::vector<std::vector<PairDistance>>& pairs,
                                                     std::size_t size_a, std::size_t size_b, std::uint64_t seed);

/// A header and a row for each figure.
[[nodiscard]] std::string replicate_figures_csv(const ReplicateComparison& comparison);
/// A header and a row for each figure and pair: for statistics of one's own. @param names  Of the replicates.
[[nodiscard]] std::string replicate_distances_csv(const ReplicateComparison& comparison,
                                                  const std::vector<std::string>& names);

}  // namespace patinate::analysis
