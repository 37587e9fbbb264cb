#include "analysis/fit/chance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "libcommon/core/random.h"
#include "tests/support/errors.h"

namespace patinate::analysis {
namespace {

using testing_support::error_of;
using testing_support::has;

// A linear model with orthonormal numbers: the objective is the root mean square of N residuals, of which as many as
// there are numbers are fitted, and a number that is off by e adds e^2 / N to the square.
TEST(Chance, IntervalsOfALinearModelHoldAllTrueNumbersInNineOfTenCases) {
  constexpr int kTrials = 20000, kNumResiduals = 60, kNumDraws = 8;
  for (const double lack : {0.0, 3.0}) {  // The model's lack is in best and truth.
    for (const int num_numbers : {1, 2, 4}) {
      int num_held = 0;
      for (int trial = 0; trial < kTrials; ++trial) {
        RandomStream random(3, static_cast<std::uint64_t>(trial), static_cast<std::uint32_t>(num_numbers));
        const auto sum_of_squares = [&](int n) {
          double sum = 0.0;
          for (int i = 0; i < n; ++i) {
            const double x = random.normal();
            sum += x * x;
          }
          return sum;
        };
        std::vector<double> draws;
        for (int k = 0; k < kNumDraws; ++k) draws.push_back(std::sqrt(sum_of_squares(kNumResiduals) / kNumResiduals));
        const double best = std::sqrt(sum_of_squares(kNumResiduals - num_numbers) / kNumResiduals + lack * lack);
        const double limit = untellable_objective(best, draws, num_numbers);
        const double reach = std::sqrt(kNumResiduals * (limit * limit - best * best));
        bool all = true;
        for (int i = 0; i < num_numbers; ++i) all = std::abs(random.normal()) <= reach && all;
        num_held += all;
      }
      // 4 sigma of a share; the variance of a root of a sum of N squares is 1 / (2 N) to a share of 1 / (4 N), and z at
      // the limit changes by half of that.
      const double tolerance = 4.0 * std::sqrt(0.9 * 0.1 / kTrials) + 0.002;
      EXPECT_NEAR(static_cast<double>(num_held) / kTrials, 0.9, tolerance) << num_numbers << " numbers, lack " << lack;
    }
  }
}

TEST(Chance, TheLimitNeverFallsOntoTheBest) {
  const std::vector<double> draws{1.0, 1.2, 0.8, 1.1, 0.9};
  for (const double best : {0.0, 0.5, 1.0, 1.3, 20.0}) EXPECT_GT(untellable_objective(best, draws, 2), best);
  EXPECT_LT(untellable_objective(1.0, draws, 1), untellable_objective(1.0, draws, 3));  // All are to be held at once.
}

TEST(Chance, WithoutOrWithFewDrawsItIsAGuessOnTheSafeSide) {
  EXPECT_DOUBLE_EQ(untellable_objective(2.0, {}, 1), 2.02);
  EXPECT_DOUBLE_EQ(untellable_objective(2.0, std::vector<double>{0.3, 0.4}, 1), 2.4);
  EXPECT_TRUE(has(error_of([] { (void)untellable_objective(1.0, {}, 0); }), "at least one number"));
}

}  // namespace
}  // namespace patinate::analysis
