#include "libcommon/metrics/correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "patinate/core/error.h"

namespace patinate {
namespace {

TEST(RankCorrelation, IsOneForAnyRisingFunctionAndMinusOneForAnyFalling) {
  const std::vector<double> x{-2.0, 0.5, 1.0, 7.0, 9.0};
  std::vector<double> rising, falling;
  for (double v : x) {
    rising.push_back(std::exp(v));
    falling.push_back(-v * v * v);
  }
  EXPECT_DOUBLE_EQ(rank_correlation(x, rising), 1.0);
  EXPECT_DOUBLE_EQ(rank_correlation(x, falling), -1.0);
}

TEST(RankCorrelation, SharesRanksBetweenEqualValues) {
  // By hand: ranks 0.5 0.5 2 3 against 0 1 2 3: 4.5 / sqrt(4.5 * 5).
  EXPECT_NEAR(rank_correlation(std::vector<double>{1, 1, 2, 3}, std::vector<double>{1, 2, 3, 4}), 4.5 / std::sqrt(22.5),
              1e-15);
  EXPECT_EQ(rank_correlation(std::vector<double>{1, 1, 1}, std::vector<double>{1, 2, 3}), 0.0);
}

TEST(RankCorrelation, RefusesWhatHasNoRanks) {
  EXPECT_THROW((void)rank_correlation(std::vector<double>{1}, std::vector<double>{1}), InvalidInput);
  EXPECT_THROW((void)rank_correlation(std::vector<double>{1, 2}, std::vector<double>{1, 2, 3}), InvalidInput);
  EXPECT_THROW((void)rank_correlation(std::vector<double>{1, std::nan("")}, std::vector<double>{1, 2}), InvalidInput);
}

}  // namespace
}  // namespace patinate
