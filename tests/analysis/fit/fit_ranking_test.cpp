#include "analysis/fit/fit_ranking.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate::analysis {
namespace {

RankedFit fit(const std::string& name, const std::string& model, std::vector<double> seeds, double until = 240.0) {
  RankedFit ranked{.name = name, .fit = {}};
  ranked.fit.history = "copper";
  ranked.fit.history_key = "c0ffee";
  ranked.fit.model = model;
  ranked.fit.terms = {{"color_distribution", 1.0}};
  ranked.fit.origin.options = {{"clock", "absolute"}};
  ranked.fit.is_converged = true;
  ranked.fit.held_out = HeldOut{.until = until,
                                .num_times = 5,
                                .after = seeds.front(),
                                .other_seeds = {seeds.begin(), seeds.end()},
                                .last_frame = 5.0};
  return ranked;
}

std::string problem_of(const std::vector<RankedFit>& fits) {
  try {
    (void)rank_fits(fits);
  } catch (const InvalidInput& e) {
    return e.what();
  }
  return "";
}

TEST(FitRanking, TheNearestIsFirstWithTextbookIntervals) {
  const std::vector<RankedFit> fits{fit("far", "one_layer", {10, 11, 12, 13}), fit("near", "two_layers", {4, 5, 6, 5})};
  const Ranking ranking = rank_fits(fits);
  ASSERT_EQ(ranking.models.size(), 2u);
  EXPECT_EQ(ranking.models[0].name, "two_layers");
  EXPECT_EQ(ranking.unit, "Delta E 1976");
  // 4, 5, 6, 5: mean 5, standard error sqrt(2 / 3) / 2; t(0.975, 3) = 3.182446.
  EXPECT_NEAR(ranking.models[0].held_out.value, 5.0, 1e-12);
  EXPECT_NEAR(*ranking.models[0].held_out.high, 5.0 + 3.182446 * 0.408248, 1e-5);
  // Against 10, 11, 12, 13 (variance 5 / 3): Welch's t has (1/6 + 5/12)^2 / ((1/6)^2/3 + (5/12)^2/3) = 5.0690 degrees,
  // of whose distribution 0.975 lies below 2.56010.
  ASSERT_TRUE(ranking.models[1].behind);
  EXPECT_NEAR(ranking.models[1].behind->value, 6.5, 1e-12);
  EXPECT_NEAR(*ranking.models[1].behind->low, 6.5 - 2.56010 * 0.763763, 1e-4);
  EXPECT_FALSE(ranking.models[0].behind);
}

TEST(FitRanking, IntervalsHoldTheDifferenceAsOftenAsTheySay) {
  constexpr int kTrials = 2000;
  int num_held = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    RandomStream random(5, static_cast<std::uint64_t>(trial));
    std::vector<double> a, b;
    for (int i = 0; i < 8; ++i) a.push_back(10.0 + random.normal());
    for (int i = 0; i < 8; ++i) b.push_back(14.0 + 3.0 * random.normal());
    const Ranking ranking = rank_fits(std::vector{fit("a", "a", a), fit("b", "b", b)});
    const RankedModel& second = ranking.models[1];
    const double truth = second.name == "b" ? 4.0 : -4.0;
    num_held += *second.behind->low <= truth && truth <= *second.behind->high;
  }
  // 0.95 of them, and four binomial deviations of 0.0049; Welch's degrees of freedom are within a hundredth.
  EXPECT_NEAR(num_held / static_cast<double>(kTrials), 0.95, 0.03);
}

TEST(FitRanking, FoldsOverTimeAreMeansOverCases) {
  const std::vector<RankedFit> fits{fit("a1", "a", {4, 6}), fit("b1", "b", {9, 11}), fit("a2", "a", {14, 16}, 300.0),
                                    fit("b2", "b", {9, 11}, 300.0)};
  const Ranking ranking = rank_fits(fits);
  ASSERT_EQ(ranking.cases.size(), 2u);
  EXPECT_NEAR(ranking.models[0].held_out.value, 10.0, 1e-12);
  EXPECT_NEAR(ranking.models[1].held_out.value, 10.0, 1e-12);
  EXPECT_NEAR(*ranking.last_frame, 5.0, 1e-12);
}

TEST(FitRanking, SaysWhatBeatsWhat) {
  const std::vector<RankedFit> fits{fit("a", "a", {10, 10.1, 9.9, 10}), fit("b", "b", {10.1, 9.9, 10.05, 10}),
                                    fit("c", "c", {20, 20.1, 19.9, 20})};
  const std::vector<std::string> verdict = ranking_verdict(rank_fits(fits), fits);
  const auto says = [&](const std::string& part) {
    return std::any_of(verdict.begin(), verdict.end(),
                       [&](const std::string& s) { return s.find(part) != std::string::npos; });
  };
  EXPECT_TRUE(says("of the models a is the nearest: 10 Delta E 1976"));
  EXPECT_TRUE(says("cannot be distinguished"));
  EXPECT_TRUE(says("c is farther by 10"));
  EXPECT_TRUE(says("no model is as near as holding the last frame seen (5")) << "the last frame is at 5";
}

TEST(FitRanking, ModelsWithoutChanceHavePointsForIntervals) {
  const Ranking ranking = rank_fits(std::vector{fit("a", "a", {3, 3}), fit("b", "b", {4, 4})});
  EXPECT_EQ(*ranking.models[1].behind->low, 1.0);
  EXPECT_EQ(*ranking.models[1].behind->high, 1.0);
}

TEST(FitRanking, OneSeedGivesNoInterval) {
  const Ranking ranking = rank_fits(std::vector{fit("a", "a", {3}), fit("b", "b", {4, 5})});
  EXPECT_FALSE(ranking.models[0].held_out.has_interval());
  EXPECT_TRUE(ranking.models[1].held_out.has_interval());
  EXPECT_FALSE(ranking.models[1].behind->has_interval());
}

TEST(FitRanking, NamesWhatCannotBeRanked) {
  const RankedFit a = fit("a", "a", {3, 4});
  EXPECT_NE(problem_of({a}).find("two fits"), std::string::npos);
  RankedFit other = fit("b", "b", {3, 4});
  other.fit.held_out.reset();
  EXPECT_NE(problem_of({a, other}).find("b: its search saw all frames"), std::string::npos);
  other = fit("b", "b", {3, 4});
  other.fit.terms = {{"covered", 1.0}};
  EXPECT_NE(problem_of({a, other}).find("b: has another objective than a"), std::string::npos);
  other = fit("b", "b", {3, 4});
  other.fit.origin.options = {{"clock", "span"}};
  EXPECT_NE(problem_of({a, other}).find("--clock span, a with --clock absolute"), std::string::npos);
  EXPECT_NE(problem_of({a, fit("b", "b", {3, 4}, 300.0)}).find("has no fit to copper until"), std::string::npos);
  EXPECT_NE(problem_of({a, fit("b", "a", {3, 4})}).find("b and a are both of a"), std::string::npos);
  other = fit("b", "b", {3, 4});
  other.fit.held_out->num_times = 4;
  EXPECT_NE(problem_of({a, other}).find("b: is judged at 4 times, a at 5"), std::string::npos);
  other = fit("b", "b", {3, 4});
  other.fit.held_out->after.reset();
  EXPECT_NE(problem_of({a, other}).find("b: has no objective"), std::string::npos);
}

}  // namespace
}  // namespace patinate::analysis
