#include "analysis/figures/spatial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libcommon/core/random.h"
#include "libcommon/image/filters.h"
#include "tests/analysis/compare/stacks.h"

namespace patinate::analysis {
namespace {

using testing_support::make_stack;

ColorStack of_image(const ImageF& image) {
  return make_stack(image.width(), image.height(), 1, 0.0, [&](int x, int y, double) {
    return std::array<double, 3>{static_cast<double>(image.at(x, y)), 0, 0};
  });
}

ImageF white_noise(int side, std::uint64_t seed) {
  ImageF image(side, side);
  for (std::int64_t i = 0; i < image.num_pixels(); ++i)
    image.data()[i] = static_cast<float>(50.0 + 10.0 * RandomStream(seed, static_cast<std::uint64_t>(i)).normal());
  return image;
}

TEST(Spatial, SpectrumOfWhiteNoiseIsFlatAtItsVariance) {
  const ColorStack stack = of_image(white_noise(256, 1));
  const BlockGrid grid = make_blocks(stack, 8);
  const SpatialStructure structure(stack, 0, grid);
  EXPECT_EQ(structure.tile_px(), 64);
  const std::vector<double> power = structure.spectrum(grid.all());
  for (std::size_t k = 0; k < power.size(); ++k) {
    // About 2 pi r^2 / 4 waves of a ring in each of 16 independent tiles: 4 sigma; the lowest rings lose power to the
    // mean that is removed.
    const double r = structure.frequencies()[k] * 64, sigma = 1.0 / std::sqrt(16.0 * std::numbers::pi * r * r / 4.0);
    EXPECT_NEAR(power[k] / 100.0, 1.0, 4.0 * sigma + (r < 2.0 ? 0.35 : 0.0)) << r;
  }
}

TEST(Spatial, SpectrumOfAWaveStandsAtItsFrequency) {
  const ColorStack stack = make_stack(128, 128, 1, 0.0, [](int x, int, double) {
    return std::array<double, 3>{50 + 10 * std::sin(2 * std::numbers::pi * x / 8.0), 0, 0};
  });
  const BlockGrid grid = make_blocks(stack, 8);
  const SpatialStructure structure(stack, 0, grid);
  const std::vector<double> power = structure.spectrum(grid.all());
  const auto peak = static_cast<std::size_t>(std::max_element(power.begin(), power.end()) - power.begin());
  EXPECT_NEAR(std::log2(structure.frequencies()[peak] * 8.0), 0.0, 0.26);  // Its ring is half an octave wide.
}

TEST(Spatial, CorrelationLengthOfBlurredNoiseIsTwiceTheBlur) {
  // Noise under a Gaussian of sigma has the correlation exp(-d^2 / (4 sigma^2)): 1/e at 2 sigma.
  for (const double sigma : {2.0, 4.0}) {
    const ColorStack stack = of_image(gaussian_blur(white_noise(256, 7), sigma));
    const BlockGrid grid = make_blocks(stack, 8);
    const auto length = SpatialStructure(stack, 0, grid).correlation_length(grid.all());
    ASSERT_TRUE(length);
    EXPECT_NEAR(*length, 2.0 * sigma, 0.08 * 2.0 * sigma);  // A few thousand blobs.
  }
}

TEST(Spatial, AConstantSurfaceHasNoCorrelationLength) {
  const ColorStack stack = make_stack(32, 32, 1, 0.0, [](int, int, double) { return std::array<double, 3>{50, 0, 0}; });
  const BlockGrid grid = make_blocks(stack, 4);
  EXPECT_FALSE(SpatialStructure(stack, 0, grid).correlation_length(grid.all()));
  for (double p : SpatialStructure(stack, 0, grid).spectrum(grid.all())) EXPECT_EQ(p, 0.0);
}

TEST(Spatial, WhatLiesOutsideHasNoInfluence) {
  ImageF image = gaussian_blur(white_noise(128, 3), 2.0);
  ColorStack stack = of_image(image);
  stack.texels.clear(), stack.lab.clear();
  for (std::uint32_t i = 0; i < 128 * 128; ++i) {
    if (i % 128 >= 96) continue;  // The right quarter is outside.
    stack.texels.push_back(i);
    for (int c = 0; c < 3; ++c) stack.lab.push_back(c == 0 ? image.data()[i] : 0.0f);
  }
  stack.rgb = stack.lab;
  const ColorStack cut = of_image(crop(image, 0, 0, 96, 128));
  const BlockGrid ga = make_blocks(stack, 1), gb = make_blocks(cut, 1);
  const auto a = SpatialStructure(stack, 0, ga).correlation_length(ga.all()),
             b = SpatialStructure(cut, 0, gb).correlation_length(gb.all());
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(*a, *b, 1e-9);
}

}  // namespace
}  // namespace patinate::analysis
