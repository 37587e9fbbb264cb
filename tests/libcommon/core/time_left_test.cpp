#include "libcommon/core/time_left.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace patinate {
namespace {

/// The largest factor between what is estimated and what is true, over all reports of work that takes `total` seconds.
/// @param from  Estimates before that time do not count.
double largest_error(double total, const std::function<double(double)>& fraction_at, double step, double from = 0.0) {
  TimeLeft left;
  double worst = 1.0, last = 0.0;
  int num_estimates = 0;
  for (double t = step; t < total - 1.0; t += step) {
    const double fraction = fraction_at(t);
    left.add(t, fraction);
    const auto estimate = left.seconds();
    if (!estimate || t < from || fraction == last) continue;  // It is shown when progress is reported.
    last = fraction;
    ++num_estimates;
    worst = std::max({worst, *estimate / (total - t), (total - t) / *estimate});
  }
  EXPECT_GT(num_estimates, 3);
  return worst;
}

// The truth is the work's own clock. Time over fraction was 13 times too long here: (5 + 0.2) / 0.02 s of 20.
TEST(TimeLeft, OfWorkThatBeginsWithAStartUpIsRightFromTheFirstEstimateOn) {
  const auto after_start_up = [](double t) { return t < 5.0 ? 0.0 : (t - 5.0) / 15.0; };
  EXPECT_LT(largest_error(20.0, after_start_up, 0.1), 1.05);
}

// Work of an interrupted run is no speed of this one: time over fraction said 1 s of 40.
TEST(TimeLeft, OfResumedWorkCountsWhatThisRunDoes) {
  const auto resumed = [](double t) { return 0.8 + 0.2 * t / 40.0; };
  EXPECT_LT(largest_error(40.0, resumed, 0.1), 1.05);
}

TEST(TimeLeft, FollowsAChangeOfSpeedWithinTwoThirdsOfTheTime) {
  const auto faster = [](double t) {
    return t < 30.0 ? 0.1 * t / 30.0 : 0.1 + 0.9 * (t - 30.0) / 120.0;
  };  // Nine tenths in the last 120 s.
  EXPECT_LT(largest_error(150.0, faster, 0.1, 95.0), 1.1);
}

// A short stage takes four times as long as its weight says, the others somewhat less: by the last third of the time
// the estimate was 1.62 times the truth.
TEST(TimeLeft, IsNotMisledByAShortStageThatIsSlowerThanItsWeight) {
  const auto stages = [](double t) {
    return t < 50.0 ? 0.58 * t / 50.0 : t < 65.0 ? 0.58 + 0.06 * (t - 50.0) / 15.0 : 0.64 + 0.36 * (t - 65.0) / 35.0;
  };
  EXPECT_LT(largest_error(100.0, stages, 0.1, 10.0), 1.45);
}

// 40 items of 3 s, four side by side, each reported at its end: four reports at once, then nothing for 3 s.
TEST(TimeLeft, OfItemsSideBySideIsNotMisledByTheirReportingTogether) {
  const auto items = [](double t) { return std::floor(t / 3.0) * 4.0 / 41.0; };
  EXPECT_LT(largest_error(30.75, items, 0.1), 1.3);
}

TEST(TimeLeft, SaysNothingWithTooLittleToGoBy) {
  TimeLeft left;
  EXPECT_FALSE(left.seconds());
  for (int i = 1; i <= 100; ++i) left.add(0.01 * i, 0.001 * i);
  EXPECT_FALSE(left.seconds());  // 1 s.
  left.add(500.0, 0.11);
  left.add(900.0, 0.115);
  ASSERT_TRUE(left.seconds());
  EXPECT_GT(*left.seconds(), 900.0);
}

}  // namespace
}  // namespace patinate
