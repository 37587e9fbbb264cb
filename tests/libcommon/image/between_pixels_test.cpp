#include "libcommon/image/between_pixels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate {
namespace {

constexpr int kSide = 12;

float value_at(const ImageF& image, float x, float y) {
  float value = 0.0f;
  look_at<1>(image.data(), image.width(), image.height(), x, y, &value);
  return value;
}

ImageF noise(int channels) {
  ImageF image(kSide, kSide, channels);
  RandomStream random(3, 0);
  for (float& value : image.values()) value = static_cast<float>(random.uniform());
  return image;
}

TEST(BetweenPixels, TheMiddleOfAPixelIsThePixelToTheBit) {
  const ImageF image = noise(1);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x)
      ASSERT_EQ(value_at(image, static_cast<float>(x), static_cast<float>(y)), image.at(x, y));
  }
}

// Keys's cubic is known for this: polynomials up to the second degree come out as they are.
TEST(BetweenPixels, AParabolaIsReproduced) {
  ImageF image(kSide, kSide);
  const auto parabola = [](double x, double y) { return 0.5 + 0.3 * x - 0.02 * x * x + 0.1 * y + 0.04 * x * y; };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) image.at(x, y) = static_cast<float>(parabola(x, y));
  }
  for (const double x : {2.25, 3.5, 5.75, 6.0}) {
    for (const double y : {2.5, 4.125, 6.875})
      EXPECT_NEAR(value_at(image, static_cast<float>(x), static_cast<float>(y)), parabola(x, y), 2e-6) << x << ' ' << y;
  }
}

// Lookups on turned texels are for this: a crack 2 px wide, seen along a plane that is turned against the photograph.
// The nearest pixel lies up to half a diagonal beside the place; the cubic errs where the line is sharper than pixels.
TEST(BetweenPixels, ATurnedLineComesOutNearlyAsItIs) {
  constexpr int kPlane = 64;
  const auto line = [](double x, double y) {
    const double away = (0.8 * (x - 0.5 * kPlane) + 0.6 * (y - 0.5 * kPlane)) / 1.2;
    return 0.5 - 0.4 * std::exp(-away * away);
  };
  ImageF photograph(kPlane, kPlane);
  for (int y = 0; y < kPlane; ++y) {
    for (int x = 0; x < kPlane; ++x) photograph.at(x, y) = static_cast<float>(line(x, y));
  }
  double between = 0.0, nearest = 0.0;
  for (int v = -20; v <= 20; ++v) {
    for (int u = -20; u <= 20; ++u) {
      const double x = 0.5 * kPlane + std::cos(0.5) * u - std::sin(0.5) * v,
                   y = 0.5 * kPlane + std::sin(0.5) * u + std::cos(0.5) * v;
      const auto sx = static_cast<float>(x), sy = static_cast<float>(y);
      between += std::pow(static_cast<double>(value_at(photograph, sx, sy)) - line(x, y), 2);
      nearest += std::pow(static_cast<double>(value_at(photograph, std::round(sx), std::round(sy))) - line(x, y), 2);
    }
  }
  // Linear interpolation, the simpler choice, comes to 0.39 of the nearest pixel's error here.
  EXPECT_LT(std::sqrt(between), 0.26 * std::sqrt(nearest));
}

TEST(BetweenPixels, NoValueLeavesTheRangeOfThePixelsAround) {
  ImageF image(kSide, kSide, 1, 0.25f);
  for (int y = 0; y < kSide; ++y) image.at(6, y) = 0.0f;  // A dark line: an unbounded cubic rings beside it.
  for (float x = 0.0f; x <= kSide - 1; x += 1.0f / 16.0f) {
    EXPECT_GE(value_at(image, x, 5.5f), 0.0f) << x;
    EXPECT_LE(value_at(image, x, 5.5f), 0.25f) << x;
  }
  EXPECT_LT(value_at(image, 6.5f, 5.5f), 0.2f);
}

// Images that are read four values at a time, and those at whose borders that would be too far.
TEST(BetweenPixels, ChannelsAndBordersDoNotMatter) {
  const ImageF image = noise(3);
  RandomStream random(4, 0);
  for (int round = 0; round < 500; ++round) {
    const auto x = static_cast<float>(random.uniform() * (kSide - 1)),
               y = static_cast<float>(random.uniform() * (kSide - 1));
    std::array<float, 3> color{};
    look_at<3>(image.data(), kSide, kSide, x, y, color.data());
    for (int c = 0; c < 3; ++c) {
      ImageF alone(3 * kSide, 3 * kSide);  // Middle of pixels that repeat the border.
      for (int v = 0; v < alone.height(); ++v) {
        for (int u = 0; u < alone.width(); ++u)
          alone.at(u, v) = image.at(std::clamp(u - kSide, 0, kSide - 1), std::clamp(v - kSide, 0, kSide - 1), c);
      }
      const NearestPixel at = nearest_pixel(x, y);
      float value = 0.0f;
      look_between<1>(alone.data(), alone.width(), alone.height(), at.x + kSide, at.y + kSide, at.beside, &value);
      ASSERT_EQ(value, color[c]) << x << ' ' << y << ' ' << c;
    }
  }
}

TEST(BetweenPixels, FiveChannelsAreRefused) {
  EXPECT_THROW((void)look_up(ImageF(kSide, kSide, 5), ImageF(2, 2, 2)), InvalidInput);
}

}  // namespace
}  // namespace patinate
