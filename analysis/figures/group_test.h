/// \file
/// Do two groups differ by more than their members differ among themselves? From distances between members alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace patinate::analysis {

/// Permutations of the group labels; the first is the observed one, in which A's members come first.
struct Labelings {
  std::size_t size_a = 0;
  std::size_t size_b = 0;
  std::vector<std::vector<std::uint8_t>> is_a = {};  ///< [labeling][member]
  bool is_exact = true;                              ///< Every one once; else the true one and random ones.
  double smallest_p = 1.0;  ///< That a permutation test on them can give: groups of equal size have a mirror image.
};
/// All of them, or the true one and `most` - 1 random ones where they are more. @param size_a,size_b  >= 2.
/// @param most  >= 2. @throws InvalidInput. Same for any number of threads.
[[nodiscard]] Labelings make_labelings(std::size_t size_a, std::size_t size_b, std::size_t most, std::uint64_t seed);

/// Smallest p that a permutation test can give where all labelings are looked at: 1 of C(a + b, a), 2 where a = b.
[[nodiscard]] double smallest_permutation_p(std::size_t size_a, std::size_t size_b);

/// Index of the distance of members i < j in a list of all pairs, (0, 1), (0, 2), ... @param count  Of members.
[[nodiscard]] std::size_t pair_index(std::size_t i, std::size_t j, std::size_t count);

/// Squares of the gap between the groups under every labeling [Anderson 2001]: mean squared distance between groups
/// less half the sum of the mean squared distances within. Of numbers it is the squared difference of means without the
/// bias by chance: 0 in the mean for equal groups, and negative as often.
/// @param distances  Of all pairs, see pair_index(). Cost: O(labelings x pairs).
[[nodiscard]] std::vector<double> squared_gaps(std::span<const double> distances, const Labelings& labelings);

/// Differences of two groups, from distances.
struct GroupDifference {
  double between = 0.0;   ///< Root mean square distance of a member of A and one of B.
  double within_a = 0.0;  ///< Mean distance of two members of A.
  double within_b = 0.0;
  double gap = 0.0;       ///< Excess of `between` over both, in squares; 0 where it is less.
  double spread_a = 0.0;  ///< Standard deviation of one member: within_a / sqrt(2).
  double spread_b = 0.0;
  double spread = 0.0;             ///< Spread of both, by their degrees of freedom.
  std::optional<double> effect;    ///< gap / spread, as Cohen's d; nothing where members of no side differ.
  std::optional<double> effect_a;  ///< gap / spread_a.
  std::optional<double> effect_b;
  double p = 1.0;  ///< Share of labelings whose gap is at least as large.
};
/// @param gaps  squared_gaps() of the same.
[[nodiscard]] GroupDifference group_difference(std::span<const double> distances, const Labelings& labelings,
                                               std::span<const double> gaps);

/// p of "no figure differs": of the largest gap of a labeling over all figures, each over the mean square of its
/// distances. Needs no correction for their number [max statistic, Westfall and Young 1993]. 1 where nothing differs.
/// @param distances  [figure][pair]. @param gaps  [figure][labeling].
[[nodiscard]] double overall_p(std::span<const std::vector<double>> distances,
                               std::span<const std::vector<double>> gaps);

/// p values corrected for their number [Holm 1979]: the chance that any is below its level by chance is that level.
[[nodiscard]] std::vector<double> holm_corrected(std::span<const double> p);

}  // namespace patinate::analysis
