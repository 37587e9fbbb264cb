#include "analysis/figures/pixel_difference.h"

#include <gtest/gtest.h>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/analysis/compare/stacks.h"

namespace patinate::analysis {
namespace {

/// A gray surface, and the same photographed again: linear noise of a deviation that may be stated wrongly.
struct Photographed {
  ColorStack a, b;
};
Photographed photographed_twice(double deviation, double stated, double shift) {
  const auto gray = [](int, int, double) { return std::array<double, 3>{0.4, 0.4, 0.4}; };
  Photographed both{testing_support::make_stack(64, 64, 3, 1.0, gray),
                    testing_support::make_stack(64, 64, 3, 1.0, gray)};
  RandomStream random(3, 0);
  for (ColorStack* stack : {&both.a, &both.b}) {
    for (float& v : stack->rgb) v += static_cast<float>(deviation * random.normal());
    stack->deviation.assign(stack->rgb.size(), static_cast<float>(stated));
  }
  for (float& v : both.b.rgb) v += static_cast<float>(shift);
  return both;
}

TEST(StatedNoise, OneInAHundredOfEqualPlacesLiesBeyondIt) {
  const Photographed both = photographed_twice(0.01, 0.01, 0.0);
  const auto noise = stated_noise(both.a, both.b, 1);
  ASSERT_TRUE(noise);
  // 12,288 draws of one in a hundred: a standard error of 0.0009, three of them.
  EXPECT_NEAR(noise->beyond_share, 0.01, 0.0027);
}

TEST(StatedNoise, WhatDiffersByTenDeviationsIsBeyondEverywhere) {
  const Photographed both = photographed_twice(0.002, 0.002, 0.02);
  EXPECT_GT(stated_noise(both.a, both.b, 1)->beyond_share, 0.99);
}

TEST(StatedNoise, ItsColorDifferenceGrowsWithTheDeviation) {
  const Photographed little = photographed_twice(0.0, 0.001, 0.0), much = photographed_twice(0.0, 0.004, 0.0);
  // CIEDE2000 is a length near equal colors.
  EXPECT_NEAR(stated_noise(much.a, much.b, 1)->ciede2000 / stated_noise(little.a, little.b, 1)->ciede2000, 4.0, 0.4);
}

TEST(StatedNoise, IsNothingWhereNoneIsStatedAndOneSideIsEnough) {
  Photographed both = photographed_twice(0.01, 0.01, 0.0);
  both.a.deviation.clear();
  EXPECT_TRUE(stated_noise(both.a, both.b, 1));
  both.b.deviation.clear();
  EXPECT_FALSE(stated_noise(both.a, both.b, 1));
  both.b.texels.pop_back();
  EXPECT_THROW((void)stated_noise(both.a, both.b, 1), InvalidInput);
}

}  // namespace
}  // namespace patinate::analysis
