// Two groups by the distances of their members: closed forms, and rates of chance.
#include "analysis/figures/group_test.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate::analysis {
namespace {

std::vector<double> distances_of(const std::vector<double>& values) {
  std::vector<double> out;
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (std::size_t j = i + 1; j < values.size(); ++j) out.push_back(std::abs(values[i] - values[j]));
  }
  return out;
}

GroupDifference difference_of(const std::vector<double>& values, const Labelings& labelings) {
  const std::vector<double> distances = distances_of(values);
  return group_difference(distances, labelings, squared_gaps(distances, labelings));
}

std::vector<double> normals(std::size_t count, std::uint64_t seed) {
  RandomStream random(seed, 0);
  std::vector<double> out(count);
  for (double& v : out) v = random.normal();
  return out;
}

/// Successes that no more than one in 10^4 series of `n` with chance p exceed, by the sum of the binomial law.
int binomial_limit(int n, double p) {
  double below = 0.0;
  for (int k = 0; k <= n; ++k) {
    below += std::exp(std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0) + k * std::log(p) +
                      (n - k) * std::log1p(-p));
    if (below > 1.0 - 1e-4) return k;
  }
  return n;
}

TEST(GroupTest, PairsAreListedInOrder) {
  std::size_t expected = 0;
  for (std::size_t i = 0; i < 7; ++i) {
    for (std::size_t j = i + 1; j < 7; ++j) EXPECT_EQ(pair_index(i, j, 7), expected++);
  }
}

TEST(GroupTest, OfNumbersTheGapIsTheDifferenceOfMeansAndTheSpreadTheirStandardDeviation) {
  // Means 2 and 7, variances 1 and 4; the square of the gap is (7 - 2)^2 less what the means are off by chance.
  const Labelings labelings = make_labelings(3, 3, 100, 1);
  const GroupDifference d = difference_of({1, 2, 3, 5, 7, 9}, labelings);
  EXPECT_NEAR(d.spread_a, 1.0, 1e-12);
  EXPECT_NEAR(d.spread_b, 2.0, 1e-12);
  EXPECT_NEAR(d.spread, std::sqrt(2.5), 1e-12);
  EXPECT_NEAR(d.gap * d.gap, 25.0 - 1.0 / 3.0 - 4.0 / 3.0, 1e-12);
  EXPECT_NEAR(*d.effect, d.gap / d.spread, 1e-12);
}

TEST(GroupTest, ThreeAgainstThreeCannotGoBelowATenth) {
  const Labelings labelings = make_labelings(3, 3, 20000, 1);
  EXPECT_EQ(labelings.is_a.size(), 20u);
  EXPECT_DOUBLE_EQ(labelings.smallest_p, 0.1);
  EXPECT_DOUBLE_EQ(difference_of({0, 1, 2, 100, 101, 102}, labelings).p, 0.1);
  EXPECT_DOUBLE_EQ(smallest_permutation_p(2, 5), 1.0 / 21.0);
  EXPECT_DOUBLE_EQ(difference_of({0, 1, 100, 101, 102, 103, 104}, make_labelings(2, 5, 20000, 1)).p, 1.0 / 21.0);
}

TEST(GroupTest, EqualMembersHaveNoEffectAndNoEvidence) {
  const GroupDifference d = difference_of({4, 4, 4, 4}, make_labelings(2, 2, 100, 1));
  EXPECT_EQ(d.gap, 0.0);
  EXPECT_FALSE(d.effect);
  EXPECT_EQ(d.p, 1.0);
}

TEST(GroupTest, SampledLabelingsSayWhatAllOfThemSay) {
  // There are 12870 labelings of 8 against 8; 2000 draws know a share to 4 sqrt(p (1 - p) / 2000).
  std::vector<double> values = normals(16, 3);
  for (std::size_t i = 8; i < 16; ++i) values[i] += 0.7;
  const Labelings all = make_labelings(8, 8, 20000, 1), some = make_labelings(8, 8, 2000, 1);
  ASSERT_TRUE(all.is_exact);
  ASSERT_FALSE(some.is_exact);
  EXPECT_EQ(some.is_a.size(), 2000u);
  for (const auto& is_a : some.is_a) ASSERT_EQ(std::count(is_a.begin(), is_a.end(), 1), 8);
  const double p = difference_of(values, all).p;
  EXPECT_NEAR(difference_of(values, some).p, p, 4.0 * std::sqrt(p * (1.0 - p) / 2000.0));
  EXPECT_DOUBLE_EQ(some.smallest_p, 1.0 / 2000.0);
}

TEST(GroupTest, GroupsOfOneProcessAreCalledDifferentAsOftenAsItSays) {
  // 4 against 4: p is a multiple of 2 / 70, so it is at most 0.1 in 6 of 70 null cases.
  const Labelings labelings = make_labelings(4, 4, 20000, 1);
  constexpr int kSets = 1000;
  int alarms = 0;
  for (int s = 0; s < kSets; ++s)
    alarms += difference_of(normals(8, 100 + static_cast<std::uint64_t>(s)), labelings).p <= 0.1 ? 1 : 0;
  EXPECT_LE(alarms, binomial_limit(kSets, 6.0 / 70.0));
  EXPECT_LE(kSets - alarms, binomial_limit(kSets, 64.0 / 70.0));
}

TEST(GroupTest, AmongManyFiguresNoneIsCalledDifferentMoreOftenThanItSays) {
  // Ten figures, five of them nearly the same, 6 against 6: C(12, 6) = 924, so that 10 x 2 / 924 is below 0.05.
  const Labelings labelings = make_labelings(6, 6, 20000, 1);
  constexpr int kSets = 150;
  int holm = 0, overall = 0;
  for (int s = 0; s < kSets; ++s) {
    std::vector<std::vector<double>> distances, gaps;
    std::vector<double> p;
    const std::vector<double> shared = normals(12, 7000 + static_cast<std::uint64_t>(s));
    for (std::uint64_t f = 0; f < 10; ++f) {
      std::vector<double> values = normals(12, 20000 + 10 * static_cast<std::uint64_t>(s) + f);
      for (std::size_t i = 0; i < 12 && f < 5; ++i) values[i] = shared[i] + 0.1 * values[i];
      distances.push_back(distances_of(values));
      gaps.push_back(squared_gaps(distances.back(), labelings));
      p.push_back(group_difference(distances.back(), labelings, gaps.back()).p);
    }
    const std::vector<double> corrected = holm_corrected(p);
    holm += *std::min_element(corrected.begin(), corrected.end()) <= 0.05 ? 1 : 0;
    overall += overall_p(distances, gaps) <= 0.05 ? 1 : 0;
  }
  EXPECT_LE(holm, binomial_limit(kSets, 0.05));
  EXPECT_LE(overall, binomial_limit(kSets, 0.05));
}

TEST(GroupTest, ADifferenceOfThreeSpreadsIsFound) {
  const Labelings labelings = make_labelings(5, 5, 20000, 1);
  int found = 0;
  for (std::uint64_t s = 0; s < 100; ++s) {
    std::vector<double> values = normals(10, 500 + s);
    for (std::size_t i = 5; i < 10; ++i) values[i] += 3.0;
    found += difference_of(values, labelings).p <= 0.05 ? 1 : 0;
  }
  // A t test of d = 3 with 5 against 5 finds 0.983 of them [noncentral t, 8 degrees of freedom]: 0.95 is 2.5 sigma
  // less.
  EXPECT_GE(found, 95);
}

TEST(GroupTest, HolmMultipliesTheSmallestByTheirNumberAndKeepsTheirOrder) {
  const std::vector<double> p{0.04, 0.01, 0.5, 0.03};
  const std::vector<double> expected{0.09, 0.04, 0.5, 0.09};  // Worked by hand: 4 x 0.01, 3 x 0.03, then no less.
  const std::vector<double> found = holm_corrected(p);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(found[i], expected[i], 1e-12);
  EXPECT_TRUE(holm_corrected({}).empty());
}

TEST(GroupTest, RefusesGroupsOfOne) {
  EXPECT_THROW((void)make_labelings(1, 5, 100, 1), InvalidInput);
  EXPECT_THROW((void)make_labelings(2, 2, 1, 1), InvalidInput);
}

}  // namespace
}  // namespace patinate::analysis
