// Planted truths on a sphere of radius 100 mm: random fields of known range as candidates, and references made of them
// or of nothing.
#include "analysis/explanation/explanation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "analysis/explanation/ranks.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/support/threads.h"

namespace patinate::analysis {
namespace {

constexpr double kRadius_mm = 100.0;

/// Evenly spread over the sphere (Fibonacci's spiral), so that each stands for as much of it.
std::vector<Vec3> sphere(int count) {
  std::vector<Vec3> points;
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double y = 1.0 - 2.0 * (i + 0.5) / count, r = std::sqrt(1.0 - y * y);
    points.emplace_back(kRadius_mm * Vec3(r * std::cos(turn * i), y, r * std::sin(turn * i)));
  }
  return points;
}

/// A Gaussian random field of covariance exp(-d^2 / (2 width^2)), brought into [0, 1] by its least and greatest. A
/// width of 0 gives independent places.
std::vector<double> field(const std::vector<Vec3>& points, double width_mm, std::uint64_t seed) {
  RandomStream random(seed, 77);
  std::vector<double> values(points.size());
  for (int wave = 0; wave < 80 && width_mm > 0.0; ++wave) {
    const Vec3 k = Vec3(random.normal(), random.normal(), random.normal()) / width_mm;
    const double phase = 2.0 * std::numbers::pi * random.uniform();
    for (std::size_t i = 0; i < points.size(); ++i) values[i] += std::cos(k.dot(points[i]) + phase);
  }
  if (width_mm == 0.0)
    for (double& v : values) v = random.normal();
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  const double low = *least, high = *greatest;
  for (double& v : values) v = (v - low) / (high - low);
  return values;
}

/// Candidates as wide as controls are: from crevices to height.
ExplanationInput surface(int count, std::uint64_t seed) {
  ExplanationInput input{.positions_mm = sphere(count),
                         .area_mm2 = 4.0 * std::numbers::pi * kRadius_mm * kRadius_mm,
                         .reference = {},
                         .candidates = {}};
  const std::vector<double> widths{8.0, 12.0, 20.0, 30.0, 10.0, 50.0, 80.0};
  for (std::size_t i = 0; i < widths.size(); ++i)
    input.candidates.push_back(
        {std::string(1, static_cast<char>('a' + i)), field(input.positions_mm, widths[i], 1000 * seed + i)});
  input.candidates.push_back({"up", {}});
  for (const Vec3& p : input.positions_mm) input.candidates.back().values.push_back(0.5 + p.y() / (2.0 * kRadius_mm));
  return input;
}

double deviation(const std::vector<double>& values) {
  double sum = 0.0, squares = 0.0;
  for (const double v : values) sum += v, squares += v * v;
  const auto n = static_cast<double>(values.size());
  return std::sqrt(squares / n - sum / n * (sum / n));
}

const ExplainedCandidate& find(const Explanation& e, const std::string& name) {
  for (const ExplainedCandidate& c : e.candidates)
    if (c.name == name) return c;
  throw InvalidInput("no " + name);
}

constexpr ExplanationOptions kQuick{.num_samples = 3000, .resamples = 60, .shuffles = 199};

TEST(Explanation, AMixOfTwoIsFoundWithItsWeightsUnderNoise) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ExplanationInput input = surface(6000, seed);
    const auto &a = input.candidates[0].values, &c = input.candidates[2].values;
    const std::vector<double> noise = field(input.positions_mm, 15.0, 500 + seed);
    input.reference.resize(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) input.reference[i] = 0.7 * a[i] + 0.3 * (1.0 - c[i]);
    // Noise of half the deviation: four fifths of the variance are the mix's.
    const double scale = 0.5 * deviation(input.reference) / deviation(noise);
    for (std::size_t i = 0; i < a.size(); ++i) input.reference[i] += scale * noise[i];
    const Explanation found = explain(input, {.num_samples = 6000, .resamples = 60, .shuffles = 199}, 1);
    ASSERT_EQ(found.mix.members.size(), 2U) << found.mix.expression;
    EXPECT_EQ(found.mix.members[0].candidate, 0U);
    EXPECT_FALSE(found.mix.members[0].is_inverse);
    EXPECT_EQ(found.mix.members[1].candidate, 2U);
    EXPECT_TRUE(found.mix.members[1].is_inverse);
    // About 100 independent places: a slope's standard error is sqrt(0.2 / 0.8 / 100) = 0.05 of the larger one, and
    // twice that is 0.1 of weights that sum to 1.
    EXPECT_NEAR(found.mix.members[0].weight, 0.7, 0.1) << "seed " << seed;
    EXPECT_TRUE(found.mix.figures.explains);
    // For Gaussian fields the rank correlation is (6 / pi) asin(r / 2), r = sqrt(0.8): 0.885; 100 places: +- 0.05.
    EXPECT_NEAR(found.mix.figures.correlation, 0.885, 0.05);
    EXPECT_NEAR(found.mix.left_out_correlation, 0.885, 0.07);
  }
}

TEST(Explanation, NoiseIsCalledNothing) {
  // Widths from none to a third of the radius. Of 100 seeds at a family-wise level of 5 % fewer than 10 are expected to
  // be called with a probability of 0.97.
  int called = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    ExplanationInput input = surface(2500, seed);
    const double width = std::vector<double>{0.0, 5.0, 10.0, 20.0, 30.0}[seed % 5];
    input.reference = field(input.positions_mm, width, 9000 + seed);
    const Explanation found = explain(input, kQuick, seed);
    bool any = found.mix.figures.explains;
    for (const ExplainedCandidate& c : found.candidates) any = any || c.figures.explains;
    called += any ? 1 : 0;
  }
  RecordProperty("called", called);
  EXPECT_LE(called, 10);
}

TEST(Explanation, IntervalsHoldTheTruthAsOftenAsTheySay) {
  // a against 0.6 a + noise of its own width: over a large surface the rank correlation of such Gaussian fields is
  // known.
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    ExplanationInput input = surface(2500, seed);
    input.candidates.resize(1);
    const auto& a = input.candidates[0].values;
    const std::vector<double> noise = field(input.positions_mm, 8.0, 300 + seed);
    for (std::size_t i = 0; i < a.size(); ++i)
      input.reference.push_back(0.6 * a[i] / deviation(a) + 0.8 * noise[i] / deviation(noise));
    const double truth = 6.0 / std::numbers::pi * std::asin(0.3);
    const ExplanationFigures f =
        explain(input, {.num_samples = 2500, .resamples = 100, .shuffles = 99}, seed).candidates[0].figures;
    ASSERT_TRUE(f.low && f.high);
    held += *f.low <= truth && truth <= *f.high ? 1 : 0;
  }
  RecordProperty("held", held);
  EXPECT_GE(held, 88);  // 95 of 100 less three standard deviations, sqrt(100 * 0.95 * 0.05) each.
}

TEST(Explanation, TheSignAndTheOrderAreThoseOfTheData) {
  ExplanationInput input = surface(3000, 3);
  for (const double v : input.candidates[1].values) input.reference.push_back(std::exp(-5.0 * v));
  const Explanation found = explain(input, kQuick, 1);
  EXPECT_EQ(found.candidates[0].name, "b");
  EXPECT_DOUBLE_EQ(found.candidates[0].figures.correlation, -1.0);
  EXPECT_EQ(found.mix.expression, "!b");
  EXPECT_DOUBLE_EQ(found.mix.figures.correlation, 1.0);
  EXPECT_EQ(found.mix.figures.p, found.candidates[0].figures.p);
  EXPECT_TRUE(found.candidates[0].figures.explains);
}

TEST(Explanation, AnEvenCandidateExplainsNothingAndIsSaidToBeEven) {
  ExplanationInput input = surface(1000, 4);
  input.reference = input.candidates[0].values;
  input.candidates[1].values.assign(1000, 0.25);
  const Explanation found = explain(input, kQuick, 1);
  EXPECT_TRUE(find(found, "b").is_even);
  EXPECT_FALSE(find(found, "b").figures.explains);
  EXPECT_EQ(found.candidates.back().name, "b");
}

TEST(Explanation, AConstantReferenceIsRefused) {
  ExplanationInput input = surface(1000, 5);
  input.reference.assign(1000, 0.5);
  EXPECT_THROW((void)explain(input, kQuick, 1), InvalidInput);
}

TEST(Explanation, TooFewShufflesToCallAnythingAreRefused) {
  ExplanationInput input = surface(1000, 5);
  input.reference = input.candidates[0].values;
  ExplanationOptions few = kQuick;
  few.shuffles = 99;  // The least p is 0.01; of 8 candidates the corrected one is 0.08.
  EXPECT_THROW((void)explain(input, few, 1), InvalidInput);
}

TEST(Explanation, TheNumberOfThreadsChangesNothing) {
  ExplanationInput input = surface(1000, 6);
  input.reference = field(input.positions_mm, 10.0, 17);
  const Explanation one = explain(input, kQuick, 1, testing_support::with_threads(1)),
                    many = explain(input, kQuick, 1, testing_support::with_threads(5));
  EXPECT_EQ(one.candidates[0].figures.p, many.candidates[0].figures.p);
  EXPECT_EQ(one.candidates[0].figures.low, many.candidates[0].figures.low);
  EXPECT_EQ(one.mix.figures.p, many.mix.figures.p);
  EXPECT_EQ(one.range_mm, many.range_mm);
}

TEST(SurfaceBlocks, TheRangeOfAFieldIsWhereItsCovarianceFallsToATenth) {
  const std::vector<Vec3> points = sphere(4000);
  const Correlograms found = correlograms(points, {field(points, 20.0, 4), field(points, 0.0, 4)});
  // exp(-d^2 / (2 w^2)) = 0.1 at d = 2.15 w. One field of some 50 places, and steps of 1.6 mm: within 25 %.
  EXPECT_NEAR(found.range_mm(0), 43.0, 11.0);
  // 2,000 places lie sqrt(125,664 / 2,000) = 7.9 mm apart: nothing nearer is seen.
  EXPECT_LT(found.range_mm(1), 8.0);
}

TEST(SurfaceBlocks, TheVarianceOfChanceIsThatOfUnrelatedFields) {
  // Correlations of 200 pairs of fields against what is forecast from each pair alone.
  const std::vector<Vec3> points = sphere(1000);
  double seen = 0.0, forecast = 0.0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const std::vector<double> a = field(points, 15.0, 2 * seed), b = field(points, 25.0, 2 * seed + 1);
    const double r = weighted_correlation(a, b);
    seen += r * r / 200.0;
    forecast += correlograms(points, {a, b}).chance_variance(0, 1, points.size()) / 200.0;
  }
  // The variance of 200 squares is known to sqrt(2 / 200) = 10 %; 3 standard errors.
  EXPECT_NEAR(forecast / seen, 1.0, 0.3);
}

}  // namespace
}  // namespace patinate::analysis
