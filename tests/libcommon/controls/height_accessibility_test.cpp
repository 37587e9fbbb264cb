#include "libcommon/controls/height_accessibility.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

#include "patinate/core/error.h"
#include "tests/libcommon/geometry/shapes.h"

namespace patinate {
namespace {

constexpr double kAmplitude = 1.0, kPeriod = 12.0, kSide = 48.0;
constexpr double kWaveNumber = 2.0 * std::numbers::pi / kPeriod;

/// Furrows along y.
Mesh furrows() {
  return testing_support::make_patch(192, 24, [](double u, double v) {
    const double x = kSide * (u - 0.5), y = kSide * (v - 0.5);
    return Vec3(x, y, kAmplitude * std::cos(kWaveNumber * x));
  });
}

HeightAccessibilityOptions fine() {
  HeightAccessibilityOptions options;
  options.scale_mm = 0.5;
  options.resolution = 192;
  options.ray_share.num_rays = 64;
  return options;
}

double at(const HeightAccessibility& found, std::size_t k, const Vec3& p) {
  return sample_field(found.field, found.definitions[k].values, p).value();
}

TEST(HeightAccessibility, BottomsAndCrestsOfFurrowsHaveTheirClosedForms) {
  const HeightAccessibility found = height_accessibility(furrows(), Vec3::UnitZ(), fine());
  // The radius of curvature is 1 / (A k^2): a cylinder, so half of that is the mean curvature; the largest sphere at
  // the bottom has that radius.
  const double bend = kAmplitude * kWaveNumber * kWaveNumber;
  const Vec3 bottom(0.5 * kPeriod, 0.0, 0.0), crest(0.0, 0.0, 0.0);
  constexpr double kDiscretization = 0.05;  // Smoothing 0.5 mm takes 1 - exp(-(k s)^2 / 2) = 3.4 % of the curvature.
  EXPECT_NEAR(at(found, 0, bottom) / (0.5 * bend), 1.0, kDiscretization);
  EXPECT_NEAR(at(found, 0, crest) / (-0.5 * bend), 1.0, kDiscretization);
  EXPECT_NEAR(at(found, 2, bottom) / bend, 1.0,
              0.1);  // The points that stop the sphere are 0.4 % of the diagonal apart.
  EXPECT_GT(at(found, 1, bottom), at(found, 1, crest) + 0.02);
  EXPECT_LT(found.definitions[0].low, 0.0);
  EXPECT_GT(found.definitions[0].high, 0.0);
}

TEST(HeightAccessibility, TheThreeDefinitionsAgreeOnFurrows) {
  const HeightAccessibility found = height_accessibility(furrows(), Vec3::UnitZ(), fine());
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_EQ(found.correlation[a][a], 1.0);
    for (std::size_t b = 0; b < 3; ++b) {
      EXPECT_EQ(found.correlation[a][b], found.correlation[b][a]);
      EXPECT_GT(found.correlation[a][b],
                0.6);  // All rise from crest to bottom; ties where rays and spheres see nothing.
    }
  }
}

TEST(HeightAccessibility, TurnsWithTheObjectAndItsViewer) {
  const HeightAccessibility straight = height_accessibility(furrows(), Vec3::UnitZ(), fine());
  Mesh turned = furrows();
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Vec3& p : turned.positions) p = rotation * p;
  const HeightAccessibility found = height_accessibility(turned, rotation * Vec3::UnitZ(), fine());
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(3, 5, 0), Vec3(6, -4, 0), Vec3(-7.5, 2, 0)}) {
    EXPECT_NEAR(at(found, 0, rotation * p), at(straight, 0, p), 0.005);  // Another grid: a fifth of the smoothing.
  }
}

TEST(HeightAccessibility, APlaneIsEven) {
  const HeightAccessibility found = height_accessibility(
      testing_support::make_patch(4, 4, [](double u, double v) { return Vec3(20 * u, 20 * v, 3 * u); }), Vec3::UnitZ(),
      fine());
  for (float v : found.definitions[0].values.values()) EXPECT_NEAR(static_cast<double>(v), 0.0, 1e-6);
  EXPECT_GE(found.definitions[0].high - found.definitions[0].low, 0.001 / 0.5 - 1e-12);
}

TEST(HeightAccessibility, OptionsOutOfRangeAreRefused) {
  HeightAccessibilityOptions options = fine();
  options.resolution = 5;
  EXPECT_THROW((void)height_accessibility(furrows(), Vec3::UnitZ(), options), InvalidInput);
  options = fine();
  options.scale_mm = 0.01;  // Far below the distance of heights.
  EXPECT_THROW((void)height_accessibility(furrows(), Vec3::UnitZ(), options), InvalidInput);
}

}  // namespace
}  // namespace patinate
