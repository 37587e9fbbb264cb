#include "patinate/controls/wood_grain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace patinate {
namespace {

constexpr WoodGrainOptions kClear{.ring_mm = 5.0, .waviness = 0.0, .knots_per_meter = 0.0};
const Board kBoard{.half_width_mm = 60.0, .number = 7};

std::vector<double> grain_along(const Vec3& direction, double step, int count, const WoodGrainOptions& options,
                                const Board& board = kBoard, double least_mm = 0.0) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i)
    values.push_back(wood_grain_at(board.middle_mm + i * step * direction, board, options, least_mm));
  return values;
}

double mean_change(const std::vector<double>& v) {
  double sum = 0.0;
  for (std::size_t i = 1; i < v.size(); ++i) sum += std::abs(v[i] - v[i - 1]);
  return sum / static_cast<double>(v.size() - 1);
}

TEST(WoodGrain, IsLongInTheTrunksDirection) {
  // The pith is up to 1 degree off: a ring is left after 5 / tan(1 degree) = 286 mm at the earliest, where it is 5 mm
  // across; fibers are 50 times as long as wide. What changes in a step across changes a tenth of that along.
  const double across = mean_change(grain_along({0, 1, 0}, 0.5, 2000, {}));
  EXPECT_LT(mean_change(grain_along({1, 0, 0}, 0.5, 2000, {})), 0.1 * across);
  EXPECT_LT(mean_change(grain_along({0, 1, 0}, 0.5, 2000, {}, {.along = Vec3::UnitY(), .half_width_mm = 60.0})),
            0.1 * across);
}

TEST(WoodGrain, HasARingAYear) {
  // Away from the pith, along a radius, rings that do not stray fall to their light wood once in ring_mm; on another
  // line they are wider. Straight away from anywhere the radius grows by the length in the end.
  constexpr int kSteps = 200000;
  const std::vector<double> v = grain_along({0, 0.6, 0.8}, 0.05, kSteps, kClear);
  int falls = 0;
  for (std::size_t i = 8; i < v.size(); i += 8) falls += v[i] < v[i - 8] - 0.2 ? 1 : 0;  // 0.4 mm is a fall's width
  const double rings = 0.05 * kSteps / kClear.ring_mm;
  // It begins within 2.2 sqrt(2) half widths of the pith: at most twice that is lost in going around it. A fall may
  // be shared by two steps, and is then 0.1 of at least 0.5 less steep than a whole one in either: none counts twice
  // unless it is 0.4 high, and few do.
  EXPECT_GT(falls, rings - 2 * 187 / kClear.ring_mm - 0.1 * rings);
  EXPECT_LT(falls, 1.3 * rings);
}

TEST(WoodGrain, OfAnotherBoardOrSeedIsCutElsewhere) {
  const std::vector<double> one = grain_along({0, 1, 0}, 1.0, 400, {});
  const std::vector<double> other_board = grain_along({0, 1, 0}, 1.0, 400, {}, {.half_width_mm = 60.0, .number = 8});
  const std::vector<double> other_seed = grain_along({0, 1, 0}, 1.0, 400, {.seed = 2});
  int equal = 0;
  for (std::size_t i = 0; i < one.size(); ++i) equal += one[i] == other_board[i] || one[i] == other_seed[i] ? 1 : 0;
  EXPECT_LT(equal, 40);
}

TEST(WoodGrain, MovesWithItsBoard) {
  const Board moved{.middle_mm = {1024, -512, 256}, .half_width_mm = 60.0, .number = 7};
  const std::vector<double> here = grain_along({0.5, 0.5, 0.25}, 1.0, 200, {});
  EXPECT_EQ(here, grain_along({0.5, 0.5, 0.25}, 1.0, 200, {}, moved));  // sums of such numbers are exact
}

TEST(WoodGrain, LosesItsRingsButNotItsMeanWhereTexelsAreCoarse) {
  const auto mean_of = [](const std::vector<double>& v) {
    double sum = 0.0;
    for (const double x : v) sum += x;
    return sum / static_cast<double>(v.size());
  };
  const std::vector<double> fine = grain_along({0, 0.6, 0.8}, 0.7, 6000, kClear);
  const std::vector<double> coarse = grain_along({0, 0.6, 0.8}, 0.7, 6000, kClear, kBoard, 20.0);
  // 840 rings of a random height: 0.8 * 0.375 * 0.14 / sqrt(840), and the fibers' mean.
  EXPECT_NEAR(mean_of(fine), mean_of(coarse), 0.03);
  EXPECT_LT(mean_change(coarse), 0.1 * mean_change(fine));
}

TEST(WoodGrain, BendsAroundKnotsAndIsAsItWasAwayFromThem) {
  const auto changed = [](double knots) {
    int count = 0;
    for (int x = -100; x < 100; ++x) {
      for (int y = -10; y < 10; ++y) {
        const Vec3 p(10.0 * x, 6.0 * y, 60.0);
        count +=
            wood_grain_at(p, kBoard, {.knots_per_meter = knots}) == wood_grain_at(p, kBoard, {.knots_per_meter = 0})
                ? 0
                : 1;
      }
    }
    return count / 4000.0;
  };
  EXPECT_EQ(changed(0), 0.0);
  EXPECT_GT(changed(20), 0.005);  // 40 branches, of which few reach this face
  EXPECT_LT(changed(20), 0.9);
}

TEST(WoodGrain, IsWithinItsRangeFarAway) {
  for (const double v : grain_along({0.6, 0, 0.8}, 1e5, 1000, {})) ASSERT_TRUE(v >= 0.0 && v <= 1.0);
}

}  // namespace
}  // namespace patinate
