#include "simulation/job/outcome.h"

#include <gtest/gtest.h>

#include "patinate/core/error.h"
#include "simulation/job/estimate.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

constexpr int kRust = 2;

/// The plate with rust on its left half, `amount` thick.
std::vector<ObjectOutcome> with_rust(float amount) {
  Simulation simulation(testing_support::plate_scene(64));
  const ImageF before = simulation.compose().color_linear();
  ImageF rust(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 32; ++x) rust.at(x, y) = amount;
  }
  simulation.set_amounts(kRust, rust);
  return outcome_of(simulation, before);
}

TEST(Outcome, MeansAndSharesAreOfTheSurface) {
  const std::vector<ObjectOutcome> outcome = with_rust(0.5f);
  ASSERT_EQ(outcome.size(), 1u);
  const MaterialOutcome& rust = outcome[0].materials.at(kRust);
  EXPECT_EQ(rust.material, "rust");
  // The chart ends a few texels from the picture's edges: half of it to a column of 64.
  EXPECT_NEAR(rust.mean, 0.25, 0.25 / 32.0);
  EXPECT_NEAR(rust.shows_share, 0.5, 1.0 / 32.0);
  EXPECT_DOUBLE_EQ(rust.largest, 0.5);
  EXPECT_EQ(rust.full_share, 0.0);
  EXPECT_GT(outcome[0].change_p95, kVisibleDeltaE);
  EXPECT_NEAR(outcome[0].change_mean, outcome[0].change_p95 / 2.0, outcome[0].change_p95 / 10.0);
  EXPECT_NEAR(outcome[0].never_met_share.value(), 1.0, 1e-9);  // It did not run.
}

TEST(Outcome, AThickLayerHidesAllAndAFullOneIsFull) {
  const MaterialOutcome thick = with_rust(65535.0f / 16384.0f)[0].materials.at(kRust);
  EXPECT_NEAR(thick.hides_share, 0.5, 1.0 / 32.0);
  EXPECT_NEAR(thick.full_share, 0.5, 1.0 / 32.0);
}

/// After 30 iterations of rain at a rate of rusting.
std::vector<ObjectOutcome> rained_on(double rate) {
  Scene scene = testing_support::plate_scene(64);
  scene.rules.push_back(testing_support::rust_rule(rate));
  scene.appearance[0].strength = 0.0;  // Water is not seen.
  Simulation simulation(scene);
  const ImageF before = simulation.compose().color_linear();
  for (int i = 0; i < 30; ++i) simulation.step();
  return outcome_of(simulation, before);
}

constexpr double kRate = 0.15;

TEST(Outcome, SaysHowManyTimesTooSmallRatesAreAndThatHelps) {
  const std::vector<std::string> advice = outcome_advice(rained_on(kRate));
  ASSERT_EQ(advice.size(), 1u);
  const std::string phrase = "rates or loads are about ";
  const std::size_t at = advice[0].find(phrase);
  ASSERT_NE(at, std::string::npos) << advice[0];
  const double times = std::stod(advice[0].substr(at + phrase.size()));
  EXPECT_GT(times, 1.0);
  const double change = rained_on(kRate * times)[0].change_p95;
  // Color is not linear in the amount, and the factor has one digit.
  EXPECT_GT(change, kVisibleDeltaE / 2.0);
  EXPECT_LT(change, kVisibleDeltaE * 2.0);
}

// A film of water that is seen must not stand for rust that is not.
TEST(Outcome, WhatRulesMakeTellsHowFarTheyAreOff) {
  Scene scene = testing_support::plate_scene(64);
  scene.rules.push_back(testing_support::rust_rule(kRate / 100.0));
  scene.appearance[0].strength = 0.02;
  Simulation simulation(scene);
  const ImageF before = simulation.compose().color_linear();
  for (int i = 0; i < 30; ++i) simulation.step();
  const std::vector<std::string> advice = outcome_advice(outcome_of(simulation, before));
  ASSERT_EQ(advice.size(), 1u);
  const std::string phrase = "rates or loads are about ";
  const std::size_t at = advice[0].find(phrase);
  ASSERT_NE(at, std::string::npos) << advice[0];
  EXPECT_GE(std::stod(advice[0].substr(at + phrase.size())), 50.0) << advice[0];
  EXPECT_NE(advice[0].find("rust covers most"), std::string::npos) << advice[0];
}

TEST(Outcome, SaysThatRulesHaveMadeNothing) {
  const std::vector<std::string> advice = outcome_advice(rained_on(0.0));
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_NE(advice[0].find("rules have made nothing"), std::string::npos) << advice[0];
}

TEST(Estimate, ACoarseRunForetellsTheWholeOne) {
  SceneFile file;
  file.scene = testing_support::plate_scene(512);
  file.scene.emitters[0].gammatons = 4000;
  file.scene.rules.push_back(testing_support::rust_rule(2.0));
  file.iterations = 60;
  Simulation whole(file.scene);
  const ImageF before = whole.compose().color_linear();
  while (whole.iteration() < file.iterations) whole.step();
  const std::vector<ObjectOutcome> truth = outcome_of(whole, before);
  const RunEstimate estimate = estimate_run(file, {});
  EXPECT_EQ(estimate.resolution, 192);
  EXPECT_EQ(estimate.all_gammatons, 4000);
  EXPECT_EQ(estimate.gammatons, 563);  // As many gammatons a texel.
  for (std::size_t m : {0u, 2u}) {
    // Some 560 x 60 contacts: their count is known to a hundredth, their place on the plate is not; 5 % holds both.
    EXPECT_NEAR(estimate.outcome[0].materials[m].mean, truth[0].materials[m].mean, 0.05 * truth[0].materials[m].mean);
  }
}

TEST(Outcome, NamesWhatNoGammatonMet) {
  const std::vector<ObjectOutcome> outcome = rained_on(1.0);
  ASSERT_TRUE(outcome[0].never_met_share);
  EXPECT_GT(*outcome[0].never_met_share, 0.0);
  EXPECT_LT(*outcome[0].never_met_share, 1.0);
}

TEST(Outcome, RefusesAnotherSize) {
  Simulation simulation(testing_support::plate_scene(64));
  EXPECT_THROW((void)outcome_of(simulation, ImageF(32, 32, 3)), InvalidInput);
}

}  // namespace
}  // namespace patinate::simulation
