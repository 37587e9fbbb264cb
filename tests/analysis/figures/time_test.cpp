// Aging, clocks and delays of surfaces made of formulas.
#include <gtest/gtest.h>

#include <cmath>

#include "analysis/figures/aging.h"
#include "analysis/figures/pixel_difference.h"
#include "analysis/figures/time_warp.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/analysis/compare/stacks.h"

namespace patinate::analysis {
namespace {

using testing_support::make_stack;

/// A smooth step from 0 to 1 around `middle`.
double step(double time, double middle, double width) { return 1.0 / (1.0 + std::exp(-(time - middle) / width)); }

std::array<double, 3> aged(int x, int y, double progress) {
  const double u = 0.1 * x, v = 0.1 * y;
  return {70.0 - 30.0 * progress + 2.0 * std::sin(u), -25.0 * progress + v, 10.0 + 15.0 * progress};
}

TEST(Aging, MonotoneFitIsTheNearestNonDecreasingSequence) {
  EXPECT_EQ(monotone_fit(std::vector<double>{1, 3, 2, 4}), (std::vector<double>{1, 2.5, 2.5, 4}));
  EXPECT_EQ(monotone_fit(std::vector<double>{3, 2, 1}), (std::vector<double>{2, 2, 2}));
  // Against every non-decreasing sequence of a grid: none is nearer.
  const std::vector<double> values{2, 0, 3, 1};
  const std::vector<double> fit = monotone_fit(values);
  const auto cost = [&](const std::vector<double>& f) {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += (f[i] - values[i]) * (f[i] - values[i]);
    return sum;
  };
  for (int a = 0; a <= 12; ++a) {
    for (int b = a; b <= 12; ++b) {
      for (int c = b; c <= 12; ++c) {
        for (int d = c; d <= 12; ++d) EXPECT_LE(cost(fit), cost({a / 4.0, b / 4.0, c / 4.0, d / 4.0}) + 1e-12);
      }
    }
  }
}

TEST(Aging, OnsetAndSaturationOfARampAreATenthAndNineTenthsOfIt) {
  // Texel x ages linearly from x to x + 4, 40 Delta E in L*.
  const ColorStack stack = make_stack(4, 1, 21, 10.0, [](int x, int, double t) {
    return std::array<double, 3>{80.0 - 10.0 * std::clamp(t - x, 0.0, 4.0), 0, 0};
  });
  const TexelAging aging = texel_aging(stack, 5.0);
  for (std::size_t x = 0; x < 4; ++x) {
    EXPECT_NEAR(static_cast<double>(aging.change[x]), 40.0, 1e-4);
    EXPECT_NEAR(static_cast<double>(aging.onset[x]), static_cast<double>(x) + 0.4, 1e-5);
    EXPECT_NEAR(static_cast<double>(aging.saturation[x]), static_cast<double>(x) + 3.6, 1e-5);
    EXPECT_EQ(aging.covered_at[x], 2 * x + 1);  // The first of the times, 0.5 apart, at which 5 Delta E are passed.
  }
}

TEST(Aging, WhatDoesNotChangeHasNoOnset) {
  const ColorStack stack = make_stack(2, 1, 5, 1.0, [](int x, int, double t) {
    return std::array<double, 3>{50.0 + (x == 1 ? 3.0 * t : 0.0), 0, 0};
  });
  const TexelAging aging = texel_aging(stack, 5.0);
  EXPECT_EQ(aging.ages[0], 0);
  EXPECT_EQ(aging.ages[1], 0);
  EXPECT_EQ(aging.covered_at[0], 5);
  EXPECT_THROW((void)texel_aging(make_stack(1, 1, 1, 0.0,
                                            [](int, int, double) {
                                              return std::array<double, 3>{1, 2, 3};
                                            }),
                                 5.0),
               InvalidInput);
}

TEST(TimeWarp, OfASurfaceAgainstItselfIsNoneAndLeavesNothing) {
  const ColorStack a =
      make_stack(12, 9, 15, 8.0, [](int x, int y, double t) { return aged(x, y, step(t, 3.0 + 0.1 * x, 0.8)); });
  const TimeWarp warp = find_time_warp(a, a);
  for (std::size_t i = 0; i < warp.times.size(); ++i) {
    EXPECT_EQ(warp.warped[i], warp.times[i]);
    EXPECT_EQ(warp.after[i], 0.0);
  }
}

TEST(TimeWarp, IsFoundAgainWhereTheSurfaceChanges) {
  // B shows at t what A shows at w(t) = t^2 / 8: A at time s is B at sqrt(8 s).
  const auto color = [](int x, int y, double t) {
    return aged(x, y, 0.5 * step(t, 2.0 + 0.1 * x, 0.9) + 0.5 * step(t, 5.5, 0.9));
  };
  const ColorStack a = make_stack(12, 9, 33, 8.0, color);
  const ColorStack b = make_stack(12, 9, 33, 8.0, [&](int x, int y, double t) { return color(x, y, t * t / 8.0); });
  const TimeWarp warp = find_time_warp(a, b);
  const double kStep = 8.0 / 32.0 / 8.0;  // The fineness of the candidates.
  double before = 0, after = 0;
  for (std::size_t i = 0; i < warp.times.size(); ++i) {
    before += warp.before[i], after += warp.after[i];
    if (warp.times[i] > 0.5) {
      EXPECT_NEAR(warp.warped[i], std::sqrt(8.0 * warp.times[i]), kStep + 0.02)
          << warp.times[i];  // + what blending between B's frames bends.
    }
    if (i > 0) {
      EXPECT_GE(warp.warped[i], warp.warped[i - 1]);
    }
  }
  EXPECT_LT(after, 0.02 * before);
}

TEST(TimeWarp, IntervalsHoldTheMeanDelayOfSurfacesWhosePatchesDiffer) {
  // Six times six patches age steadily, each later in B by its own delay: the best clock is late by their mean.
  constexpr int kPatches = 6, kTrials = 60;
  constexpr double kDelay = 0.4, kSpread = 0.6, kTime = 4.0;
  int num_held = 0;
  double width = 0.0;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    const auto delay = [&](int x, int y) {
      RandomStream random(trial, static_cast<std::uint64_t>(y / 2 * kPatches + x / 2));
      return kDelay + kSpread * random.normal();
    };
    const auto color = [](double t) { return std::array<double, 3>{80.0 - 4.0 * t, 0.0, 2.0 * t}; };
    const ColorStack a = make_stack(2 * kPatches, 2 * kPatches, 33, 8.0, [&](int, int, double t) { return color(t); });
    const ColorStack b =
        make_stack(2 * kPatches, 2 * kPatches, 33, 8.0, [&](int x, int y, double t) { return color(t - delay(x, y)); });
    const BlockGrid grid = make_blocks(a, kPatches);
    const BlockWarps warps(a, b, grid);
    const auto at_time = [&](const std::vector<int>& weights, const std::vector<int>&) {
      return std::vector{warps.warp(weights).warped[16]};
    };
    const auto interval = block_ranges(grid, grid, at_time(grid.all(), {}), at_time,
                                       {.resamples = 200, .seed = trial, .is_paired = true});
    ASSERT_TRUE(interval.has_value());
    num_held += interval->front().low <= kTime + kDelay && interval->front().high >= kTime + kDelay ? 1 : 0;
    width += (interval->front().high - interval->front().low) / kTrials;
  }
  // Fewer than 51 of 60 that hold it with 0.95 happen once in a thousand times.
  EXPECT_GE(num_held, 51);
  // Nor wider than the mean's own spread asks for, and a step of candidates on either side.
  EXPECT_LT(width, 1.25 * 2.0 * 1.96 * kSpread / kPatches + 2.0 * 8.0 / 32.0 / 8.0);
}

TEST(TimeWarp, OfBlocksTogetherIsThatOfTheWhole) {
  const auto color = [](int x, int y, double t) { return aged(x, y, step(t, 3.0 + 0.1 * x + 0.05 * y, 0.8)); };
  const ColorStack a = make_stack(12, 9, 15, 8.0, color);
  const ColorStack b = make_stack(12, 9, 15, 8.0, [&](int x, int y, double t) { return color(x, y, t * t / 8.0); });
  const BlockGrid grid = make_blocks(a, 3);
  const TimeWarp whole = find_time_warp(a, b), blocks = BlockWarps(a, b, grid).warp(grid.all());
  EXPECT_EQ(whole.warped, blocks.warped);
  for (std::size_t i = 0; i < whole.times.size(); ++i) EXPECT_NEAR(whole.after[i], blocks.after[i], 1e-6);
}

TEST(TimeWarp, ShiftOfEveryTexelIsFoundAgainWithNoiseToo) {
  // B is later by -0.6 ... +0.6 over the width; noise of 1 in every channel.
  const auto later = [](int x) { return -0.6 + 1.2 * x / 23.0; };
  for (const double noise : {0.0, 1.0}) {
    const auto noisy = [&](std::uint64_t seed, int x, int y, double t, std::array<double, 3> lab) {
      RandomStream random(seed, static_cast<std::uint64_t>(y * 24 + x),
                          static_cast<std::uint32_t>(std::lround(16 * t)));
      for (double& v : lab) v += noise * random.normal();
      return lab;
    };
    const ColorStack a = make_stack(
        24, 10, 33, 8.0, [&](int x, int y, double t) { return noisy(1, x, y, t, aged(x, y, step(t, 4.0, 0.7))); });
    const ColorStack b = make_stack(24, 10, 33, 8.0, [&](int x, int y, double t) {
      return noisy(2, x, y, t, aged(x, y, step(t - later(x), 4.0, 0.7)));
    });
    const TimeShift shift = find_time_shift(a, b, std::vector<std::uint8_t>(240, 1));
    // Bound of an unbiased estimate: noise of both sides over the energy of the slope; without noise what blending
    // between frames bends.
    const double slope = std::sqrt((30.0 * 30 + 25 * 25 + 15 * 15) / (6.0 * 0.7) / 0.25),
                 sigma = std::sqrt(2.0) * noise / slope;
    for (std::size_t i = 0; i < 240; ++i)
      EXPECT_NEAR(static_cast<double>(shift.shift[i]), later(static_cast<int>(i % 24)), 5.0 * sigma + 0.01)
          << i << " noise " << noise;
  }
}

TEST(TimeWarp, ShiftOfASurfaceAgainstItselfIsZeroAndUnknownStaysUnknown) {
  const ColorStack a = make_stack(6, 4, 9, 2.0, [](int x, int y, double t) { return aged(x, y, t / 2.0); });
  std::vector<std::uint8_t> known(24, 1);
  known[5] = 0;
  const TimeShift shift = find_time_shift(a, a, known);
  for (float s : shift.shift) EXPECT_EQ(s, 0.0f);
  EXPECT_EQ(shift.is_known, known);
  const ColorStack other = make_stack(6, 4, 9, 2.0, [](int, int, double) { return std::array<double, 3>{0, 0, 0}; });
  EXPECT_THROW((void)find_time_shift(a, other, {1}), InvalidInput);
}

TEST(PixelDifference, OfAShiftedCopyIsThePublishedPairsAndOfItselfIsZero) {
  // Pairs 17 to 20 of Sharma, Wu, Dalal 2005, one a quarter of the surface.
  const std::array<std::array<double, 3>, 4> other{{{73, 25, -18}, {61, -5, 29}, {56, -27, -3}, {58, 24, 15}}};
  const std::array<double, 4> published{27.1492, 22.8977, 31.9030, 19.4535};
  const ColorStack a = make_stack(8, 8, 2, 1.0, [](int, int, double) { return std::array<double, 3>{50, 2.5, 0}; });
  const ColorStack b = make_stack(8, 8, 2, 1.0, [&](int x, int y, double) { return other[(y / 4) * 2 + x / 4]; });
  const std::vector<PixelDifference> found = pixel_differences(a, b), none = pixel_differences(a, a);
  EXPECT_NEAR(found[0].ciede2000_mean, (published[0] + published[1] + published[2] + published[3]) / 4, 1e-4);
  EXPECT_NEAR(found[1].ciede2000_median, published[1], 1e-4);
  EXPECT_NEAR(found[1].ciede2000_p95, published[2], 1e-4);
  EXPECT_EQ(none[0].ciede2000_p95, 0.0);
  EXPECT_EQ(none[0].absolute, 0.0);
  EXPECT_EQ(none[1].ssim, 1.0);
}

}  // namespace
}  // namespace patinate::analysis
