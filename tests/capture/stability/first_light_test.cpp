#include "capture/stability/first_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "patinate/core/error.h"

namespace patinate::capture {
namespace {

constexpr int kSide = 160;

/// Reflections on a polished plate: bands of 3 : 1, reddish.
double reflection(int x, int y, int channel) {
  return 0.2 * std::exp((0.55 - 0.1 * channel) * std::sin(0.06 * x + 0.02 * y));
}

/// A plate that still reflects `share` of it, with stains over `stained` of its width.
ImageF polished_plate(double share, double stained) {
  ImageF image(kSide, kSide, 3);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const bool is_stained = x < stained * kSide && (x / 7 + y / 9) % 2 == 0;
      for (int c = 0; c < 3; ++c) {
        const double light = std::pow(reflection(x, y, c) / 0.2, share);
        image.at(x, y, c) = static_cast<float>(0.2 * light * (is_stained ? 0.5 + 0.4 * c : 1.0));
      }
    }
  }
  return image;
}

/// Largest over smallest value of a channel, away from the border, which smoothing sees on one side only.
double ratio_of(const ImageF& image, int channel) {
  float low = 1e9f, high = 0.0f;
  for (int y = 16; y < kSide - 16; ++y) {
    for (int x = 16; x < kSide - 16; ++x) {
      low = std::min(low, image.at(x, y, channel));
      high = std::max(high, image.at(x, y, channel));
    }
  }
  return static_cast<double>(high / low);
}

TEST(FirstLight, AReflectionThatFadesIsTakenOutAsMuchAsItStillShows) {
  const ImageF gain = first_light_gain(polished_plate(1.0, 0.0));
  for (const double share : {1.0, 0.6, 0.25, 0.0}) {
    ImageF image = polished_plate(share, 0.0);
    const std::array<double, 3> shares = remaining_first_light(image, gain);
    apply_first_light_gain(image, gain, shares);
    for (std::size_t c = 0; c < 3; ++c) {
      // Smoothing by 1/40 of the side, 4 px, lowers a wave of 2 pi / 0.063 px by 1 - exp(-(4 * 0.063)^2 / 2) = 3.2 %,
      // and a little more, as it is of light, not of its logarithm.
      EXPECT_NEAR(shares[c], share, 0.04 * share + 1e-3) << share;
      EXPECT_LT(ratio_of(image, static_cast<int>(c)), 1.04) << "of 3 : 1, at " << share;
    }
  }
}

TEST(FirstLight, StainsOverAThirdDoNotDecideTheShare) {
  const ImageF gain = first_light_gain(polished_plate(1.0, 0.0));
  for (const double share : remaining_first_light(polished_plate(0.4, 0.33), gain)) EXPECT_NEAR(share, 0.4, 0.04);
}

TEST(FirstLight, ScratchesStay) {
  ImageF first = polished_plate(1.0, 0.0);
  for (int y = 0; y < kSide; ++y) {
    for (float& v : first.pixel(80, y)) v *= 1.5f;
  }
  ImageF even = first;
  const ImageF gain = first_light_gain(first);
  apply_first_light_gain(even, gain, remaining_first_light(first, gain));
  // A line of one pixel raises a mean of sigma 4 px by a tenth of itself.
  EXPECT_NEAR(static_cast<double>(even.at(80, 80, 1) / even.at(90, 80, 1)), 1.5, 0.1);
}

TEST(FirstLight, WhatLiesAroundTheSurfaceSaysNothing) {
  ImageU8 mask(kSide / 2, kSide / 2);  // At half the size: the left half.
  for (int y = 0; y < mask.height(); ++y) std::fill_n(mask.row(y).begin(), mask.width() / 2, std::uint8_t{255});
  ImageF later = polished_plate(0.4, 0.0);
  const ImageF first = polished_plate(1.0, 0.0), gain = first_light_gain(first, mask);
  for (int y = 0; y < kSide; ++y) {  // The table keeps its light.
    std::copy_n(&first.at(kSide / 2, y, 0), 3 * (kSide / 2), &later.at(kSide / 2, y, 0));
  }
  for (const double share : remaining_first_light(later, gain)) EXPECT_NEAR(share, 0.4, 0.04);
  EXPECT_EQ(gain.at(kSide - 1, 0, 0), 1.0f);
  EXPECT_THROW((void)first_light_gain(first, ImageU8(4, 4)), InvalidInput);
}

TEST(FirstLight, AnEvenFirstPhotographChangesNothing) {
  const ImageF even(kSide, kSide, 3, 0.3f), gain = first_light_gain(even);
  ImageF later = polished_plate(1.0, 0.5);
  const ImageF before = later;
  apply_first_light_gain(later, gain, remaining_first_light(later, gain));
  for (std::size_t i = 0; i < later.values().size(); ++i) ASSERT_NEAR(later.data()[i], before.data()[i], 1e-5f);
}

TEST(FirstLight, BadImagesAreRefused) {
  EXPECT_THROW((void)first_light_gain(ImageF(8, 8, 3)), InvalidInput);
  EXPECT_THROW((void)remaining_first_light(ImageF(8, 8, 3), ImageF(9, 8, 3)), InvalidInput);
}

}  // namespace
}  // namespace patinate::capture
