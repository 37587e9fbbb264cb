#include "analysis/grading/growth_forecast.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "libcommon/core/random.h"

namespace patinate::analysis {
namespace {

std::vector<double> steps(double begin, double end, int count) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(begin + (end - begin) * i / (count - 1));
  return out;
}

std::vector<double> values_of(const std::vector<double>& times, const std::function<double(double)>& law) {
  std::vector<double> out;
  for (const double t : times) out.push_back(law(t));
  return out;
}

const std::vector<double> kTimes = steps(0.0, 400.0, 17), kAhead = steps(425.0, 600.0, 8);

TEST(ForecastGrowth, GoesOnByTheLawThatTheSeriesHas) {
  // Onsets and speeds lie on the grid, so that each law is found exactly.
  const std::vector<std::pair<GrowthLaw, std::function<double(double)>>> laws{
      {GrowthLaw::Diffusion, [](double t) { return 2.0 * std::sqrt(t); }},
      {GrowthLaw::Linear, [](double t) { return 0.5 * t; }},
      {GrowthLaw::Accelerating, [](double t) { return 1e-4 * t * t; }}};
  for (const auto& [law, value] : laws) {
    const auto forecast = forecast_growth(kTimes, {values_of(kTimes, value)}, kAhead, true);
    ASSERT_TRUE(forecast);
    EXPECT_EQ(forecast->test.law, law);
    EXPECT_NEAR(forecast->test.share, 1.0, 1e-6);
    for (std::size_t i = 0; i < kAhead.size(); ++i)
      EXPECT_NEAR(forecast->values.front()[i].value, value(kAhead[i]), 1e-6 * value(kAhead[i]));
  }
}

TEST(ForecastGrowth, HoldsWhatNoLawForetells) {
  // Grows, then stays: every law that was fitted to its beginning had promised more.
  const auto stays = [](double t) { return std::min(t, 175.0); };
  const auto forecast = forecast_growth(kTimes, {values_of(kTimes, stays)}, kAhead, true);
  ASSERT_TRUE(forecast);
  for (const GradedFigure& f : forecast->values.front()) {
    EXPECT_NEAR(f.value, 175.0, 1e-9);
    EXPECT_LE(f.low, 175.0);
    EXPECT_GE(f.high, 175.0);
  }
}

TEST(ForecastGrowth, IntervalsHoldLinearGrowthInNoise) {
  // 90 of 100 by construction; of 60 series, 48 or more but for a chance of 1 in 100 [binomial].
  int num_held = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    RandomStream random(seed, 0, 0);
    const auto noisy = [&](double t) { return 0.01 * t + 0.2 * (random.uniform() + random.uniform() - 1.0); };
    const std::vector<double> values = values_of(kTimes, noisy);
    const auto forecast = forecast_growth(kTimes, {values}, kAhead, false);
    ASSERT_TRUE(forecast);
    const GradedFigure& last = forecast->values.front().back();
    num_held += last.low <= 6.0 && 6.0 <= last.high ? 1 : 0;
  }
  EXPECT_GE(num_held, 48);
}

TEST(ForecastGrowth, PlacesOfOneSampleShareALawAndKeepTheirSpeeds) {
  const auto slow = values_of(kTimes, [](double t) { return 0.1 * t; }),
             fast = values_of(kTimes, [](double t) { return 0.4 * t; });
  const auto forecast = forecast_growth(kTimes, {slow, fast}, kAhead, true);
  ASSERT_TRUE(forecast);
  EXPECT_EQ(forecast->test.law, GrowthLaw::Linear);
  EXPECT_NEAR(forecast->values[0].back().value, 60.0, 1e-6);
  EXPECT_NEAR(forecast->values[1].back().value, 240.0, 1e-6);
}

TEST(ForecastGrowth, IsNothingOfAFewTimesOrOfWhatNeverChanges) {
  const std::vector<double> few = steps(0.0, 100.0, 5);
  EXPECT_FALSE(forecast_growth(few, {values_of(few, [](double t) { return t; })}, kAhead, true));
  EXPECT_FALSE(forecast_growth(kTimes, {values_of(kTimes, [](double) { return 3.0; })}, kAhead, true));
}

}  // namespace
}  // namespace patinate::analysis
