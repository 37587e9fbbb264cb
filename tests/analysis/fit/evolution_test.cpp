#include "analysis/fit/evolution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "analysis/fit/multi_start.h"
#include "libcommon/core/random.h"
#include "tests/analysis/fit/box_point.h"
#include "tests/support/errors.h"

namespace patinate::analysis {
namespace {

using testing_support::BoxPoint;
using testing_support::error_of;
using testing_support::has;

double distance(const BoxPoint& a, const BoxPoint& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

double sphere(const BoxPoint& x, const BoxPoint& optimum) { return distance(x, optimum) * distance(x, optimum); }

/// From the start alone.
Minimum minimize_from_start(const std::function<double(const BoxPoint&)>& f, const BoxPoint& start, int budget,
                            const EvolutionOptions& options) {
  return analysis::minimize(f, start, budget, {.search = options, .starts = 1});
}

constexpr double kFound = 5e-3;  ///< Share of the range: five times the step at which the search ends.

TEST(Evolution, FindsTheMiddleOfASphereInOneToTenDimensionsWithinTheBudgetOfAFit) {
  // Published runs of CMA-ES on the sphere come nearer by a factor of ten in about 33 n evaluations (four decades in
  // 650 for n = 5).
  struct Case {
    int evaluations_per_dimension;
    double within;
  };
  for (const Case c : {Case{60, 0.03}, Case{150, kFound}}) {  // Two thirds of the default budget of a fit; to the end.
    for (const std::size_t n : {std::size_t{1}, std::size_t{2}, std::size_t{5}, std::size_t{10}}) {
      BoxPoint optimum;
      for (std::size_t i = 0; i < n; ++i) optimum.push_back(0.2 + 0.05 * static_cast<double>(i));
      const int budget = 1 + c.evaluations_per_dimension * static_cast<int>(n);
      for (const std::uint64_t seed : {1u, 2u, 3u}) {
        const Minimum m = minimize_from_start([&](const BoxPoint& x) { return sphere(x, optimum); }, BoxPoint(n, 0.7),
                                              budget, {.seed = seed});
        EXPECT_LT(distance(m.at, optimum), c.within) << n << " dimensions, seed " << seed;
        EXPECT_LE(m.num_evaluations, budget);
      }
    }
  }
}

TEST(Evolution, FollowsTheCurvedValleyOfRosenbrock) {
  // The usual function on [-2, 2]^2, optimum at (1, 1) = (0.75, 0.75) of the box.
  const auto f = [](const BoxPoint& u) {
    const double x = 4 * u[0] - 2, y = 4 * u[1] - 2;
    return 100 * std::pow(y - x * x, 2) + std::pow(1 - x, 2);
  };
  const Minimum m = minimize_from_start(f, {0.2, 0.7}, 1200, {.tolerance = 1e-5, .seed = 4});
  EXPECT_TRUE(m.is_converged);
  EXPECT_LT(distance(m.at, {0.75, 0.75}), kFound);
}

TEST(Evolution, LearnsTheShapeOfAnEllipsoidThatIsAThousandTimesLongerThanWideAndTurned) {
  const BoxPoint optimum{0.6, 0.4, 0.5};
  const auto f = [&](const BoxPoint& x) {
    const double u = (x[0] - optimum[0] + x[1] - optimum[1]) / std::sqrt(2.0),
                 v = (x[0] - optimum[0] - x[1] + optimum[1]) / std::sqrt(2.0), w = x[2] - optimum[2];
    return 1e6 * u * u + v * v + 1e3 * w * w;
  };
  const Minimum m = minimize_from_start(f, {0.2, 0.2, 0.9}, 1500, {.tolerance = 1e-6, .seed = 5});
  EXPECT_LT(distance(m.at, optimum), kFound);
}

TEST(Evolution, FindsAnOptimumOnAnEdgeAndInACornerExactlyAsNearAsOneInside) {
  const auto plane = [](const BoxPoint& x) { return x[0] + 2 * x[1]; };
  const Minimum corner = minimize_from_start(plane, {0.6, 0.6}, 300, {.seed = 6});
  EXPECT_LT(distance(corner.at, {0.0, 0.0}), kFound);
  const auto slanted = [](const BoxPoint& x) { return std::pow(x[0] - 0.3, 2) - x[1]; };
  const Minimum edge = minimize_from_start(slanted, {0.6, 0.3}, 300, {.seed = 7});
  EXPECT_LT(distance(edge.at, {0.3, 1.0}), kFound);
}

TEST(Evolution, CandidatesLieInTheBoxHoweverWideTheStep) {
  Evolution evolution({0.0, 1.0, 0.5}, {.step = 1.0, .seed = 8});
  for (int g = 0; g < 5; ++g) {
    std::vector<double> values;
    for (int k = 0; k < evolution.population(); ++k) {
      const BoxPoint x = evolution.candidate(k);
      for (double v : x) EXPECT_TRUE(v >= 0.0 && v <= 1.0);
      values.push_back(x[0]);
    }
    evolution.tell(values);
  }
}

TEST(Evolution, NoiseOfATenthOfTheRiseMovesTheOptimumLittle) {
  const BoxPoint optimum{0.35, 0.6};
  double worst = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::uint64_t call = 0;
    const auto f = [&](const BoxPoint& x) {
      return std::sqrt(sphere(x, optimum)) + 0.01 * RandomStream(seed, call++, 99).normal();
    };
    const Minimum m = minimize_from_start(f, {0.8, 0.2}, 240, {.seed = seed});
    worst = std::max(worst, distance(m.at, optimum));
  }
  // The cone rises by 4 sigma of the noise within 0.04.
  EXPECT_LT(worst, 0.04);
}

TEST(Evolution, OnlyRanksMatter) {
  const BoxPoint optimum{0.3, 0.8};
  const Minimum plain =
      minimize_from_start([&](const BoxPoint& x) { return sphere(x, optimum); }, {0.5, 0.5}, 100, {.seed = 9});
  const Minimum bent = minimize_from_start([&](const BoxPoint& x) { return std::exp(30 * sphere(x, optimum)) - 7; },
                                           {0.5, 0.5}, 100, {.seed = 9});
  EXPECT_EQ(plain.at, bent.at);
}

TEST(Evolution, UndefinedValuesAreWorseThanAllOthers) {
  // Half of the box is undefined, and the optimum lies on its border.
  const auto f = [](const BoxPoint& x) { return x[0] < 0.5 ? std::numeric_limits<double>::infinity() : x[0] + x[1]; };
  const Minimum m = minimize_from_start(f, {0.9, 0.9}, 300, {.seed = 10});
  EXPECT_LT(distance(m.at, {0.5, 0.0}), 2 * kFound);
}

TEST(Evolution, EndsWhereNothingIsGainedAnyMoreThoughTheValuesDiffer) {
  // A rough plain: values differ by chance, of every size of step; no gain of a hundredth is left after a few.
  std::uint64_t call = 0;
  const auto f = [&](const BoxPoint&) { return 10.0 + RandomStream(1, call++, 98).uniform(); };
  const Minimum m = minimize_from_start(f, {0.5, 0.5}, 100000, {.relative_flatness = 0.01, .seed = 14});
  EXPECT_TRUE(m.is_converged);
  // 6 a generation; least values of 10.1, 10.05 ... can be gains at most ten times, 12 generations after the last.
  EXPECT_LT(m.num_evaluations, 1 + 6 * 12 * 11);
}

TEST(Evolution, EndsWhereNothingChanges) {
  const Minimum m = minimize_from_start([](const BoxPoint&) { return 3.0; }, {0.5, 0.5, 0.5}, 1000, {.seed = 12});
  EXPECT_TRUE(m.is_converged);
  EXPECT_LT(m.num_evaluations, 40);
}

TEST(Evolution, TheSameValuesLeadToTheSameSearchInWhateverOrderTheyAreComputed) {
  Evolution forward({0.4, 0.6}, {.seed = 13}), backward({0.4, 0.6}, {.seed = 13});
  for (int g = 0; g < 8; ++g) {
    std::vector<double> a(static_cast<std::size_t>(forward.population())), b(a.size());
    for (int k = 0; k < forward.population(); ++k) a[k] = sphere(forward.candidate(k), {0.2, 0.9});
    for (int k = backward.population() - 1; k >= 0; --k) b[k] = sphere(backward.candidate(k), {0.2, 0.9});
    ASSERT_EQ(a, b);
    forward.tell(a);
    backward.tell(b);
  }
}

TEST(Evolution, SaysWhatIsWrong) {
  EXPECT_TRUE(has(error_of([] { (void)Evolution({}); }), "[1, 100]"));
  EXPECT_TRUE(has(error_of([] { (void)Evolution({1.5}); }), "[0, 1]"));
  EXPECT_TRUE(has(error_of([] { (void)Evolution({0.5}, {.population = 2}); }), "[4, 1000]"));
  EXPECT_TRUE(has(error_of([] { (void)Evolution({0.5}, {.step = 0.0}); }), "(0, 1]"));
  Evolution evolution({0.5});
  EXPECT_TRUE(has(error_of([&] { evolution.tell(std::vector<double>{1.0}); }), "candidates"));
  EXPECT_TRUE(has(error_of([&] {
                    evolution.tell(std::vector<double>(static_cast<std::size_t>(evolution.population()), std::nan("")));
                  }),
                  "NaN"));
}

}  // namespace
}  // namespace patinate::analysis
