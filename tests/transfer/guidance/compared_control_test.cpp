#include "transfer/guidance/compared_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libcommon/core/random.h"
#include "libcommon/image/filters.h"

namespace patinate::transfer {
namespace {

constexpr int kSide = 128;

/// One wave over the image, and noise of single pixels.
ImageF waves_and_noise(double noise) {
  ImageF image(kSide, kSide);
  RandomStream random(5, 0);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x)
      image.at(x, y) = static_cast<float>(0.5 + 0.25 * std::sin(6.283 * x / kSide) + noise * (random.uniform() - 0.5));
  }
  return image;
}

std::vector<float> in_order(const ImageF& image) {
  std::vector<float> values(image.values().begin(), image.values().end());
  std::sort(values.begin(), values.end());
  return values;
}

TEST(ComparedControl, ASmoothOneStaysAsItIs) {
  const ImageF smooth = waves_and_noise(0.15);  // A twentieth of its variance.
  double blur_px = -1.0;
  EXPECT_EQ(without_fine_texture(smooth, {}, blur_px), smooth);
  EXPECT_EQ(blur_px, 0.0);
}

TEST(ComparedControl, ATexturesGrainIsTakenOutAndItsDistributionStays) {
  const ImageF rough = waves_and_noise(0.5);  // Two fifths.
  double blur_px = 0.0;
  const ImageF compared = without_fine_texture(rough, {}, blur_px);
  EXPECT_GT(blur_px, 0.0);
  EXPECT_LE(blur_px, 4.0);  // Noise of single pixels is gone soon.
  const std::vector<float> before = in_order(rough), after = in_order(compared);
  for (std::size_t i = 0; i < before.size(); i += 97) EXPECT_NEAR(after[i], before[i], 1e-3) << i;
  // Neighbors differ as the wave does, not as noise does.
  double roughness = 0.0;
  for (int x = 1; x < kSide; ++x)
    roughness = std::max(roughness, std::abs(static_cast<double>(compared.at(x, 9) - compared.at(x - 1, 9))));
  EXPECT_LT(roughness, 0.25);
}

TEST(ComparedControl, WhatLiesOutsideTheMaskHasNoInfluence) {
  ImageF rough = waves_and_noise(0.5);
  ImageU8 mask(kSide, kSide, 1, 255);
  for (int y = 0; y < kSide; ++y) std::fill(mask.row(y).begin() + kSide / 2, mask.row(y).end(), std::uint8_t{0});
  double blur_px = 0.0;
  const ImageF compared = without_fine_texture(rough, mask, blur_px);
  for (int y = 0; y < kSide; ++y) std::fill(rough.row(y).begin() + kSide / 2, rough.row(y).end(), 1.0f);
  const ImageF other = without_fine_texture(rough, mask, blur_px);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide / 2; ++x) ASSERT_EQ(other.at(x, y), compared.at(x, y)) << x << ' ' << y;
  }
}

}  // namespace
}  // namespace patinate::transfer
