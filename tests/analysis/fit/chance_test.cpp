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

TEST(Chance, OneMoreDrawLiesBelowTheBoundInNineOfTenCases) {
  constexpr int kTrials = 20000;
  // 4 sigma of a share; the expansion of Student's quantile is off by less than 0.2 % of cases from 4 draws on.
  const double tolerance = 4.0 * std::sqrt(0.9 * 0.1 / kTrials) + 0.002;
  for (const int num_draws : {4, 8, 20}) {
    int num_below = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      RandomStream random(3, static_cast<std::uint64_t>(trial), static_cast<std::uint32_t>(num_draws));
      std::vector<double> draws;
      for (int k = 0; k < num_draws; ++k) draws.push_back(5.0 + random.normal());
      num_below += 5.0 + random.normal() <= prediction_bound(draws);
    }
    EXPECT_NEAR(static_cast<double>(num_below) / kTrials, 0.9, tolerance) << num_draws << " draws";
  }
}

TEST(Chance, WhatTheModelLacksIsAddedInSquares) {
  const std::vector<double> draws{1.0, 1.2, 0.8, 1.1, 0.9};
  const double bound = prediction_bound(draws);  // The mean is 1.
  EXPECT_DOUBLE_EQ(untellable_objective(0.5, draws), bound);
  EXPECT_DOUBLE_EQ(untellable_objective(1.0, draws), bound);
  const double lack = 3.0, best = std::sqrt(1.0 + lack * lack);
  EXPECT_NEAR(untellable_objective(best, draws), std::sqrt(bound * bound + lack * lack), 1e-12);
}

TEST(Chance, WithoutOrWithFewDrawsItIsAGuessOnTheSafeSide) {
  EXPECT_DOUBLE_EQ(untellable_objective(2.0, {}), 2.02);
  EXPECT_DOUBLE_EQ(prediction_bound(std::vector<double>{0.3, 0.4}), 0.8);
  EXPECT_TRUE(has(error_of([] { (void)prediction_bound({}); }), "no draws"));
}

}  // namespace
}  // namespace patinate::analysis
