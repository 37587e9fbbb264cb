#include "capture/stability/restless_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "libcommon/core/random.h"

namespace patinate::capture {
namespace {

/// Pairs of a series whose photographs have these factors of light, in logarithms; only blue changes.
std::vector<FramePair> pairs_in_light(int num_photographs, const std::function<double(int)>& log_light) {
  std::vector<FramePair> pairs;
  for (int i = 1; i < num_photographs; ++i) {
    FramePair pair;
    pair.reference = i - 1;
    pair.frame = i;
    pair.change.log_gain = {0.0, 0.0, log_light(i) - log_light(i - 1)};
    pairs.push_back(pair);
  }
  return pairs;
}

double unsteady(int i) { return 0.1 * RandomStream(3, static_cast<std::uint64_t>(i), 0).normal(); }

TEST(RestlessLight, TellsHowMuchThePhotographsDiffer) {
  constexpr int kMany = 4000;
  const auto light = find_restless_light(pairs_in_light(kMany, unsteady));
  ASSERT_TRUE(light);
  EXPECT_EQ(light->channel, 2);
  // The error of a standard deviation from medians is 1.17 / sqrt(n) of it, some more as followers share photographs:
  // 0.02 of it, of which four are allowed. Gains differ by sqrt(2) as much as photographs, times six.
  EXPECT_NEAR(std::log1p(light->deviation), 0.1, 0.008);
  EXPECT_NEAR(std::log(light->hidden), 6.0 * std::sqrt(2.0) * 0.1, 6.0 * std::sqrt(2.0) * 0.008);
}

TEST(RestlessLight, SteadyCoursesHideNothing) {
  EXPECT_FALSE(find_restless_light(pairs_in_light(12, [](int) { return 0.0; })));
  EXPECT_FALSE(find_restless_light(pairs_in_light(12, [](int i) { return 0.3 * i; }))) << "brightens steadily";
  EXPECT_FALSE(find_restless_light(pairs_in_light(24, [](int i) { return 4.0 * std::exp(-i / 8.0); })))
      << "and less and less";
}

TEST(RestlessLight, OneOtherExposureIsNotUnrest) {
  EXPECT_FALSE(find_restless_light(pairs_in_light(12, [](int i) { return i == 5 || i == 6 ? 0.4 : 0.0; })));
}

TEST(RestlessLight, FewPairsAreJudgedInAnotherWay) {
  EXPECT_FALSE(find_restless_light(pairs_in_light(static_cast<int>(kFewPairs) + 1, unsteady)));
}

TEST(RestlessLight, WhatIsBelowTheThresholdIsNoUnrest) {
  EXPECT_FALSE(find_restless_light(pairs_in_light(400, unsteady), {.exposure_threshold = 0.2}));
}

}  // namespace
}  // namespace patinate::capture
