#include "analysis/fit/place_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libcommon/core/random.h"
#include "tests/support/errors.h"

namespace patinate::analysis {
namespace {

using testing_support::error_of;
using testing_support::has;

constexpr int kSide = 16, kLevels = 9, kTimes = 6;
constexpr double kDecades = 100.0;  // The rate's range is 0.02 to 2 a day, logarithmic.

/// A place ages along a line in CIELAB: share 1 - exp(-rate t) of 40 L* and 20 a*, at days 0 to 5.
std::vector<float> colors_at(double unit) {
  const double rate = 0.02 * std::pow(kDecades, unit);
  std::vector<float> out;
  for (int t = 0; t < kTimes; ++t) {
    const double share = 1.0 - std::exp(-rate * t);
    out.insert(out.end(), {static_cast<float>(30.0 + 40.0 * share), static_cast<float>(20.0 * share), 0.0F});
  }
  return out;
}

/// Levels over the whole range; captured with `truth` and normal noise.
FieldColors colors_of(const PlaceField& truth, double noise, std::uint64_t seed) {
  FieldColors colors;
  constexpr std::size_t n = kSide * kSide;
  colors.num_times = kTimes;
  const auto put = [&](std::vector<float>& list, std::size_t place, const std::vector<float>& values) {
    list.resize(3 * kTimes * n);
    for (std::size_t t = 0; t < kTimes; ++t) {
      for (std::size_t c = 0; c < 3; ++c) list[3 * (t * n + place) + c] = values[3 * t + c];
    }
  };
  for (std::size_t i = 0; i < n; ++i)
    colors.places.push_back(
        {(static_cast<double>(i % kSide) + 0.5) / kSide, (static_cast<double>(i / kSide) + 0.5) / kSide});
  for (int k = 0; k < kLevels; ++k) {
    const double unit = k / (kLevels - 1.0);
    colors.levels.emplace_back();
    colors.values.emplace_back(n, static_cast<float>(unit));
    for (std::size_t i = 0; i < n; ++i) put(colors.levels.back(), i, colors_at(unit));
  }
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<float> values = colors_at(truth.at(colors.places[i][0], colors.places[i][1]));
    RandomStream random(seed, i);
    for (float& v : values) v += static_cast<float>(noise * random.normal());
    put(colors.captured, i, values);
  }
  return colors;
}

/// Root mean square difference of two fields.
double field_difference(const PlaceField& a, const PlaceField& b, const FieldColors& colors) {
  double sum = 0.0;
  for (const auto& [x, y] : colors.places) sum += std::pow(a.at(x, y) - b.at(x, y), 2);
  return std::sqrt(sum / static_cast<double>(colors.places.size()));
}

PlaceField bent() {
  PlaceField truth{.num_waves = 3, .coefficients = std::vector<double>(9)};
  truth.coefficients = {0.55, 0.15, 0.0, -0.12, 0.06, 0.0, 0.05, 0.0, 0.0};
  return truth;
}

TEST(PlaceField, BendingIsTheMeanSquareOfTheCurvatureOfThePlate) {
  const PlaceField field = bent();
  constexpr int kSteps = 400;
  constexpr double h = 1.0 / kSteps;
  double sum = 0.0;
  for (int y = 0; y < kSteps; ++y) {
    for (int x = 0; x < kSteps; ++x) {
      const double u = (x + 0.5) * h, v = (y + 0.5) * h;
      const double laplacian =
          (field.at(u + h, v) + field.at(u - h, v) + field.at(u, v + h) + field.at(u, v - h) - 4.0 * field.at(u, v)) /
          (h * h);
      sum += laplacian * laplacian * h * h;
    }
  }
  const double expected = bending(field);
  // Second differences of waves of 2 pi / h are off by (2 pi h)^2 / 12.
  EXPECT_NEAR(sum / std::pow(std::numbers::pi, 4), expected, expected * std::pow(2.0 * std::numbers::pi * h, 2));
}

TEST(PlaceField, AKnownFieldIsFoundAgain) {
  const FieldColors colors = colors_of(bent(), 0.0, 1);
  const FittedField found = fit_place_field(colors, {});
  ASSERT_TRUE(found.smoothness.has_value());
  // Colors between levels are read along chords, which are off by h^2 / 8 of the second derivative: for 1 - exp(-r t)
  // of r = 0.02 x 100^u that is h^2 / 8 ln(100) |r t - 1| of the first, with r t up to 4 where it still changes.
  constexpr double h = 1.0 / (kLevels - 1);
  EXPECT_LT(field_difference(found.field, bent(), colors), h * h / 8.0 * std::log(kDecades) * 3.0);
  EXPECT_LT(found.misfit, 0.1 * found.flat_misfit);
}

TEST(PlaceField, NoiseMovesAFieldByNoMoreThanItsNumbersAllow) {
  constexpr double kNoise = 4.0;
  const FieldColors colors = colors_of(bent(), kNoise, 2);
  const FittedField found = fit_place_field(colors, {});
  // Information of a place about its value, the least over the surface: of p numbers the variance is p over N of it.
  double least = 1e300;
  for (const auto& [x, y] : colors.places) {
    const double unit = bent().at(x, y);
    const std::vector<float> low = colors_at(unit - 1e-3), high = colors_at(unit + 1e-3);
    double information = 0.0;
    for (std::size_t k = 0; k < low.size(); ++k)
      information += std::pow((static_cast<double>(high[k]) - static_cast<double>(low[k])) / 2e-3 / kNoise, 2);
    least = std::min(least, information);
  }
  constexpr double kNumbers = 36.0, kPlaces = kSide * kSide, h = 1.0 / (kLevels - 1);
  const double by_chance = std::sqrt(kNumbers / (kPlaces * least));
  EXPECT_LT(field_difference(found.field, bent(), colors), 3.0 * by_chance + h * h / 8.0 * std::log(kDecades) * 3.0);
  EXPECT_LT(found.num_effective, kNumbers);
  EXPECT_GT(found.num_effective, 4.0);  // Four waves of the truth are large.
}

TEST(PlaceField, OfASurfaceThatAgesAlikeEverywhereItStaysAlmostOneNumber) {
  constexpr double kNoise = 4.0;
  const PlaceField flat{.num_waves = 1, .coefficients = {0.6}};
  const FieldColors colors = colors_of(flat, kNoise, 3);
  const FittedField found = fit_place_field(colors, {});
  EXPECT_NEAR(found.flat_value, 0.6, 0.02);
  EXPECT_LT(field_difference(found.field, flat, colors), 0.02);
  // Gain of a field on noise: of the sum of squares as many variances as it has numbers.
  const double residuals = 3.0 * kTimes * kSide * kSide;
  EXPECT_GT(found.misfit * found.misfit, found.flat_misfit * found.flat_misfit * (1.0 - 2.0 * 36.0 / residuals));
}

TEST(PlaceField, BlocksThatAreLeftOutDecideBetweenSmoothAndBent) {
  const FittedField found = fit_place_field(colors_of(bent(), 2.0, 4), {});
  ASSERT_EQ(found.trials.size(), 6u);
  EXPECT_FALSE(found.trials.front().smoothness.has_value());
  for (const SmoothnessTrial& t : found.trials) EXPECT_GE(t.left_out, found.misfit);
  const auto taken = std::find_if(found.trials.begin(), found.trials.end(),
                                  [&](const SmoothnessTrial& t) { return t.smoothness == found.smoothness; });
  for (const SmoothnessTrial& t : found.trials) EXPECT_LE(taken->left_out, t.left_out);
  EXPECT_LT(taken->left_out, 0.5 * found.trials.front().left_out);
}

TEST(PlaceField, ListsThatDoNotFitAreRefused) {
  FieldColors colors = colors_of(bent(), 0.0, 1);
  EXPECT_TRUE(has(error_of([&] { (void)fit_place_field(colors, {.num_waves = 17}); }), "waves"));
  EXPECT_TRUE(has(error_of([&] { (void)fit_place_field(colors, {.smoothness = {0.0}}); }), "bending"));
  colors.levels.pop_back();
  EXPECT_TRUE(has(error_of([&] { (void)fit_place_field(colors, {}); }), "two levels"));
}

}  // namespace
}  // namespace patinate::analysis
