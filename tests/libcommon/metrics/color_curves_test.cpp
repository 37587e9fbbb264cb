#include "libcommon/metrics/color_curves.h"

#include <gtest/gtest.h>

#include <cmath>

#include "patinate/core/error.h"

namespace patinate {
namespace {

TEST(ColorCurves, LabOfPrimariesIsThatOfTheTables) {
  // Lindbloom's CIE color calculator, sRGB primaries under D65; three digits.
  const auto red = lab_from_linear(1, 0, 0), green = lab_from_linear(0, 1, 0), blue = lab_from_linear(0, 0, 1);
  EXPECT_NEAR(red[0], 53.24, 0.01);
  EXPECT_NEAR(red[1], 80.09, 0.01);
  EXPECT_NEAR(red[2], 67.20, 0.01);
  EXPECT_NEAR(green[0], 87.73, 0.01);
  EXPECT_NEAR(green[1], -86.18, 0.01);
  EXPECT_NEAR(blue[2], -107.86, 0.01);
}

TEST(ColorCurves, GrayHasNoChromaAndEighteenPercentIsNearFifty) {
  for (double g : {0.0, 0.001, 0.18, 0.5, 1.0}) {
    const auto lab = lab_from_linear(g, g, g);
    EXPECT_NEAR(lab[1], 0.0, 1e-10);
    EXPECT_NEAR(lab[2], 0.0, 1e-10);
  }
  EXPECT_NEAR(lab_from_linear(1, 1, 1)[0], 100.0, 1e-10);
  EXPECT_NEAR(lab_from_linear(0.18, 0.18, 0.18)[0], 116 * std::cbrt(0.18) - 16, 1e-10);
}

TEST(ColorCurves, PercentilesAreNearestRanks) {
  ImageF image(100, 1, 3);
  for (int x = 0; x < 100; ++x) image.at(x, 0, 0) = static_cast<float>(99 - x);
  std::vector<std::uint32_t> pixels(100);
  for (std::uint32_t i = 0; i < 100; ++i) pixels[i] = i;
  const ChannelSummary red = summarize_color(image, pixels).channels[0];
  EXPECT_EQ(red.mean, 49.5);
  EXPECT_EQ(red.p05, 4);
  EXPECT_EQ(red.p50, 49);
  EXPECT_EQ(red.p95, 94);
}

TEST(ColorCurves, DifferenceIsTheDistanceInLab) {
  const ImageF black(1, 1, 3, 0.0f), white(1, 1, 3, 1.0f);
  const std::uint32_t pixel[1] = {0};
  EXPECT_NEAR(delta_e(summarize_color(black, pixel), summarize_color(white, pixel)), 100.0, 1e-9);
}

TEST(ColorCurves, RefusesPixelsOutside) {
  const std::uint32_t pixel[1] = {4};
  EXPECT_THROW((void)summarize_color(ImageF(2, 2, 3), pixel), InvalidInput);
  EXPECT_EQ(summarize_color(ImageF(2, 2, 3), {}).num_pixels, 0);
}

}  // namespace
}  // namespace patinate
