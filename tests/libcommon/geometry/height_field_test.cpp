#include "libcommon/geometry/height_field.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "patinate/core/error.h"

namespace patinate {
namespace {

/// A field of a formula, centered.
HeightField field_of(int size, double spacing_mm, const std::function<double(double, double)>& height) {
  HeightField field;
  field.height_mm = Image<double>(size, size);
  field.seen = ImageU8(size, size, 1, 255);
  field.spacing_mm = spacing_mm;
  const double half = 0.5 * (size - 1) * spacing_mm;
  field.origin = Vec3(-half, half, 0.0);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) field.height_mm.at(x, y) = height(x * spacing_mm - half, half - y * spacing_mm);
  }
  return field;
}

double at_center(const HeightField& field, double width_mm) {
  return sample_field(field, height_curvature(field, width_mm), Vec3::Zero()).value();
}

constexpr double kRadius = 20.0;
double cap(double x, double y) { return std::sqrt(kRadius * kRadius - x * x - y * y); }

// The formula's own values. With a width of 0.4 mm the smoothing itself costs about 2 (width / R)^2 = 8e-4.
constexpr double kSmoothing = 2e-3;

TEST(HeightCurvature, IsMinusOneOverTheRadiusOnACapAndPlusInAPit) {
  const auto pit = [](double x, double y) { return -cap(x, y); };
  EXPECT_NEAR(at_center(field_of(41, 0.2, cap), 0.4) * kRadius, -1.0, kSmoothing);
  EXPECT_NEAR(at_center(field_of(41, 0.2, pit), 0.4) * kRadius, 1.0, kSmoothing);
}

TEST(HeightCurvature, IsTheSameOnACapThatIsSeenFromAside) {
  // 8 mm beside the pole of a sphere: the slope is 0.44, the curvature the same.
  const auto aside = [](double x, double y) { return cap(x + 8.0, y); };
  EXPECT_NEAR(at_center(field_of(41, 0.2, aside), 0.4) * kRadius, -1.0, kSmoothing);
}

TEST(HeightCurvature, IsHalfOnACylinderAndNothingOnASlope) {
  const auto cylinder = [](double x, double y) {
    const double across = 0.6 * x + 0.8 * y;
    return std::sqrt(kRadius * kRadius - across * across);
  };
  EXPECT_NEAR(at_center(field_of(41, 0.2, cylinder), 0.4) * kRadius, -0.5, kSmoothing);
  const HeightField slope = field_of(41, 0.2, [](double x, double y) { return 0.7 * x - 1.3 * y + 5.0; });
  const ImageF on_slope = height_curvature(slope, 0.4);
  for (float v : on_slope.values()) EXPECT_NEAR(static_cast<double>(v), 0.0, 1e-9);  // Rounding.
}

TEST(HeightCurvature, ErrorFallsWithTheSquareOfTheSpacing) {
  std::vector<double> errors;
  for (int k = 0; k < 3; ++k) {
    const double spacing = 1.0 / (1 << k);
    errors.push_back(std::abs(at_center(field_of(21, spacing, cap), 2.0 * spacing) * kRadius + 1.0));
  }
  for (std::size_t k = 0; k + 1 < errors.size(); ++k) {
    const double order = std::log2(errors[k] / errors[k + 1]);
    EXPECT_NEAR(order, 2.0, 0.15) << errors[k] << " then " << errors[k + 1];
  }
}

TEST(HeightCurvature, IsExactForQuadricsUpToTheBorderAndBesideHoles) {
  // At the border of h = a x^2 + b y^2 + c x y the fit finds the quadric itself: the formula with its derivatives.
  constexpr double a = 0.02, b = -0.01, c = 0.015;
  HeightField field = field_of(31, 0.5, [](double x, double y) { return a * x * x + b * y * y + c * x * y; });
  for (int y = 10; y < 14; ++y) {
    for (int x = 12; x < 15; ++x) {
      field.seen.at(x, y) = 0;
      field.height_mm.at(x, y) = 1000.0;
    }
  }
  const ImageF found = height_curvature(field, 1.0);
  double worst = 0.0;
  for (int j = 0; j < 31; ++j) {
    for (int i = 0; i < 31; ++i) {
      if (field.seen.at(i, j) == 0) continue;
      const double x = 0.5 * i - 7.5, y = 7.5 - 0.5 * j;
      const double hx = 2 * a * x + c * y, hy = 2 * b * y + c * x;
      const double expected = ((1 + hx * hx) * 2 * b - 2 * hx * hy * c + (1 + hy * hy) * 2 * a) /
                              (2 * std::pow(1 + hx * hx + hy * hy, 1.5));
      worst = std::max(worst, std::abs(static_cast<double>(found.at(i, j)) - expected));
    }
  }
  EXPECT_LT(worst, 1e-8);  // Rounding of floats.
}

TEST(HeightCurvature, WidthsThatTheGridCannotHoldAreRefused) {
  const HeightField field = field_of(9, 1.0, cap);
  EXPECT_THROW((void)height_curvature(field, 0.4), InvalidInput);
  EXPECT_THROW((void)height_curvature(field, std::nan("")), InvalidInput);
}

TEST(HeightField, HoldsTheHeightsOfATiltedPlaneSeenFromAnyDirection) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {10, 0, 3}, {10, 10, 5}, {0, 10, 2}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangle_surface = {0, 0};
  mesh.surfaces = {{}};
  const RayScene scene(mesh);
  for (const Vec3& toward : {Vec3(0, 0, 1), Vec3(0.3, -0.2, 0.9), Vec3(1.0, 0.1, 0.5)}) {
    const Vec3 viewer = toward.normalized();
    const HeightField field = height_field(mesh, scene, viewer, 0.25);
    EXPECT_LT((field.right.cross(field.down) + viewer).norm(), 1e-12);
    std::int64_t num_seen = 0;
    for (int y = 0; y < field.seen.height(); ++y) {
      for (int x = 0; x < field.seen.width(); ++x) {
        if (field.seen.at(x, y) == 0) continue;
        ++num_seen;
        const Vec3 p = field.origin + 0.25 * (x * field.right + y * field.down) + field.height_mm.at(x, y) * viewer;
        EXPECT_NEAR(p.z(), 0.3 * p.x() + 0.2 * p.y(), 1e-9);
        EXPECT_LT((field.grid_position(p) - Vec2(x, y)).norm(), 1e-9);
      }
    }
    EXPECT_GT(num_seen, 100);
  }
}

}  // namespace
}  // namespace patinate
