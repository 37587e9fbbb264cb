#include "analysis/figures/pattern_blocks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "analysis/figures/block_bootstrap.h"
#include "analysis/figures/sliced_distance.h"
#include "libcommon/core/random.h"
#include "libcommon/image/filters.h"
#include "tests/analysis/compare/stacks.h"

namespace patinate::analysis {
namespace {

using testing_support::make_stack;

constexpr int kSide = 128;

/// Blurred noise of standard deviation 5 in L*, 1/e length 2 sigma, with a grain of single pixels on it. Cut from a
/// larger one: none of it knows the borders.
ColorStack patterned(double sigma, double grain, double shift, std::uint64_t seed) {
  constexpr int kMargin = 32, kWhole = kSide + 2 * kMargin;
  ImageF noise(kWhole, kWhole);
  for (std::int64_t i = 0; i < noise.num_pixels(); ++i)
    noise.data()[i] = static_cast<float>(RandomStream(seed, static_cast<std::uint64_t>(i)).normal());
  const ImageF blurred = gaussian_blur(noise, sigma);
  const double gain = 5.0 * 2.0 * std::sqrt(3.14159265358979) * sigma;  // Blurring divides by this / 5.
  return make_stack(kSide, kSide, 1, 0.0, [&](int x, int y, double) {
    const double g = grain * RandomStream(seed + 1, static_cast<std::uint64_t>(kSide * y + x)).normal();
    return std::array<double, 3>{50.0 + shift + gain * static_cast<double>(blurred.at(x + kMargin, y + kMargin)) + g, 0,
                                 0};
  });
}

TEST(PatternBlocks, FeatureIsThatOfThePatternThoughGrainIsStrongerThanIt) {
  for (const double sigma : {3.0, 5.0}) {
    for (const double grain : {0.0, 8.0}) {
      double mean = 0.0;
      for (std::uint64_t k = 0; k < 5; ++k) mean += *feature_px(patterned(sigma, grain, 0.0, 10 * k)) / 5;
      // 2 sigma, sqrt(1 + 4^2 / 12 / (2 sigma^2)) of it in means over 4 pixels; 15 % for a few hundred blobs.
      EXPECT_NEAR(mean, 2.0 * sigma * std::sqrt(1.0 + 16.0 / 12.0 / (2.0 * sigma * sigma)), 0.15 * 2.0 * sigma)
          << sigma << ", grain " << grain;
    }
  }
}

TEST(PatternBlocks, BlocksHoldFourFeaturesBetweenThreeAndEightOfThem) {
  EXPECT_EQ(pattern_blocks(patterned(1.0, 0.0, 0.0, 1)), 8);
  EXPECT_EQ(pattern_blocks(patterned(12.0, 0.0, 0.0, 1)), 3);
  const int blocks = pattern_blocks(patterned(3.0, 0.0, 0.0, 1));
  EXPECT_GE(blocks, 4);  // 128 / (4 x 6) = 5.3, give or take a quarter.
  EXPECT_LE(blocks, 7);
  EXPECT_EQ(pattern_blocks(make_stack(64, 64, 1, 0.0,
                                      [](int, int, double) {
                                        return std::array<double, 3>{50, 0, 0};
                                      })),
            8);
}

/// Share of pairs whose interval of the distance holds the truth.
double coverage(double sigma, double grain, double shift, int num_pairs) {
  int held = 0;
  for (int k = 0; k < num_pairs; ++k) {
    const auto seed = static_cast<std::uint64_t>(k) * 100 + static_cast<std::uint64_t>(10 * sigma);
    const ColorStack a = patterned(sigma, grain, 0.0, seed), b = patterned(sigma, grain, shift, seed + 50);
    const int blocks = std::min(pattern_blocks(a), pattern_blocks(b));
    const BlockGrid ga = make_blocks(a, blocks), gb = make_blocks(b, blocks);
    std::vector<std::uint32_t> all(a.num_texels());
    std::iota(all.begin(), all.end(), 0u);
    const SortedColors ca(a, 0, all, ga.block_of, 1024, 0), cb(b, 0, all, gb.block_of, 1024, 0);
    const BlockFigure figure = [&](const std::vector<int>& wa, const std::vector<int>& wb) {
      return std::vector<double>{*sliced_distance(ca, wa, cb, wb)};
    };
    const auto interval = block_intervals(ga, gb, figure(ga.all(), gb.all()), figure,
                                          {.resamples = 80, .seed = static_cast<std::uint64_t>(k)});
    held += interval->front().low <= shift && shift <= interval->front().high;
  }
  return static_cast<double>(held) / num_pairs;
}

TEST(BlockIntervals, HoldTheTrueDistanceOfSurfacesOfOneProcessAndOfShiftedOnes) {
  constexpr int kPairs = 40;
  for (const double sigma : {2.0, 6.0}) {
    for (const double shift : {0.0, 4.0}) {
      const double share = coverage(sigma, 2.0, shift, kPairs);
      // Three sigma of a share, were nine tenths held.
      EXPECT_GE(share, 0.9 - 3.0 * std::sqrt(0.9 * 0.1 / kPairs)) << "sigma " << sigma << ", shifted by " << shift;
    }
  }
}

}  // namespace
}  // namespace patinate::analysis
