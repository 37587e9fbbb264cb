#include "libcommon/geometry/curvature.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "patinate/core/error.h"
#include "tests/libcommon/geometry/shapes.h"

namespace patinate {
namespace {

using testing_support::make_icosphere;
using testing_support::make_patch;

/// Largest deviation from `expected` at positions that `where` accepts.
template <class Where>
double worst_error(const Mesh& mesh, double scale, double expected, Where&& where) {
  const std::vector<double> h = mean_curvature(mesh, scale);
  double worst = 0.0;
  int num = 0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    if (!where(mesh.positions[i])) continue;
    worst = std::max(worst, std::abs(h[i] - expected));
    ++num;
  }
  EXPECT_GT(num, 10);
  return worst;
}
bool anywhere(const Vec3&) { return true; }

Mesh flipped(Mesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// Closed form of one implicit step on a sphere.
double sphere_value(double radius, double scale) { return -(1 / radius) / (1 + scale * scale / (radius * radius)); }

TEST(MeanCurvature, OfASphereIsTheClosedForm) {
  // With Voronoi areas the cotangent formula is nearly exact on a sphere, irregular corners included.
  for (double scale : {0.3, 1.0}) {
    for (int levels : {2, 3, 4}) {
      EXPECT_LT(worst_error(make_icosphere(2.0, levels), scale, sphere_value(2.0, scale), anywhere), 3e-4);
    }
  }
}

TEST(MeanCurvature, OfTheInsideOfASphereIsPositive) {
  EXPECT_LT(worst_error(flipped(make_icosphere(2.0, 4)), 0.5, -sphere_value(2.0, 0.5), anywhere), 0.005);
}

TEST(MeanCurvature, OfAPlaneIsZeroEvenWithThinTriangles) {
  const Mesh plane = make_patch(40, 7, [](double u, double v) { return Vec3(u * u * u, v, 5.0); });
  EXPECT_LT(worst_error(plane, 0.1, 0.0, anywhere), 1e-10);
}

TEST(MeanCurvature, OfACylinderIsHalfThatOfASphere) {
  // The cross-section is harmonic too: x' = x / (1 + t / R^2), so -(1/(2R)) / (1 + t / R^2); away from the open ends.
  const double radius = 1.5, scale = 0.4;
  const Mesh cylinder = make_patch(120, 80, [&](double u, double v) {
    const double angle = 2 * std::numbers::pi * u;
    return Vec3(radius * std::cos(angle), radius * std::sin(angle), 8 * v);
  });
  const double expected = -(1 / (2 * radius)) / (1 + scale * scale / 2 / (radius * radius));
  const auto is_inner = [](const Vec3& p) {
    return p.z() > 3 && p.z() < 5 && p.x() < 0;
  };  // nor near the slit at u = 0
  EXPECT_LT(worst_error(cylinder, scale, expected, is_inner), 0.003);
}

/// A shallow bowl in a plane, height -depth exp(-r^2 / 2), n x n cells over [-4, 4]^2.
constexpr double kDepth = 0.02;
Mesh make_bowl(int n) {
  return make_patch(n, n, [](double u, double v) {
    const double x = 8 * u - 4, y = 8 * v - 4;
    return Vec3(x, y, -kDepth * std::exp(-0.5 * (x * x + y * y)));
  });
}

/// At its bottom the step gives k^2 / 2 / (1 + t k^2) of every wave number k; with s = k^2 / 2 that is depth times the
/// integral of s / (1 + 2 t s) exp(-s) over s > 0.
double bowl_bottom(double scale) {
  double sum = 0.0;
  for (double s = 0.0005; s < 40.0; s += 0.001) sum += 0.001 * kDepth * s / (1 + scale * scale * s) * std::exp(-s);
  return sum;
}

double curvature_of_bowl(int n, double scale, double x, double y) {
  const auto index = [n](double c) { return std::lround((c + 4) / 8 * n); };
  return mean_curvature(make_bowl(n), scale)[index(y) * (n + 1) + index(x)];
}

TEST(MeanCurvature, OfAPitIsPositiveAndOfItsRimNegative) {
  EXPECT_NEAR(curvature_of_bowl(120, 0.15, 0, 0), bowl_bottom(0.15), 0.005 * kDepth);  // edges of scale / 2
  EXPECT_LT(curvature_of_bowl(120, 0.15, 2, 0), -0.1 * kDepth);
  EXPECT_NEAR(curvature_of_bowl(120, 0.15, 3.4, 3.4), 0.0, 0.005 * kDepth);
}

TEST(MeanCurvature, ErrorFallsAsTheSquareOfTheEdges) {
  constexpr double kScale = 0.8;
  double previous = 0.0;
  for (int n : {20, 40, 80}) {
    const double error = std::abs(curvature_of_bowl(n, kScale, 0, 0) - bowl_bottom(kScale));
    if (n > 20) {
      EXPECT_LT(error, previous / 3.0) << n;
    }
    previous = error;
  }
}

TEST(MeanCurvature, ScalesWithTheUnit) {
  Mesh sphere = make_icosphere(2.0, 3);
  const std::vector<double> small = mean_curvature(sphere, 0.5);
  scale_mesh(sphere, 1000.0);
  const std::vector<double> large = mean_curvature(sphere, 500.0);
  for (std::size_t i = 0; i < small.size(); ++i) EXPECT_NEAR(large[i] * 1000.0, small[i], 1e-9);
}

TEST(MeanCurvature, LooksAtEveryPartAloneAndIgnoresWhatIsNotUsed) {
  const Mesh sphere = make_icosphere(2.0, 3);
  Mesh mesh = sphere;
  const int offset = static_cast<int>(mesh.positions.size());
  for (const Vec3& p : sphere.positions) mesh.positions.push_back(p + Vec3(100, 0, 0));
  for (const Triangle& t : sphere.triangles) mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  mesh.positions.push_back(Vec3(1e9, std::nan(""), 0));  // in no triangle
  mesh.positions.push_back(Vec3(50, 0, 0));              // a needle of no area, connected to nothing
  mesh.positions.push_back(Vec3(51, 0, 0));
  mesh.positions.push_back(Vec3(52, 0, 0));
  const int last = static_cast<int>(mesh.positions.size());
  mesh.triangles.push_back({last - 3, last - 2, last - 1});
  mesh.triangles.push_back({0, 1, 1 + offset});  // and one of area that ties the parts badly: still finite
  for (double h : mean_curvature(mesh, 0.5)) EXPECT_TRUE(std::isfinite(h));
  mesh.triangles.pop_back();
  const std::vector<double> alone = mean_curvature(sphere, 0.5), all = mean_curvature(mesh, 0.5);
  for (std::size_t i = 0; i < alone.size(); ++i) {
    EXPECT_NEAR(all[i], alone[i], 1e-9);
    EXPECT_NEAR(all[i + alone.size()], alone[i], 1e-9);
  }
  EXPECT_EQ(all[2 * alone.size()], 0.0);
}

TEST(MeanCurvature, GivesTheSameBitsAgain) {
  const Mesh sphere = make_icosphere(2.0, 3);
  RunControl one, four;
  one.num_threads = 1;
  four.num_threads = 4;
  EXPECT_EQ(mean_curvature(sphere, 0.5, one), mean_curvature(sphere, 0.5, four));
}

TEST(MeanCurvature, RejectsBadScalesAndMeshesWithoutArea) {
  const Mesh sphere = make_icosphere(2.0, 1);
  EXPECT_THROW((void)mean_curvature(sphere, 0.0), InvalidInput);
  EXPECT_THROW((void)mean_curvature(sphere, std::nan("")), InvalidInput);
  EXPECT_THROW((void)mean_curvature(Mesh{}, 1.0), InvalidInput);
}

}  // namespace
}  // namespace patinate
