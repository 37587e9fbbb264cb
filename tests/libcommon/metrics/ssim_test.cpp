#include <gtest/gtest.h>

#include <cmath>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/metrics/difference.h"

namespace patinate {
namespace {

ImageF noise(int width, int height, std::uint64_t seed) {
  ImageF image(width, height);
  for (std::int64_t i = 0; i < image.num_pixels(); ++i)
    image.data()[i] = static_cast<float>(100.0 * RandomStream(seed, static_cast<std::uint64_t>(i)).uniform());
  return image;
}

/// The equations of the paper, written down for one pixel.
double slow_ssim(const ImageF& a, const ImageF& b, const ImageU8& mask, int x, int y, double range) {
  double n = 0, ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
  const auto each = [&](const auto& use) {
    for (int dy = -5; dy <= 5; ++dy) {
      for (int dx = -5; dx <= 5; ++dx) {
        if (!a.contains(x + dx, y + dy) || !is_inside(mask, x + dx, y + dy)) continue;
        use(std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5)), static_cast<double>(a.at(x + dx, y + dy)),
            static_cast<double>(b.at(x + dx, y + dy)));
      }
    }
  };
  each([&](double w, double u, double v) { n += w, ma += w * u, mb += w * v; });
  ma /= n, mb /= n;
  each([&](double w, double u, double v) {
    va += w * (u - ma) * (u - ma) / n, vb += w * (v - mb) * (v - mb) / n, cov += w * (u - ma) * (v - mb) / n;
  });
  const double c1 = std::pow(0.01 * range, 2), c2 = std::pow(0.03 * range, 2);
  return (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
}

TEST(Ssim, EqualsTheSlowVersionBesideAMaskToo) {
  const ImageF a = noise(24, 19, 1), b = noise(24, 19, 2);
  ImageU8 mask(24, 19, 1, 255);
  for (int y = 4; y < 15; ++y) mask.at(11, y) = mask.at(12, y) = 0;
  const ImageF map = ssim_map(a, b, mask, 100.0);
  for (int y = 0; y < 19; ++y) {
    for (int x = 0; x < 24; ++x) {
      const double expected = mask.at(x, y) == 0 ? 0.0 : slow_ssim(a, b, mask, x, y, 100.0);
      EXPECT_NEAR(static_cast<double>(map.at(x, y)), expected, 1e-6) << x << " " << y;  // Rounding to float.
    }
  }
}

TEST(Ssim, IsOneForEqualImagesAndLuminanceAloneForConstantOnes) {
  const ImageF a = noise(16, 16, 3);
  const ImageF same = ssim_map(a, a, {}, 100.0);
  for (float v : same.values()) EXPECT_FLOAT_EQ(v, 1.0f);
  const ImageF flat = ssim_map(ImageF(8, 8, 1, 20.0f), ImageF(8, 8, 1, 40.0f), {}, 100.0);
  for (float v : flat.values()) EXPECT_NEAR(static_cast<double>(v), (2 * 20 * 40 + 1.0) / (400 + 1600 + 1.0), 1e-6);
  EXPECT_THROW((void)ssim_map(a, ImageF(8, 8), {}, 100.0), InvalidInput);
  EXPECT_THROW((void)ssim_map(a, a, {}, 0.0), InvalidInput);
}

}  // namespace
}  // namespace patinate
