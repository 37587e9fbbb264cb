#include "analysis/grading/relief_marks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "analysis/grading/region_figures.h"
#include "libcommon/core/random.h"

namespace patinate::analysis {
namespace {

constexpr int kSize = 200;
constexpr double kPixel_mm = 0.1;

/// A coating with a blister (a cap 0.2 mm high and 3 mm wide) and a flake (4 x 2 mm of 0.08 mm) on a tilted panel.
struct DrawnRelief {
  double noise_mm = 0.002;
  bool has_blister = true, has_flake = true;
  double tilt = 0.001;  ///< mm a pixel: 0.2 mm from side to side, as much as the blister is high.

  static constexpr double kRadius_px = 15.0, kHeight_mm = 0.2, kDepth_mm = 0.08;

  [[nodiscard]] ImageF heights(std::uint64_t seed) const {
    ImageF out(kSize, kSize);
    RandomStream random(seed, 0, 0);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        double h = tilt * x - 0.5 * tilt * y + 5.0;
        const double r = std::hypot(x - 60.3, y - 70.8) / kRadius_px;
        if (has_blister && r < 1.0) h += kHeight_mm * (1.0 - r * r);
        if (has_flake && x >= 120 && x < 160 && y >= 100 && y < 120) h -= kDepth_mm;
        const double normal =
            std::sqrt(-2.0 * std::log(1.0 - random.uniform())) * std::cos(2.0 * std::numbers::pi * random.uniform());
        out.at(x, y) = static_cast<float>(h + noise_mm * normal);
      }
    }
    return out;
  }
};

const ImageU8 kAll(kSize, kSize, 1, 255);
const ImageF kFlat(kSize, kSize);

ReliefMarks marks_of(const DrawnRelief& relief, ReliefKind kind) {
  const ImageF before = DrawnRelief{relief.noise_mm, false, false, 0.0}.heights(7);
  return find_relief_marks(height_change(before, relief.heights(8), kAll), kAll, kind);
}

TEST(ReliefMarks, ABlisterHasTheAreaOfItsCap) {
  for (const double noise : {0.0005, 0.002, 0.005}) {
    const ReliefMarks found = marks_of({.noise_mm = noise}, ReliefKind::Blister);
    ASSERT_EQ(found.marks.size(), 1u) << noise;
    const double area = std::numbers::pi * DrawnRelief::kRadius_px * DrawnRelief::kRadius_px;
    EXPECT_NEAR(found.marks[0].area_px, area, found.marks[0].uncertain_px) << noise;
    EXPECT_LT(found.marks[0].uncertain_px, 0.15 * area) << noise;
  }
}

TEST(ReliefMarks, AFlakeHasItsAreaAndItsLongestSide) {
  const ReliefMarks found = marks_of({}, ReliefKind::Flake);
  ASSERT_EQ(found.marks.size(), 1u);
  EXPECT_NEAR(found.marks[0].area_px, 800.0, found.marks[0].uncertain_px);
  EXPECT_NEAR(found.marks[0].longest_px, 40.0, 1.0);
}

TEST(ReliefMarks, AreNoneOnASoundCoatingThatTilts) {
  const DrawnRelief sound{.noise_mm = 0.005, .has_blister = false, .has_flake = false};
  EXPECT_TRUE(marks_of(sound, ReliefKind::Blister).marks.empty());
  EXPECT_TRUE(marks_of(sound, ReliefKind::Flake).marks.empty());
}

TEST(RegionFigures, OfReliefAreSharesOfTheRegionAndSizes) {
  const ReliefMarks blisters = marks_of({}, ReliefKind::Blister), flakes = marks_of({}, ReliefKind::Flake);
  RegionFigures figures;
  add_relief_figures(blisters, flakes, kFlat, kAll, kPixel_mm, figures);
  const double blistered = 100.0 * std::numbers::pi * 15.0 * 15.0 / (kSize * kSize);
  EXPECT_LE(figures.figure("blistered_percent")->low, blistered);
  EXPECT_GE(figures.figure("blistered_percent")->high, blistered);
  EXPECT_NEAR(figures.figure("blister_mm")->value, 3.0, kPixel_mm);
  EXPECT_NEAR(figures.figure("flaked_percent")->value, 2.0, 0.1);
  EXPECT_NEAR(figures.figure("flake_mm")->value, 4.0, kPixel_mm);
  // The left half holds the blister alone.
  ImageU8 left = kAll;
  for (int y = 0; y < kSize; ++y) {
    for (int x = kSize / 2; x < kSize; ++x) left.at(x, y) = 0;
  }
  RegionFigures of_left;
  add_relief_figures(blisters, flakes, kFlat, left, kPixel_mm, of_left);
  EXPECT_EQ(of_left.figure("flaked_percent")->value, 0.0);
  EXPECT_NEAR(of_left.figure("blistered_percent")->value, 2.0 * figures.figure("blistered_percent")->value, 1e-9);
}

TEST(RegionFigures, APileOfRustIsNoBlister) {
  ImageF rust = kFlat;
  for (float& v : rust.values()) v = 1.0f;
  RegionFigures figures;
  add_relief_figures(marks_of({}, ReliefKind::Blister), marks_of({}, ReliefKind::Flake), rust, kAll, kPixel_mm,
                     figures);
  EXPECT_EQ(figures.figure("blistered_percent")->value, 0.0);
  EXPECT_GT(figures.figure("flaked_percent")->value, 0.0);
}

}  // namespace
}  // namespace patinate::analysis
