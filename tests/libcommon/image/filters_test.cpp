#include "libcommon/image/filters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate {
namespace {

constexpr float kSumRounding = 2e-6f;  ///< Sums of at most some hundred floats of order 1.

ImageF seeded_noise(int width, int height, int channels, std::uint64_t seed) {
  ImageF image(width, height, channels);
  RandomStream random(seed, 0);
  for (float& v : image.values()) v = static_cast<float>(random.uniform());
  return image;
}

/// The definition, in double: sum of G in / sum of G over the pixels inside the mask.
double blur_by_definition(const ImageF& in, const ImageU8& mask, double sigma, int px, int py, int c) {
  double sum = 0, total = 0;
  const int radius = static_cast<int>(std::ceil(4 * sigma));
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      if (!is_inside(mask, x, y) || std::abs(x - px) > radius || std::abs(y - py) > radius) continue;
      const double weight = std::exp(-0.5 * ((x - px) * (x - px) + (y - py) * (y - py)) / (sigma * sigma));
      sum += weight * static_cast<double>(in.at(x, y, c));
      total += weight;
    }
  }
  return total > 0 ? sum / total : 0;
}

TEST(GaussianBlur, EqualsItsDefinition) {
  const ImageF in = seeded_noise(17, 11, 3, 1);
  for (double sigma : {0.5, 1.7, 6.0}) {
    const ImageF out = gaussian_blur(in, sigma);
    for (int y = 0; y < in.height(); ++y) {
      for (int x = 0; x < in.width(); ++x) {
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(static_cast<double>(out.at(x, y, c)), blur_by_definition(in, {}, sigma, x, y, c), 1e-5);
        }
      }
    }
  }
}

TEST(GaussianBlur, IgnoresWhatLiesOutsideTheMask) {
  ImageF in = seeded_noise(15, 13, 2, 2);
  ImageU8 mask(15, 13, 1, 255);
  for (int y = 3; y < 9; ++y) {
    for (int x = 5; x < 12; ++x) mask.at(x, y) = 0;
  }
  const ImageF before = gaussian_blur(in, mask, 1.5);
  for (int y = 0; y < 13; ++y) {
    for (int x = 0; x < 15; ++x) {
      EXPECT_NEAR(static_cast<double>(before.at(x, y, 1)), blur_by_definition(in, mask, 1.5, x, y, 1), 1e-5);
      if (mask.at(x, y) == 0) in.at(x, y, 0) = in.at(x, y, 1) = 1e6f;
    }
  }
  EXPECT_EQ(before, gaussian_blur(in, mask, 1.5));
}

TEST(GaussianBlur, KeepsConstantsAlsoAtBorders) {
  const ImageF out = gaussian_blur(ImageF(9, 5, 1, 0.7f), 3.0);
  for (float v : out.values()) EXPECT_NEAR(v, 0.7f, kSumRounding);
}

TEST(GaussianBlur, IsZeroWhereNoMaskedPixelIsNear) {
  ImageU8 mask(40, 1);
  mask.at(0, 0) = 1;
  const ImageF out = gaussian_blur(ImageF(40, 1, 1, 1.0f), mask, 1.0);
  EXPECT_EQ(out.at(4, 0), 1.0f);
  EXPECT_EQ(out.at(5, 0), 0.0f);
}

TEST(GaussianBlur, SigmaZeroCopiesAndBadSigmasAreErrors) {
  const ImageF in = seeded_noise(4, 4, 1, 3);
  EXPECT_EQ(gaussian_blur(in, 0.0), in);
  EXPECT_THROW((void)gaussian_blur(in, -1.0), InvalidInput);
  EXPECT_THROW((void)gaussian_blur(in, std::nan("")), InvalidInput);
  EXPECT_THROW((void)gaussian_blur(in, ImageU8(3, 4), 1.0), InvalidInput);
}

TEST(Filters, GiveTheSameBitsForAnyNumberOfThreads) {
  const ImageF in = seeded_noise(70, 90, 3, 4);
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  EXPECT_EQ(gaussian_blur(in, 2.0, one), gaussian_blur(in, 2.0, three));
  EXPECT_EQ(downscale_area(in, 31, 17, one), downscale_area(in, 31, 17, three));
  EXPECT_EQ(resize_bilinear(in, 131, 17, one), resize_bilinear(in, 131, 17, three));
}

TEST(DownscaleArea, AveragesWholeBlocks) {
  const ImageF in = seeded_noise(6, 4, 2, 5);
  const ImageF out = downscale_area(in, 3, 2);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      const float mean = (in.at(2 * x, 2 * y, 1) + in.at(2 * x + 1, 2 * y, 1) + in.at(2 * x, 2 * y + 1, 1) +
                          in.at(2 * x + 1, 2 * y + 1, 1)) /
                         4.0f;
      EXPECT_NEAR(out.at(x, y, 1), mean, kSumRounding);
    }
  }
}

TEST(DownscaleArea, KeepsTheMeanForAnyFactor) {
  const ImageF in = seeded_noise(37, 23, 1, 6);
  const auto mean = [](const ImageF& image) {
    double sum = 0;
    for (float v : image.values()) sum += static_cast<double>(v);
    return sum / static_cast<double>(image.num_pixels());
  };
  EXPECT_NEAR(mean(downscale_area(in, 10, 7)), mean(in), 1e-6);
  EXPECT_EQ(downscale_area(in, 37, 23), in);
  EXPECT_THROW((void)downscale_area(in, 38, 23), InvalidInput);
  EXPECT_THROW((void)downscale_area(in, 0, 23), InvalidInput);
}

TEST(ResizeBilinear, ReproducesLinearRampsInside) {
  ImageF ramp(8, 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 8; ++x) ramp.at(x, y) = static_cast<float>(2 * x + 3 * y);
  }
  const ImageF out = resize_bilinear(ramp, 16, 10);
  for (int y = 1; y < 9; ++y) {
    for (int x = 1; x < 15; ++x) {
      const float x_in = (static_cast<float>(x) + 0.5f) / 2.0f - 0.5f,
                  y_in = (static_cast<float>(y) + 0.5f) / 2.0f - 0.5f;
      EXPECT_NEAR(out.at(x, y), 2 * x_in + 3 * y_in, 1e-5f);
    }
  }
  EXPECT_EQ(resize_bilinear(ramp, 8, 5), ramp);
  EXPECT_THROW((void)resize_bilinear(ramp, 0, 5), InvalidInput);
}

TEST(Crop, TakesTheRectangleAndChecksIt) {
  const ImageF in = seeded_noise(7, 6, 3, 7);
  const ImageF out = crop(in, 2, 1, 4, 5);
  EXPECT_EQ(out.at(3, 4, 2), in.at(5, 5, 2));
  EXPECT_THROW((void)crop(in, 4, 1, 4, 5), InvalidInput);
  EXPECT_THROW((void)crop(in, -1, 0, 2, 2), InvalidInput);
  EXPECT_THROW((void)crop(in, 1, 1, std::numeric_limits<int>::max(), 1), InvalidInput);
}

TEST(Percentiles, AreRanksOfTheSortedValuesInsideTheMask) {
  ImageF in(101, 1);
  for (int x = 0; x < 101; ++x) in.at(x, 0) = static_cast<float>((x * 37) % 101);
  EXPECT_EQ(percentiles(in, {}, 0.05, 0.95).low, 5.0f);
  EXPECT_EQ(percentiles(in, {}, 0.05, 0.95).high, 95.0f);
  ImageU8 mask(101, 1);
  mask.at(1, 0) = 1;
  EXPECT_EQ(percentiles(in, mask, 0.0, 1.0).low, 37.0f);
  EXPECT_THROW((void)percentiles(in, ImageU8(101, 1), 0.0, 1.0), InvalidInput);
  EXPECT_THROW((void)percentiles(in, {}, 0.9, 0.1), InvalidInput);
}

}  // namespace
}  // namespace patinate
