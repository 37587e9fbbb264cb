#include "libcommon/output/map_legend.h"

#include <gtest/gtest.h>

namespace patinate {
namespace {

TEST(MapLegend, ShowsThePictureAsItIsAboveTheWholeRamp) {
  ImageF picture(200, 30, 3, 0.25f);
  picture.at(7, 11, 1) = 0.75f;
  const ImageF shown = with_legend(picture, {.ramp = ColorRamp::Diverging, .low = -3.0, .high = 3.0, .unit = "um"});
  ASSERT_EQ(shown.width(), 200);
  ASSERT_GT(shown.height(), picture.height());
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      for (int c = 0; c < 3; ++c) ASSERT_EQ(shown.at(x, y, c), picture.at(x, y, c));
    }
  }
  const auto has = [&](const std::array<float, 3>& color) {
    for (int y = picture.height(); y < shown.height(); ++y) {
      for (int x = 0; x < shown.width(); ++x) {
        if (std::equal(color.begin(), color.end(), shown.pixel(x, y).begin())) return true;
      }
    }
    return false;
  };
  EXPECT_TRUE(has(ramp_color(ColorRamp::Diverging, 0.0)));
  EXPECT_TRUE(has(ramp_color(ColorRamp::Diverging, 1.0)));
}

TEST(MapLegend, LeavesRoomForNumbersUnderANarrowMap) {
  const ImageF shown = with_legend(ImageF(16, 16, 3, 0.5f), {.unit = "Delta E 2000", .more = "gray: not measured"});
  EXPECT_GE(shown.width(), 160);
  float darkest = 1.0f;  // Ink below the ramp.
  for (int y = shown.height() - 40; y < shown.height(); ++y) {
    for (int x = 0; x < shown.width(); ++x) darkest = std::min(darkest, shown.at(x, y, 0));
  }
  EXPECT_LT(darkest, 0.3f);
}

}  // namespace
}  // namespace patinate
