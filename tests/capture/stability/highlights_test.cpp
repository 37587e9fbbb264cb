#include "capture/stability/highlights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace patinate::capture {
namespace {

constexpr int kGlazeSide = 320;

/// A gray picture of one photograph, clipped at 1, with grain of a standard deviation of 0.02.
ImageF picture(const std::function<double(int, int)>& light) {
  std::mt19937 random(5);
  std::normal_distribution<double> grain(0.0, 0.02);
  ImageF image(kGlazeSide, kGlazeSide, 3);
  for (int y = 0; y < kGlazeSide; ++y) {
    for (int x = 0; x < kGlazeSide; ++x) {
      const double value = light(x, y) + grain(random);
      for (float& v : image.pixel(x, y)) v = static_cast<float>(std::clamp(value, 0.0, 1.0));
    }
  }
  return image;
}
/// White glaze, in light that falls off to the right, with dark cracks 3 px wide in a grid that is bent.
double glaze(int x, int y, double brightest) {
  const double across = x + 5.0 * std::sin(0.06 * y), down = y + 7.0 * std::sin(0.045 * x);
  const bool is_crack = std::fmod(across + 100.0, 29.0) < 3.0 || std::fmod(down + 100.0, 37.0) < 3.0;
  return brightest * (1.0 - 0.15 * x / kGlazeSide) * (is_crack ? 0.2 : 1.0);
}
double lobe(int x, int y, double height, double sigma) {
  return height * std::exp(-0.5 * (std::pow(x - 150.0, 2) + std::pow(y - 170.0, 2)) / (sigma * sigma));
}
/// Round patches, 22 px across, 34 px apart.
bool is_patch(int x, int y) { return std::hypot(x % 34 - 17.0, y % 34 - 17.0) < 11.0; }

/// Share of the picture that is masked, as ingest masks a single photograph.
double masked_share(const ImageF& image, ImageU8& mask) {
  mask = find_standing_highlight(
      1, [&](int) { return image; }, 1.0f);
  const ImageU8 saturated = find_saturated(image, 0.99f);
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) mask.data()[i] = std::max(mask.data()[i], saturated.data()[i]);
  return static_cast<double>(std::count(mask.values().begin(), mask.values().end(), 255)) /
         static_cast<double>(mask.num_pixels());
}

TEST(WhiteMaterial, CrackedGlazeIsKeptWhetherItIsClippedOrNot) {
  ImageU8 mask;
  for (double brightest : {0.8, 0.9, 1.0, 1.1}) {  // With 1.1, two thirds of it are clipped.
    const ImageF image = picture([&](int x, int y) { return glaze(x, y, brightest); });
    EXPECT_LT(masked_share(image, mask), 0.05) << brightest << ": what is asked for of a single photograph";
  }
}

TEST(WhiteMaterial, PatchesOfPaintOnDarkerPaintAreKept) {
  ImageU8 mask;
  const ImageF image = picture([](int x, int y) { return is_patch(x, y) ? 0.88 : 0.25; });
  EXPECT_LT(masked_share(image, mask), 0.01) << "they end sharply, and only their brightest grains are clipped";
}

TEST(WhiteMaterial, AReflectionOnGlazeIsMaskedAndTheGlazeIsNot) {
  // The glaze is 0.72 to 0.61 bright: the sum is clipped to 11 px around the middle.
  ImageU8 mask;
  const ImageF image = picture([](int x, int y) { return glaze(x, y, 0.72) + lobe(x, y, 1.2, 9.0); });
  EXPECT_LT(masked_share(image, mask), 0.04);
  for (int y = 160; y <= 180; ++y) {
    for (int x = 140; x <= 160; ++x) {
      if (image.at(x, y) >= 0.99f) {
        ASSERT_EQ(mask.at(x, y), 255) << x << " " << y;
      }
    }
  }
}

TEST(WhiteMaterial, AReflectionOnCrackedGrayIsMaskedAsFarAsItsSkirt) {
  // With sigma 14 and a ground of 0.25, a fifth of the height of 0.75 is left 28 px from the middle.
  ImageU8 mask;
  const ImageF image = picture([](int x, int y) { return glaze(x, y, 0.27) + lobe(x, y, 1.2, 14.0); });
  const double share = masked_share(image, mask), expected = 3.14159 * 28 * 28 / kGlazeSide / kGlazeSide;
  EXPECT_GT(share, 0.6 * expected);
  EXPECT_LT(share, 1.6 * expected) << "the mask is closed and widened by two pixels, and cracks do not draw it out";
  for (int y = 160; y <= 180; ++y) {
    for (int x = 140; x <= 160; ++x) ASSERT_EQ(mask.at(x, y), 255) << x << " " << y;
  }
}

}  // namespace
}  // namespace patinate::capture
