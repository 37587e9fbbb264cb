#include "patinate/controls/noise.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "libcommon/controls/noise_kernel.h"
#include "libcommon/core/hash.h"

namespace patinate {
namespace {

/// Values along a straight line, `step` apart.
std::vector<double> noise_along(const Vec3& from, const Vec3& direction, double step, int count,
                                const NoiseOptions& options, double least_mm = 0.0) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(noise_at(from + i * step * direction, options, least_mm));
  return values;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double deviation_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double sum = 0.0;
  for (const double v : values) sum += (v - mean) * (v - mean);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(Noise, RisesThroughItsMeanOnceAWavelengthInEveryDirection) {
  constexpr int kWavelengths = 4000;
  // Crossings of neighboring wavelengths are nearly independent: 1 / sqrt(4000) = 1.6 %, and 3 of that.
  constexpr double kCounting = 0.05;
  for (const double wavelength : {0.7, 30.0}) {
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0.6, 0, 0.8)}) {
      const std::vector<double> v = noise_along({5, 6, 7}, direction, wavelength / 20, 20 * kWavelengths,
                                                {.wavelength_mm = wavelength, .octaves = 1, .seed = 3});
      int crossings = 0;
      for (std::size_t i = 1; i < v.size(); ++i) crossings += v[i - 1] < 0.5 && v[i] >= 0.5 ? 1 : 0;
      EXPECT_NEAR(static_cast<double>(crossings) / kWavelengths, 1.0, kCounting) << direction.transpose();
    }
  }
}

TEST(Noise, HasItsMeanAndDeviationForAnyNumberOfOctaves) {
  for (const int octaves : {1, 3, 8}) {
    const std::vector<double> v =
        noise_along({0, 0, 0}, {0, 0, 1}, 0.5, 40000, {.wavelength_mm = 1.0, .octaves = octaves});
    EXPECT_NEAR(mean_of(v), 0.5, 0.01) << octaves;  // 3 * 0.2 / sqrt(about 20000 / 4 independent values)
    EXPECT_NEAR(deviation_of(v), 0.2, 0.01) << octaves;
    for (const double x : v) ASSERT_TRUE(x >= 0.0 && x <= 1.0);
  }
}

TEST(Noise, OfOneOctaveIsSmoothBelowItsWavelength) {
  const std::vector<double> v = noise_along({1, 2, 3}, {1, 0, 0}, 0.01, 20000, {.wavelength_mm = 1.0, .octaves = 1});
  double steepest = 0.0;
  for (std::size_t i = 1; i < v.size(); ++i) steepest = std::max(steepest, std::abs(v[i] - v[i - 1]));
  // A sine of deviation 0.2 and this wavelength changes by 0.018 at most; a hash of each place by up to 1.
  EXPECT_LT(steepest, 0.06);
}

TEST(Noise, LeavesOutWhatIsFinerThanAsked) {
  const NoiseOptions fine{.wavelength_mm = 8.0, .octaves = 6};
  const NoiseOptions coarse{.wavelength_mm = 8.0, .octaves = 2};
  const double kShare = std::sqrt((1 + 1.0 / 4) / (1 + 1.0 / 4 + 1.0 / 16 + 1.0 / 64 + 1.0 / 256 + 1.0 / 1024));
  for (int i = 0; i < 100; ++i) {  // 8 and 4 mm are whole at 2 mm, 2 mm and less are gone
    const Vec3 p(0.37 * i, 0.11 * i, 3);
    const double expected = 0.5 + (noise_at(p, coarse) - 0.5) * kShare;
    EXPECT_NEAR(noise_at(p, fine, 2.0), expected, 1e-12);
  }
}

TEST(Noise, OfAnotherSeedIsAnother) {
  const std::vector<double> a =
      noise_along({0, 0, 0}, {1, 0, 0}, 1.0, 20000, {.wavelength_mm = 1.0, .octaves = 1, .seed = 1});
  const std::vector<double> b =
      noise_along({0, 0, 0}, {1, 0, 0}, 1.0, 20000, {.wavelength_mm = 1.0, .octaves = 1, .seed = 2});
  double product = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) product += (a[i] - 0.5) * (b[i] - 0.5);
  EXPECT_NEAR(product / (0.04 * static_cast<double>(a.size())), 0.0, 0.03);  // 4 / sqrt(20000)
}

TEST(Noise, KernelsOfAllInstructionSetsGiveTheSameBits) {
  const NoiseOctave octave{.scale = 0.37, .shift = {11.5, -700.25, 3.0}, .key = 77, .strength = 0.5};
  for (const int count : {1, 7, kNoiseBlock}) {
    std::array<double, kNoiseBlock> x{}, y{}, z{}, expected{};
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      x[k] = 3.7 * i - 50.0, y[k] = -0.11 * i, z[k] = i % 3 == 0 ? 1e8 + i : 0.25 * i * i;
    }
    noise_kernel(InstructionSet::Baseline).add(octave, x.data(), y.data(), z.data(), count, expected.data());
    for (const InstructionSet set : {InstructionSet::Avx2, InstructionSet::Avx512}) {
      if (!has_instruction_set(set)) continue;
      std::array<double, kNoiseBlock> sum{};
      noise_kernel(set).add(octave, x.data(), y.data(), z.data(), count, sum.data());
      EXPECT_EQ(sum, expected) << count;
    }
  }
}

TEST(Noise, OfManyPlacesAtOnceIsThatOfEach) {
  std::vector<Vec3> places;
  for (int i = 0; i < 150; ++i) places.emplace_back(0.9 * i - 40.0, 0.4 * i, 1e3 - i);  // more than two blocks
  std::vector<double> values(places.size());
  const NoiseOptions options{.wavelength_mm = 13.0, .octaves = 4, .seed = 5};
  noise_at(places, options, 2.0, values);
  for (std::size_t i = 0; i < places.size(); ++i) EXPECT_EQ(values[i], noise_at(places[i], options, 2.0)) << i;
}

TEST(Noise, HasTheSameBitsEverywhere) {  // A stored result: no other value is known to the last bit.
  const std::vector<double> v =
      noise_along({-1e5, 3.25, 1e-3}, {0.6, 0, 0.8}, 0.37, 1000, {.wavelength_mm = 5, .octaves = 4});
  EXPECT_EQ(ContentHash().add(std::as_bytes(std::span(v))).hex(), "3219ed7e53848220ffb30a163194f982");
}

}  // namespace
}  // namespace patinate
