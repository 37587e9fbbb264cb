#include "libcommon/history/footprint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/history/memory_history.h"
#include "patinate/history/write_history.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

/// 0 but for a line of ones, a pixel wide, every `period` columns.
ImageF lines(int size, int period) {
  ImageF image(size, size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; x += period) image.at(x, y) = 1.0f;
  }
  return image;
}

TEST(Footprint, OfOnePixelIsThatPixel) {
  const ImageF image = lines(32, 5);
  EXPECT_EQ(mean_over_footprint(image, {}, 1.0), image);
  EXPECT_EQ(mean_over_footprint(image, {}, kMinFootprint_px), image);
}

TEST(Footprint, EverySampleOfALineSeesIt) {
  // Texels of 3 pixels over lines 9 pixels apart: where a texel looks at one pixel, two of three placements miss every
  // line.
  constexpr double kTexel = 3.0;
  const ImageF seen = mean_over_footprint(lines(90, 9), {}, kTexel);
  for (int start = 0; start < 3; ++start) {
    double sum = 0.0;
    for (int x = 27 + start; x < 63; x += 3) sum += static_cast<double>(seen.at(x, 45));
    // 12 texels over 4 lines of a third of a texel each. Of the wave that is as long as a texel, twice the mean high,
    // exp(-2 pi^2 sigma^2 / texel^2) = 0.23 is left, which adds up over the texels; of shorter ones 0.003.
    EXPECT_NEAR(sum, 4.0 / 3.0, 4.0 / 3.0 * 0.47) << start;
  }
}

TEST(Footprint, KeepsTheMeanAndTheVarianceOfItsSquare) {
  constexpr double kSide = 4.0;
  ImageF point(41, 41);
  point.at(20, 20) = 1.0f;
  const ImageF seen = mean_over_footprint(point, {}, kSide);
  double sum = 0.0, variance = 0.0;
  for (int y = 0; y < 41; ++y) {
    for (int x = 0; x < 41; ++x) {
      const double v = static_cast<double>(seen.at(x, y));
      sum += v;
      variance += v * (x - 20) * (x - 20);
    }
  }
  EXPECT_NEAR(sum, 1.0, 1e-5);
  // A square of side a has a^2 / 12; the pixel is one of side 1 already. Sampling and the cut at 4 sigma change 1 %.
  EXPECT_NEAR(variance, (kSide * kSide - 1.0) / 12.0, 0.02);
}

TEST(Footprint, WhatIsOutsideOfTheMaskCountsNowhere) {
  ImageF image(20, 20, 1, 0.25f);
  ImageU8 mask(20, 20, 1, 255);
  for (int y = 0; y < 20; ++y) {
    for (int x = 10; x < 20; ++x) {
      image.at(x, y) = 1000.0f;
      mask.at(x, y) = 0;
    }
  }
  const ImageF seen = mean_over_footprint(image, mask, 5.0);
  for (int x = 0; x < 10; ++x) EXPECT_NEAR(seen.at(x, 10), 0.25f, 1e-5f) << x;
}

TEST(Footprint, OutOfRangeIsRefused) {
  EXPECT_THROW((void)mean_over_footprint(ImageF(2, 2), {}, -1.0), InvalidInput);
  EXPECT_THROW((void)mean_over_footprint(ImageF(2, 2), {}, std::nan("")), InvalidInput);
}

// A texel that covers several pixels shows the same, wherever the history is kept.
TEST(Footprint, OfAHistoryInMemoryIsThatOfItsFolder) {
  constexpr double kSide = 2.5;
  MemoryHistoryImages images = testing_support::half_images(24, 16, 2, testing_support::blotches);
  images.mask = ImageU8(24, 16, 1, 255);
  images.mask.at(3, 4) = 0;
  images.frames[1].extras = {{"normal", ImageF(24, 16, 3, 0.5f)}};
  images.frames[1].extras[0].image.at(7, 7, 0) = 0.25f;
  const auto memory = std::make_shared<const MemoryHistory>(std::move(images));
  const testing_support::TempFolder folder;
  write_history(folder.path(), *memory);
  const HistoryReader disk(folder.path(), kSide);
  const FootprintHistory seen(memory, kSide);
  EXPECT_EQ(seen.facts(), memory->facts());
  EXPECT_EQ(seen.read_frame(1), disk.read_frame(1));
  EXPECT_EQ(seen.read_frame_extra(1, "normal"), disk.read_frame_extra(1, "normal"));
  EXPECT_EQ(seen.read_control("x"), memory->read_control("x"));
  EXPECT_EQ(seen.read_mask(), memory->read_mask());
}

}  // namespace
}  // namespace patinate
