// Distances between distributions and how certain they are.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "analysis/figures/block_bootstrap.h"
#include "analysis/figures/sliced_distance.h"
#include "libcommon/core/random.h"
#include "tests/analysis/compare/stacks.h"

namespace patinate::analysis {
namespace {

using testing_support::make_stack;

std::vector<std::uint32_t> all_of(const ColorStack& stack) {
  std::vector<std::uint32_t> all(stack.num_texels());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

/// Gaussian colors around `mean`; independent texels.
ColorStack gaussian(int side, std::uint64_t seed, std::array<double, 3> mean, double sigma) {
  return make_stack(side, side, 1, 0.0, [&](int x, int y, double) {
    RandomStream random(seed, static_cast<std::uint64_t>(y * side + x));
    return std::array<double, 3>{mean[0] + sigma * random.normal(), mean[1] + sigma * random.normal(),
                                 mean[2] + sigma * random.normal()};
  });
}

double distance(const ColorStack& a, const ColorStack& b) {
  const BlockGrid ga = make_blocks(a, 8), gb = make_blocks(b, 8);
  return sliced_distance(SortedColors(a, 0, all_of(a), ga.block_of, 1 << 20, 0), ga.all(),
                         SortedColors(b, 0, all_of(b), gb.block_of, 1 << 20, 0), gb.all())
      .value();
}

TEST(SlicedDistance, AxesAreUnitVectorsThatFavourNoDirection) {
  double moments[3][3] = {};
  for (const auto& axis : sliced_axes()) {
    EXPECT_NEAR(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2], 1.0, 1e-12);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) moments[i][j] += axis[i] * axis[j] / 15.0;
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(moments[i][j], i == j ? 1.0 / 3.0 : 0.0, 1e-12);
  }
}

TEST(SlicedDistance, OfAShiftedDistributionIsTheShiftWhereverTheTexelsLie) {
  const ColorStack a = gaussian(32, 1, {50, 0, 0}, 8);
  ColorStack b = a;
  for (std::size_t i = 0; i < b.num_texels(); ++i) {  // Shifted by (2, -1, 2), of length 3, and turned upside down.
    const std::size_t from = b.num_texels() - 1 - i;
    b.lab[3 * i] = a.lab[3 * from] + 2.0f, b.lab[3 * i + 1] = a.lab[3 * from + 1] - 1.0f,
              b.lab[3 * i + 2] = a.lab[3 * from + 2] + 2.0f;
  }
  EXPECT_NEAR(distance(a, b), 3.0, 1e-5);  // Rounding of floats.
  EXPECT_EQ(distance(a, a), 0.0);
}

double mean_square(const std::vector<float>& values) {
  double sum = 0.0;
  for (const float v : values) sum += static_cast<double>(v) * static_cast<double>(v);
  return sum / static_cast<double>(values.size());
}

TEST(SlicedMoves, MeanOfSquaresIsTheSquareOfTheDistanceForAnyNumberOfTexels) {
  const ColorStack a = gaussian(16, 1, {50, 0, 0}, 8);
  for (const int side : {16, 7, 23}) {
    const ColorStack b = gaussian(side, 2, {56, 4, -3}, 3);
    EXPECT_NEAR(std::sqrt(mean_square(sliced_moves(a, 0, b, 0))), distance(a, b), 1e-4) << side;
  }
}

TEST(SlicedMoves, AColorThatTheOtherLacksMovesAndTheRestStays) {
  ColorStack a = gaussian(32, 1, {50, 0, 0}, 0.0), b = a;
  for (std::size_t i = 0; i < 64; ++i) a.lab[3 * i] = 80.0f;  // A sixteenth is 30 lighter.
  const std::vector<float> moves = sliced_moves(a, 0, b, 0);
  for (std::size_t i = 0; i < moves.size(); ++i) EXPECT_NEAR(moves[i], i < 64 ? 30.0 : 0.0, 1e-3) << i;
}

TEST(SlicedMoves, EqualColorsMoveAlikeWhereverTheyStand) {
  ColorStack a = gaussian(32, 1, {50, 0, 0}, 0.0), b = gaussian(32, 2, {50, 0, 0}, 5.0);
  const std::vector<float> moves = sliced_moves(a, 0, b, 0);
  for (const float m : moves) EXPECT_NEAR(m, moves.front(), 1e-5);
}

TEST(SlicedDistance, OfTwoSpreadsIsTheirDifference) {
  // Isotropic Gaussians of one mean: along every axis W2 = |s1 - s2|, so the scaled figure is sqrt(3) |s1 - s2|.
  const double found = distance(gaussian(128, 1, {50, 0, 0}, 4), gaussian(128, 2, {50, 0, 0}, 9));
  EXPECT_NEAR(found, std::sqrt(3.0) * 5.0,
              4.0 * std::sqrt(3.0) * 9.0 / std::sqrt(2.0 * 128 * 128));  // 4 sigma of a standard deviation.
}

TEST(SlicedDistance, WeighsBlocksAsIfTheyWereRepeated) {
  const ColorStack a = gaussian(16, 1, {50, 0, 0}, 8), b = gaussian(16, 2, {60, 5, 0}, 4);
  const BlockGrid grid = make_blocks(a, 2);
  const std::vector<int> weights{0, 3, 1, 0};
  ColorStack repeated;  // Block 1 three times, block 2 once, as a strip of 256 texels.
  repeated.width = 256, repeated.height = 1, repeated.times = {0.0};
  for (std::size_t i = 0; i < a.num_texels(); ++i) {
    for (int k = 0; k < weights[grid.block_of[i]]; ++k) {
      repeated.texels.push_back(static_cast<std::uint32_t>(repeated.texels.size()));
      repeated.lab.insert(repeated.lab.end(), a.lab.begin() + static_cast<std::ptrdiff_t>(3 * i),
                          a.lab.begin() + static_cast<std::ptrdiff_t>(3 * i) + 3);
    }
  }
  ASSERT_EQ(repeated.num_texels(), 256u);
  const double weighted = sliced_distance(SortedColors(a, 0, all_of(a), grid.block_of, 1 << 20, 0), weights,
                                          SortedColors(b, 0, all_of(b), grid.block_of, 1 << 20, 0), grid.all())
                              .value();
  EXPECT_NEAR(weighted, distance(repeated, b), 1e-9);
  EXPECT_FALSE(sliced_distance(SortedColors(a, 0, all_of(a), grid.block_of, 1 << 20, 0), std::vector<int>(4, 0),
                               SortedColors(b, 0, all_of(b), grid.block_of, 1 << 20, 0), grid.all()));
}

TEST(BlockBootstrap, StandardErrorOfAMeanIsTheTextbooksWhateverTheThreads) {
  // 64 blocks of one value each: the standard error of their mean is s / sqrt(64) (the bootstrap's s divides by n).
  ColorStack stack = gaussian(64, 5, {50, 0, 0}, 0.0);
  const BlockGrid grid = make_blocks(stack, 8);
  std::vector<double> value(64);
  double mean = 0, variance = 0;
  for (std::size_t b = 0; b < 64; ++b) value[b] = RandomStream(9, b).normal(), mean += value[b] / 64;
  for (double v : value) variance += (v - mean) * (v - mean) / 64;
  const BlockFigure figure = [&](const std::vector<int>& wa, const std::vector<int>&) {
    double sum = 0, count = 0;
    for (std::size_t b = 0; b < 64; ++b) sum += wa[b] * value[b], count += wa[b];
    return std::vector<double>{sum / count};
  };
  RunControl one, four;
  one.num_threads = 1, four.num_threads = 4;
  const auto errors = block_standard_errors(grid, grid, figure, {.resamples = 2000, .seed = 3}, one);
  ASSERT_TRUE(errors);
  EXPECT_NEAR((*errors)[0], std::sqrt(variance / 64), 4.0 * std::sqrt(variance / 64) / std::sqrt(2.0 * 2000));
  EXPECT_EQ(errors, block_standard_errors(grid, grid, figure, {.resamples = 2000, .seed = 3}, four));
}

TEST(BlockBootstrap, IntervalCoversTheTruthAboutAsOftenAsItSays) {
  // Surfaces of independent blocks whose mean L* is 0; 1.96 standard errors around the found mean hold 0 in about 95 of
  // 100.
  int covered = 0;
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    ColorStack stack = make_stack(8, 8, 1, 0.0, [&](int x, int y, double) {
      return std::array<double, 3>{RandomStream(trial, static_cast<std::uint64_t>(8 * y + x)).normal(), 0, 0};
    });
    const BlockGrid grid = make_blocks(stack, 8);
    const BlockFigure figure = [&](const std::vector<int>& wa, const std::vector<int>&) {
      double sum = 0, count = 0;
      for (std::size_t i = 0; i < 64; ++i)
        sum += wa[grid.block_of[i]] * static_cast<double>(stack.lab[3 * i]), count += wa[grid.block_of[i]];
      return std::vector<double>{sum / count};
    };
    const auto errors = block_standard_errors(grid, grid, figure, {.resamples = 200, .seed = trial});
    covered += std::abs(figure(grid.all(), grid.all())[0]) < 1.96 * errors.value()[0] ? 1 : 0;
  }
  EXPECT_GE(covered, 0.95 * 200 - 4 * std::sqrt(200 * 0.95 * 0.05));  // 4 sigma of a binomial count.
  EXPECT_LE(covered, 199);
}

TEST(BlockBootstrap, SaysNothingOfTooFewBlocks) {
  const ColorStack stack = gaussian(1, 1, {50, 0, 0}, 1);
  const BlockGrid grid = make_blocks(stack, 8);
  EXPECT_EQ(grid.used.size(), 1u);
  EXPECT_FALSE(
      block_standard_errors(grid, grid, [](const auto&, const auto&) { return std::vector<double>{1.0}; }, {}));
}

TEST(BlockGrid, HalvesAreAChessBoardThatSharesNothing) {
  const BlockGrid grid = make_blocks(gaussian(16, 1, {50, 0, 0}, 1), 4);
  const std::vector<int> black = grid.half(false), white = grid.half(true);
  for (std::size_t b = 0; b < 16; ++b) EXPECT_EQ(black[b] + white[b], 1);
  EXPECT_EQ(black[0], 1);
  EXPECT_EQ(black[1], 0);
  EXPECT_EQ(black[4], 0);
}

}  // namespace
}  // namespace patinate::analysis
