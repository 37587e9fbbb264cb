#include "analysis/fit/determined.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "libcommon/core/random.h"
#include "tests/support/errors.h"

namespace patinate::analysis {
namespace {

using Objective = std::function<double(const std::vector<double>&)>;

/// Points around the best as a search would leave them.
std::vector<BoxPoint> cloud(const Objective& f, const std::vector<double>& best, int num_points = 80,
                            double spread = 0.1) {
  std::vector<BoxPoint> points;
  for (int k = 0; k < num_points; ++k) {
    RandomStream random(1, static_cast<std::uint64_t>(k));
    BoxPoint p{.at = best};
    for (double& x : p.at) x = std::min(1.0, std::max(0.0, x + spread * random.normal()));
    p.objective = f(p.at);
    points.push_back(p);
  }
  return points;
}

/// A scan of each parameter, the others moved by `slopes` where given.
BoxScans scan(const Objective& f, const std::vector<double>& best,
              const std::vector<std::vector<double>>& slopes = {}) {
  BoxScans scans(best.size());
  for (std::size_t i = 0; i < best.size(); ++i) {
    for (const double place : scan_places(best[i], 16)) {
      BoxPoint p{.at = best};
      for (std::size_t j = 0; j < best.size(); ++j) {
        if (j != i && !slopes.empty())
          p.at[j] = std::min(1.0, std::max(0.0, best[j] + slopes[i][j] * (place - best[i])));
      }
      p.at[i] = place;
      p.objective = f(p.at);
      scans[i].push_back(p);
    }
  }
  return scans;
}

std::vector<ParameterVerdict> verdict_of(const Objective& f, const std::vector<double>& best, double threshold) {
  return determine({best, f(best)}, {}, scan(f, best), BoxScans(best.size()), threshold);
}

TEST(Determined, IntervalOfAConeReachesAsFarAsItsSlopeSays) {
  // |x - 0.4| rises by 0.05 at 0.35 and 0.45; straight pieces are interpolated exactly.
  const std::vector<ParameterVerdict> v = verdict_of([](const auto& x) { return std::abs(x[0] - 0.4); }, {0.4}, 0.05);
  EXPECT_EQ(v[0].determination, Determination::Determined);
  EXPECT_NEAR(v[0].low, 0.35, 1e-12);
  EXPECT_NEAR(v[0].high, 0.45, 1e-12);
}

TEST(Determined, WhatChangesNothingIsSaidToHaveNoEffect) {
  const std::vector<ParameterVerdict> v =
      verdict_of([](const auto& x) { return std::abs(x[0] - 0.4) + 0.1; }, {0.4, 0.7}, 0.01);
  EXPECT_EQ(v[0].determination, Determination::Determined);
  EXPECT_EQ(v[1].determination, Determination::WithoutEffect);
  EXPECT_EQ(v[1].effect, 0.0);
  EXPECT_EQ(v[1].low, 0.0);
  EXPECT_EQ(v[1].high, 1.0);
}

TEST(Determined, AnEffectBelowTheThresholdIsNotDetermined) {
  const std::vector<ParameterVerdict> v =
      verdict_of([](const auto& x) { return 0.02 * x[0] + std::abs(x[1] - 0.5); }, {0.3, 0.5}, 0.05);
  EXPECT_EQ(v[0].determination, Determination::Undetermined);
  EXPECT_EQ(v[1].determination, Determination::Determined);
}

TEST(Determined, ABestAtTheEdgeIsBoundedOnOneSideOnly) {
  const std::vector<ParameterVerdict> v = verdict_of([](const auto& x) { return 1.0 - x[0]; }, {1.0}, 0.1);
  EXPECT_EQ(v[0].determination, Determination::AtLeast);
  EXPECT_NEAR(v[0].low, 0.9, 1e-12);
  EXPECT_EQ(v[0].high, 1.0);
}

TEST(Determined, ValleyOfAQuadraticIsItsInverseHessian) {
  // x^T H x / 2 with off-diagonal -r: the errors are correlated by r, and y = r x is the valley's floor for a given x.
  for (const double r : {-0.9, 0.6}) {
    const auto f = [r](const auto& x) {
      return 0.5 * (std::pow(x[0] - 0.5, 2) + std::pow(x[1] - 0.5, 2) - 2 * r * (x[0] - 0.5) * (x[1] - 0.5));
    };
    std::string problem;
    const std::optional<Valley> valley = valley_of({{0.5, 0.5}, 0.0}, cloud(f, {0.5, 0.5}), problem);
    ASSERT_TRUE(valley.has_value()) << problem;
    EXPECT_NEAR(valley->correlation[0][1], r, 1e-6);  // An exact quadratic: rounding only.
    EXPECT_NEAR(valley->slopes[0][1], r, 1e-6);
    EXPECT_NEAR(valley->explained, 1.0, 1e-6);
  }
}

TEST(Determined, IntervalsOfCorrelatedParametersGrowWhenTheOthersMoveAlongTheValley) {
  // A cone over an ellipse, so that interpolation between places is exact: held, it rises as |x|; along the valley as
  // sqrt(1 - r^2) |x|.
  const double r = 0.8, threshold = 0.06;
  const auto q = [r](const auto& x) {
    return std::pow(x[0] - 0.5, 2) + std::pow(x[1] - 0.5, 2) - 2 * r * (x[0] - 0.5) * (x[1] - 0.5);
  };
  const Objective f = [q](const auto& x) { return std::sqrt(std::max(0.0, q(x))); };
  const BoxScans scans = scan(f, {0.5, 0.5});
  const std::vector<ParameterVerdict> held = determine({{0.5, 0.5}, 0.0}, {}, scans, BoxScans(2), threshold);
  const std::vector<ParameterVerdict> moved =
      determine({{0.5, 0.5}, 0.0}, {}, scans, scan(f, {0.5, 0.5}, {{1, r}, {r, 1}}), threshold);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(held[i].high, 0.5 + threshold, 1e-9);
    EXPECT_NEAR(moved[i].high, 0.5 + threshold / std::sqrt(1 - r * r), 1e-9);
    EXPECT_NEAR(moved[i].low, 0.5 - threshold / std::sqrt(1 - r * r), 1e-9);
  }
}

TEST(Determined, OfASumOnlyTheSumIsDetermined) {
  // Along x + y = 1 nothing changes at all: each alone may be anything.
  const auto f = [](const auto& x) { return std::pow(x[0] + x[1] - 1.0, 2); };
  const BoxPoint best{{0.5, 0.5}, 0.0};
  std::string problem;
  const std::optional<Valley> valley = valley_of(best, cloud(f, best.at), problem);
  ASSERT_TRUE(valley.has_value()) << problem;
  EXPECT_LT(valley->correlation[0][1], -0.999);
  for (const ParameterVerdict& p : determine(best, {}, scan(f, best.at), scan(f, best.at, valley->slopes), 1e-3))
    EXPECT_EQ(p.determination, Determination::Undetermined);
}

TEST(Determined, WhateverWasTriedAndIsAsGoodBelongsToTheInterval) {
  const auto f = [](const auto& x) { return std::abs(x[0] - 0.5) + std::abs(x[1] - 0.5); };
  const std::vector<BoxPoint> tried{{{0.2, 0.9}, 0.05}, {{0.1, 0.1}, 0.2}};
  const std::vector<ParameterVerdict> v = determine({{0.5, 0.5}, 0.0}, tried, scan(f, {0.5, 0.5}), BoxScans(2), 0.1);
  EXPECT_NEAR(v[0].low, 0.2, 1e-12);
  EXPECT_NEAR(v[0].high, 0.6, 1e-12);
  EXPECT_NEAR(v[1].high, 0.9, 1e-12);
}

TEST(Determined, SaysWhenPointsAreTooFewOrNoQuadratic) {
  std::string problem;
  const auto cone = [](const auto& x) { return std::abs(x[0] - 0.4) + std::abs(x[1] - 0.4); };
  EXPECT_FALSE(valley_of({{0.4, 0.4}, 0.0}, cloud(cone, {0.4, 0.4}, 5), problem).has_value());
  EXPECT_TRUE(testing_support::has(problem, "only 5 points"));
  const auto rough = [](const std::vector<double>& x) {
    return 1.0 + RandomStream(3, static_cast<std::uint64_t>(1e12 * (x[0] + 2 * x[1]))).uniform();
  };
  EXPECT_FALSE(valley_of({{0.4, 0.4}, 0.0}, cloud(rough, {0.4, 0.4}, 400), problem).has_value());
  EXPECT_TRUE(testing_support::has(problem, "no quadratic"));
}

TEST(Determined, WithoutAScanNothingIsSaid) {
  const std::vector<ParameterVerdict> v = determine({{0.4}, 0.0}, {}, BoxScans(1), BoxScans(1), 0.1);
  EXPECT_EQ(v[0].determination, Determination::NotExamined);
}

TEST(Determined, UndefinedPlacesBoundAnInterval) {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<ParameterVerdict> v =
      verdict_of([&](const auto& x) { return x[0] > 0.8 ? infinity : 0.01 * x[0]; }, {0.4}, 0.1);
  EXPECT_EQ(v[0].determination, Determination::AtMost);
  EXPECT_LE(v[0].high, 0.8);
  EXPECT_LE(v[0].effect, 0.01);  // Share of defined places.
}

TEST(Determined, ScansReachBothEndsAndComeNearTheBest) {
  const std::vector<double> places = scan_places(0.5, 8);
  EXPECT_EQ(places.size(), 8u);
  EXPECT_EQ(*std::min_element(places.begin(), places.end()), 0.0);
  EXPECT_EQ(*std::max_element(places.begin(), places.end()), 1.0);
  EXPECT_EQ(scan_places(0.0, 8).size(), 4u);
  EXPECT_EQ(scan_places(1.0, 8).size(), 4u);
  EXPECT_TRUE(scan_places(0.5, 0).empty());
  EXPECT_EQ(scan_places(0.2, 7).size(), 7u);
}

// An odd number has no half: the last place lies where there is more to see. None at all was the end of `fit --scan 1`.
TEST(Determined, AScanOfOnePlaceLooksToTheWiderSide) {
  EXPECT_EQ(scan_places(0.3, 1), std::vector<double>{1.0});
  EXPECT_EQ(scan_places(0.7, 1), std::vector<double>{0.0});
  EXPECT_EQ(scan_places(0.0, 1), std::vector<double>{1.0});
  EXPECT_EQ(scan_places(1.0, 1), std::vector<double>{0.0});
  EXPECT_EQ(scan_places(0.5, 3), (std::vector<double>{0.0, 1.0, 0.35}));
}

}  // namespace
}  // namespace patinate::analysis
