#include "analysis/similarity/similarity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "libcommon/core/random.h"
#include "libcommon/image/filters.h"
#include "patinate/history/memory_history.h"
#include "tests/support/test_data.h"

namespace patinate::analysis {
namespace {

/// Linear gray of a lightness: CIELAB (lightness, 0, 0).
float gray(double lightness) { return static_cast<float>(std::pow((lightness + 16.0) / 116.0, 3.0)); }

/// Lightness at a place and a share of the span.
using Lightness = std::function<double(int x, int y, double share)>;

MemoryHistoryImages images_of(int width, int height, int num_frames, const Lightness& lightness) {
  MemoryHistoryImages images{.name = "made", .frames = {}};
  for (int frame = 0; frame < num_frames; ++frame) {
    const double share = num_frames == 1 ? 0.0 : static_cast<double>(frame) / (num_frames - 1);
    ImageF color(width, height, 3);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) color.at(x, y, c) = gray(lightness(x, y, share));
      }
    }
    images.frames.push_back({.time = static_cast<double>(frame), .color = std::move(color)});
  }
  return images;
}

SurfaceDescriptor described(MemoryHistoryImages images) {
  return describe_surface(TextureSeries(std::make_shared<const MemoryHistory>(std::move(images))));
}

/// Lightness noise of a size, of mean 0 and deviation 1.
ImageF grain(int side, double sigma, std::uint64_t seed) {
  ImageF image(side, side);
  for (std::int64_t i = 0; i < image.num_pixels(); ++i)
    image.data()[i] = static_cast<float>(RandomStream(seed, static_cast<std::uint64_t>(i)).normal());
  image = gaussian_blur(image, sigma);
  double squares = 0.0;
  for (const float v : image.values()) squares += static_cast<double>(v) * static_cast<double>(v);
  const auto factor = static_cast<float>(1.0 / std::sqrt(squares / static_cast<double>(image.num_pixels())));
  for (float& v : image.values()) v *= factor;
  return image;
}

/// A material: places darken from `light` by `depth`, each at a time of its own between `first` and `last`.
struct Material {
  double light, depth, size, first, last;
  std::uint64_t seed;
};

MemoryHistoryImages aged(const Material& m, int side) {
  const ImageF structure = grain(side, m.size, m.seed);
  return images_of(side, side, 17, [&](int x, int y, double share) {
    const double place = 0.5 + 0.5 * std::erf(static_cast<double>(structure.at(x, y)) / std::numbers::sqrt2);
    const double onset = m.first + (m.last - m.first) * place;
    return m.light + 4.0 * static_cast<double>(structure.at(x, y)) -
           m.depth * std::clamp((share - onset) / 0.1, 0.0, 1.0);
  });
}

MemoryHistoryImages cropped(MemoryHistoryImages images, int x0, int y0, int side) {
  for (MemoryFrame& frame : images.frames) {
    ImageF part(side, side, 3);
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        for (int c = 0; c < 3; ++c) part.at(x, y, c) = frame.color.at(x0 + x, y0 + y, c);
      }
    }
    frame.color = std::move(part);
  }
  return images;
}

const std::vector<Material>& materials() {
  // Pairs differ in one thing alone: how light, how coarse, how far, or when.
  static const std::vector<Material> kMaterials{{60, 25, 2, 0.1, 0.5, 1}, {75, 25, 2, 0.1, 0.5, 2},
                                                {60, 25, 8, 0.1, 0.5, 3}, {60, 45, 2, 0.1, 0.5, 4},
                                                {60, 25, 2, 0.4, 0.8, 5}, {60, 25, 2, 0.1, 0.2, 6}};
  return kMaterials;
}

TEST(Similarity, EveryQuarterOfAHistoryFindsItsHistoryFirst) {
  std::vector<SurfaceDescriptor> library;
  for (const Material& m : materials()) library.push_back(described(aged(m, 128)));
  for (std::size_t mine = 0; mine < library.size(); ++mine) {
    for (const auto& [x, y] : {std::pair(0, 0), std::pair(64, 0), std::pair(0, 64), std::pair(64, 64)}) {
      const SurfaceDescriptor part = described(cropped(aged(materials()[mine], 128), x, y, 64));
      for (std::size_t other = 0; other < library.size(); ++other) {
        if (other == mine) continue;
        EXPECT_LT(dissimilarity(part, library[mine]).total, dissimilarity(part, library[other]).total)
            << mine << " against " << other << " from " << x << ", " << y;
      }
    }
  }
}

TEST(Similarity, AHistoryIsNoDistanceFromItself) {
  const SurfaceDescriptor a = described(aged(materials()[0], 64));
  const Dissimilarity d = dissimilarity(a, a);
  EXPECT_EQ(d.total, 0.0);
  EXPECT_EQ(d.structure, 0.0);
  EXPECT_EQ(d.rates, 0.0);
}

TEST(Similarity, LighterByTenIsTenDeltaE) {
  // There are as many frames as moments: between frames light is blended, not lightness.
  const auto flat = [](double lightness) {
    return described(images_of(32, 32, 17, [=](int, int, double share) { return lightness - 20.0 * share; }));
  };
  const Dissimilarity d = dissimilarity(flat(60), flat(70));
  EXPECT_NEAR(d.colors, 10.0, 1e-3);  // sliced_distance() of a shift is its length, but for single precision.
  EXPECT_NEAR(*d.rates, 0.0, 1e-4);
}

TEST(Similarity, AgingThatIsLaterByATenthOfTheSpanIsSo) {
  // Lightness is linear while it changes, so that onset and saturation of every place are a tenth later.
  const auto from = [](double onset) {
    return described(images_of(32, 32, 17, [=](int x, int, double share) {
      return 70.0 - 30.0 * std::clamp((share - onset - 0.25 * x / 31.0) / 0.25, 0.0, 1.0);
    }));
  };
  // Moments are a 16th apart, the ends of the ramp in between are rounded off: a quarter of that step.
  EXPECT_NEAR(*dissimilarity(from(0.1), from(0.2)).rates, 0.1, 0.25 / 16);
}

TEST(Similarity, TwiceTheContrastIsTwoOctavesOfPower) {
  const ImageF structure = grain(128, 0.8, 9);  // Power at all frequencies, far above the floor of the logarithm.
  const auto with = [&](double contrast) {
    return described(images_of(
        128, 128, 2, [&](int x, int y, double) { return 60.0 + contrast * static_cast<double>(structure.at(x, y)); }));
  };
  SurfaceDescriptor a = with(2), b = with(4);
  a.pixel_mm = b.pixel_mm = 1.0;                           // Scale is known: nothing slides.
  EXPECT_NEAR(*dissimilarity(a, b).structure, 2.0, 1e-3);  // Single precision.
}

TEST(Similarity, UnknownScaleCostsNothingKnownScaleDoes) {
  // Grain is the same from twice as far.
  const ImageF fine = grain(256, 3, 11);
  const ImageF far = downscale_area(fine, 128, 128);
  const auto of = [](const ImageF& structure) {
    return described(images_of(structure.width(), structure.height(), 2, [&](int x, int y, double) {
      return 60.0 + 6.0 * static_cast<double>(structure.at(x, y));
    }));
  };
  SurfaceDescriptor near_one = of(fine), far_one = of(far);
  const double slid = *dissimilarity(near_one, far_one).structure;
  near_one.pixel_mm = far_one.pixel_mm = 1.0;
  EXPECT_LT(slid, 0.5 * *dissimilarity(near_one, far_one).structure);
}

TEST(Similarity, APhotographFindsItsMoment) {
  const MemoryHistoryImages all = aged(materials()[0], 64);
  MemoryHistoryImages one{.name = "photo", .frames = {}};
  one.frames.push_back({.time = 0.0, .color = all.frames[7].color});
  const Dissimilarity d = dissimilarity(described(one), described(all));
  EXPECT_EQ(d.time, 7.0);
  EXPECT_EQ(d.colors, 0.0);
  EXPECT_FALSE(d.rates);
}

}  // namespace
}  // namespace patinate::analysis
