#include "libcommon/atlas/unwrap.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <numbers>
#include <set>

#include "datasets_synthetic/sculpture.h"
#include "libcommon/atlas/texel_map.h"
#include "libcommon/geometry/mesh_io.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::make_cube;
using testing_support::make_icosphere;
using testing_support::make_patch;

constexpr double kRounding = 1e-6;  ///< Of a sparse factorisation of some thousand unknowns, with room.
constexpr double kPi = std::numbers::pi;

Mesh strip_uvs(Mesh mesh) {
  mesh.uvs.clear();
  mesh.uv_triangles.clear();
  return mesh;
}

/// Twice the signed area of a triangle in the atlas.
double twice_uv_area(const Mesh& mesh, std::size_t t) {
  const auto uv = [&](std::size_t k) -> const Vec2& { return mesh.uvs[static_cast<std::size_t>(mesh.uv_triangles[t][k])]; };
  const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
  return a.x() * b.y() - a.y() * b.x();
}

/// What holds for every mesh: UVs for all, in the atlas, counter-clockwise where there is area, no texel wanted twice.
void expect_valid(const UnwrapResult& r, const Mesh& in, int resolution = 1024) {
  ASSERT_EQ(r.mesh.uv_triangles.size(), in.triangles.size());
  ASSERT_EQ(r.triangle_chart.size(), in.triangles.size());
  EXPECT_TRUE(r.mesh.triangles == in.triangles);
  EXPECT_TRUE(r.mesh.positions == in.positions);
  for (const Vec2& uv : r.mesh.uvs) ASSERT_TRUE(uv.allFinite() && uv.minCoeff() >= 0.0 && uv.maxCoeff() <= 1.0) << uv.transpose();
  const double size = bounding_box(in).diagonal();
  for (std::size_t t = 0; t < in.triangles.size(); ++t) {
    const double twice = twice_uv_area(r.mesh, t);
    if (area_vector(in, static_cast<int>(t)).norm() > 1e-9 * size * size) {
      ASSERT_GT(twice, 0.0) << "triangle " << t;
    } else {
      ASSERT_GE(twice, 0.0) << "triangle " << t;
    }
    ASSERT_GE(r.triangle_chart[t], 0);
    ASSERT_LT(r.triangle_chart[t], r.num_charts);
  }
  for (int scale : {1, 2}) EXPECT_EQ(TexelMap(r.mesh, scale * resolution, scale * resolution).num_overlapping(), 0) << "at " << scale << " x";
}

void expect_isometric(const UnwrapResult& r) {
  EXPECT_NEAR(r.stretch.max, 1.0, kRounding);
  EXPECT_NEAR(r.angle_stretch.max, 1.0, kRounding);
  EXPECT_NEAR(r.area_stretch.max, 1.0, kRounding);
  EXPECT_NEAR(r.l2_stretch, 1.0, kRounding);
}

// Developable surfaces have the plane's metric (Gauss): a map that keeps angles and is not bent by its borders keeps lengths.
TEST(Unwrap, LaysAPlaneFlatInOneChart) {
  const Mesh plane = strip_uvs(make_patch(20, 10, [](double u, double v) { return Vec3(3.0 * u, 2.0 * v, 1.0); }));
  const UnwrapResult r = unwrap(plane);
  expect_valid(r, plane);
  expect_isometric(r);
  EXPECT_EQ(r.num_charts, 1);
  EXPECT_NEAR(r.packing, 2.0 / 3.0, 0.02);  // A 3 x 2 box in a square, less margins of a texel and cells of one.
}

TEST(Unwrap, UnrollsACylinderWithoutStretch) {
  // The polyhedron is developable itself: flat facets between straight rulings.
  const Mesh cylinder = strip_uvs(make_patch(48, 12, [](double u, double v) { return Vec3(std::cos(2 * kPi * u), std::sin(2 * kPi * u), 4.0 * v); }));
  const UnwrapResult r = unwrap(cylinder);
  expect_valid(r, cylinder);
  expect_isometric(r);
  EXPECT_LE(r.num_charts, 4);
}

TEST(Unwrap, UnrollsAConeWithoutStretch) {
  const Mesh cone = strip_uvs(make_patch(40, 10, [](double u, double v) {
    const double r = 0.1 + v;
    return Vec3(r * std::cos(1.9 * kPi * u), r * std::sin(1.9 * kPi * u), 1.5 * r);
  }));
  const UnwrapResult r = unwrap(cone);
  expect_valid(r, cone);
  expect_isometric(r);
}

TEST(Unwrap, LaysACubeInAtMostSixCharts) {
  const Mesh cube = strip_uvs(make_cube(2.0));
  const UnwrapResult r = unwrap(cube);
  expect_valid(r, cube);
  expect_isometric(r);
  EXPECT_LE(r.num_charts, 6);
}

TEST(Unwrap, BoundsTheStretchOfASphere) {
  const Mesh sphere = strip_uvs(make_icosphere(5.0, 4));
  UnwrapOptions options;
  options.max_stretch = 1.3;
  const UnwrapResult r = unwrap(sphere, options);
  expect_valid(r, sphere);
  EXPECT_LE(r.stretch.p95, 1.3);
  EXPECT_GT(r.stretch.p95, 1.01);        // No map of a piece of a sphere is isometric.
  EXPECT_LE(r.angle_stretch.p95, 1.05);  // Conformal, up to the facets.
  EXPECT_LE(r.num_charts, 12);
}

}  // namespace
}  // namespace patinate
