#include "patinate/atlas/unwrap.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <stop_token>

#include "libcommon/core/random.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/datasets/objects.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::make_cube;
using testing_support::make_icosphere;
using testing_support::make_patch;

constexpr double kRounding = 1e-6;  ///< Rounding of a sparse factorization of some thousand unknowns, with room.
constexpr double kPi = std::numbers::pi;

Mesh strip_uvs(Mesh mesh) {
  mesh.uvs.clear();
  mesh.uv_triangles.clear();
  return mesh;
}

/// Twice the signed area of a triangle in the atlas.
double twice_uv_area(const Mesh& mesh, std::size_t t) {
  const auto uv = [&](std::size_t k) -> const Vec2& { return mesh.uvs[mesh.uv_triangles[t][k]]; };
  const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
  return a.x() * b.y() - a.y() * b.x();
}

/// Expects what holds for every mesh: UVs for all, in the atlas, counter-clockwise where there is area, no texel wanted
/// twice.
void expect_valid(const UnwrapResult& r, const Mesh& in, int resolution = 1024) {
  ASSERT_EQ(r.mesh.uv_triangles.size(), in.triangles.size());
  ASSERT_EQ(r.triangle_chart.size(), in.triangles.size());
  EXPECT_TRUE(r.mesh.triangles == in.triangles);
  EXPECT_TRUE(r.mesh.positions == in.positions);
  for (const Vec2& uv : r.mesh.uvs)
    ASSERT_TRUE(uv.allFinite() && uv.minCoeff() >= 0.0 && uv.maxCoeff() <= 1.0) << uv.transpose();
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
  for (int scale : {1, 2})
    EXPECT_EQ(TexelMap(r.mesh, scale * resolution, scale * resolution).num_overlapping(), 0) << "at " << scale << " x";
}

void expect_isometric(const UnwrapResult& r) {
  EXPECT_NEAR(r.stretch.max, 1.0, kRounding);
  EXPECT_NEAR(r.angle_stretch.max, 1.0, kRounding);
  EXPECT_NEAR(r.area_stretch.max, 1.0, kRounding);
  EXPECT_NEAR(r.l2_stretch, 1.0, kRounding);
}

// Developable surfaces have the plane's metric (Gauss): a map that keeps angles and is not bent by its borders keeps
// lengths.
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
  const Mesh cylinder = strip_uvs(make_patch(
      48, 12, [](double u, double v) { return Vec3(std::cos(2 * kPi * u), std::sin(2 * kPi * u), 4.0 * v); }));
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

/// A lumpy closed surface without symmetry.
Mesh make_blob(int levels) {
  Mesh mesh = strip_uvs(make_icosphere(1.0, levels));
  for (Vec3& p : mesh.positions) {
    p *= 1.0 + 0.25 * std::sin(3.1 * p.x() + 1.0) * std::cos(2.3 * p.y() - 0.4) + 0.2 * std::sin(4.7 * p.z() + p.x()) +
         0.1 * p.y();
  }
  return mesh;
}

double largest_difference(const UnwrapResult& a, const UnwrapResult& b) {
  if (a.mesh.uv_triangles != b.mesh.uv_triangles) return 1e30;
  double most = 0.0;
  for (std::size_t i = 0; i < a.mesh.uvs.size(); ++i)
    most = std::max(most, (a.mesh.uvs[i] - b.mesh.uvs[i]).cwiseAbs().maxCoeff());
  return most;
}

TEST(Unwrap, DoesNotDependOnPlaceTurnAndUnit) {
  const Mesh blob = make_blob(3);
  const UnwrapResult r = unwrap(blob);
  expect_valid(r, blob);
  Mesh moved = blob;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vec3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  for (Vec3& p : moved.positions) p = 0.037 * (turn * p) + Vec3(1.0, -2.0, 0.5);
  const UnwrapResult other = unwrap(moved);
  EXPECT_LT(largest_difference(r, other), kRounding);
  EXPECT_NEAR(other.texels_per_unit * 0.037, r.texels_per_unit, kRounding * r.texels_per_unit);
}

TEST(Unwrap, GivesTheSameBitsForAnyNumberOfThreads) {
  const Mesh blob = make_blob(3);
  RunControl one, four;
  one.num_threads = 1;
  four.num_threads = 4;
  EXPECT_EQ(largest_difference(unwrap(blob, {}, one), unwrap(blob, {}, four)), 0.0);
}

TEST(Unwrap, IgnoresUvsThatThereAre) {
  const Mesh patch = make_patch(6, 6, [](double u, double v) { return Vec3(u, v, 0.3 * u * v); });
  EXPECT_EQ(largest_difference(unwrap(patch), unwrap(strip_uvs(patch))), 0.0);
}

TEST(Unwrap, CoversThreeFifthsOfTheAtlasWithAnUrn) {
  datasets::SculptureOptions shape;
  shape.resolution = 40;
  const Mesh urn = strip_uvs(datasets::sculpture(shape));
  const UnwrapResult r = unwrap(urn);
  expect_valid(r, urn);
  const TexelMap map(r.mesh, 1024, 1024);
  const double covered = static_cast<double>(map.num_covered()) / static_cast<double>(map.num_texels());
  EXPECT_GE(covered, 0.6);
  EXPECT_NEAR(covered, r.packing,
              0.005);  // Texel centers sample the area; the error is of borders, some thousand texels of a million.
  EXPECT_LE(r.stretch.p95, 1.5);
  EXPECT_LE(r.num_charts, 80);
}

TEST(Unwrap, KeepsChartsAGutterApart) {
  UnwrapOptions options;
  options.gutter_texels = 4;
  options.resolution = 256;
  const UnwrapResult r = unwrap(make_blob(3), options);
  const TexelMap map(r.mesh, 256, 256);
  ASSERT_GT(r.num_charts, 1);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    for (int dy = -4; dy <= 4; ++dy) {
      for (int dx = -4; dx <= 4; ++dx) {
        const auto x = static_cast<int>(t % 256) + dx, y = static_cast<int>(t / 256) + dy;
        if (x < 0 || y < 0 || x >= 256 || y >= 256) continue;
        const TexelId other = TexelId{y} * 256 + x;
        if (!map.is_covered(other)) continue;
        ASSERT_EQ(map.chart(t), map.chart(other)) << "texels " << t << " and " << other;
      }
    }
  }
}

/// nu x nv cells that close up in u (turned over in v where `twisted`) and, where `closed_v`, in v.
Mesh make_ring(int nu, int nv, bool twisted, bool closed_v, const std::function<Vec3(double u, double v)>& point) {
  Mesh mesh;
  const int rows = closed_v ? nv : nv + 1;
  for (int i = 0; i < nu; ++i) {
    for (int j = 0; j < rows; ++j)
      mesh.positions.push_back(point(static_cast<double>(i) / nu, static_cast<double>(j) / nv));
  }
  const auto index = [&](int i, int j) {
    if (i == nu) i = 0, j = twisted ? nv - j : j;
    return i * rows + j % rows;
  };
  for (int i = 0; i < nu; ++i) {
    for (int j = 0; j < nv; ++j) {
      mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  }
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  mesh.surfaces = {{}};
  return mesh;
}

TEST(Unwrap, CutsSurfacesWithoutAnInside) {
  const Mesh moebius = make_ring(60, 6, true, false, [](double u, double v) {
    const double a = 2 * kPi * u, w = v - 0.5, r = 1.0 + w * std::cos(a / 2);
    return Vec3(r * std::cos(a), r * std::sin(a), w * std::sin(a / 2));
  });
  expect_valid(unwrap(moebius), moebius);
  const Mesh klein =
      make_ring(60, 30, true, true, [](double u, double v) {  // The figure-8 immersion, which passes through itself.
        const double a = 2 * kPi * u, b = 2 * kPi * v;
        const double r = 2.0 + std::cos(a / 2) * std::sin(b) - std::sin(a / 2) * std::sin(2 * b);
        return Vec3(r * std::cos(a), r * std::sin(a),
                    std::sin(a / 2) * std::sin(b) + std::cos(a / 2) * std::sin(2 * b));
      });
  expect_valid(unwrap(klein), klein);
}

TEST(Unwrap, KeepsSpikesApart) {
  // Neighboring triangles face anywhere: conformal maps fold, fans at borders wind over themselves, and must be cut
  // again.
  Mesh spiky = make_blob(2);
  for (std::size_t i = 0; i < spiky.positions.size(); ++i)
    spiky.positions[i] *= 1.0 + 0.15 * RandomStream(7, i).normal();
  const UnwrapResult r = unwrap(spiky);
  expect_valid(r, spiky);
}

TEST(Unwrap, CutsATorus) {
  const Mesh torus = make_ring(48, 24, false, true, [](double u, double v) {
    const double r = 3.0 + std::cos(2 * kPi * v);
    return Vec3(r * std::cos(2 * kPi * u), r * std::sin(2 * kPi * u), std::sin(2 * kPi * v));
  });
  const UnwrapResult r = unwrap(torus);
  expect_valid(r, torus);
  EXPECT_LE(r.num_charts, 20);
}

TEST(Unwrap, TakesEdgesOfThreeTrianglesAsBorders) {
  Mesh fins;
  fins.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-0.5, 0.8, 0}, {-0.5, -0.8, 0}};
  fins.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};
  const UnwrapResult r = unwrap(fins);
  expect_valid(r, fins);
  EXPECT_EQ(r.num_charts, 3);
  expect_isometric(r);
}

TEST(Unwrap, GivesTrianglesWithoutAreaUvs) {
  Mesh plane = strip_uvs(make_patch(4, 4, [](double u, double v) { return Vec3(u, v, 0.0); }));
  const int middle = static_cast<int>(plane.positions.size());
  plane.positions.push_back(0.5 * (plane.positions[0] + plane.positions[1]));
  plane.triangles.push_back({0, middle, 1});  // A sliver on a border edge.
  plane.triangles.push_back({2, 2, 3});       // A corner twice.
  plane.positions.insert(plane.positions.end(), 3, Vec3(9.0, 9.0, 9.0));
  plane.triangles.push_back({middle + 1, middle + 2, middle + 3});  // A point, apart from all else.
  plane.triangle_surface.assign(plane.triangles.size(), 0);
  const UnwrapResult r = unwrap(plane);
  expect_valid(r, plane);
  EXPECT_EQ(r.num_degenerate, 3);
  EXPECT_EQ(r.num_charts, 1);
}

TEST(Unwrap, LaysASingleTriangleAndTwoPieces) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}};
  mesh.triangles = {{0, 1, 2}};
  const UnwrapResult one = unwrap(mesh);
  expect_valid(one, mesh);
  expect_isometric(one);
  EXPECT_EQ(one.num_charts, 1);
  mesh.positions.insert(mesh.positions.end(), {{0, 0, 5}, {6, 0, 5}, {0, 8, 5}});
  mesh.triangles.push_back({3, 4, 5});
  const UnwrapResult two = unwrap(mesh);
  expect_valid(two, mesh);
  expect_isometric(two);  // The whole atlas is isometric: both have one texel density.
  EXPECT_EQ(two.num_charts, 2);
  EXPECT_EQ(two.triangle_chart[1], 0);  // The larger.
}

TEST(Unwrap, PlacesThousandsOfPieces) {
  Mesh soup;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 at(i % 64, i / 64, 0.0);
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    soup.positions.insert(soup.positions.end(),
                          {at, at + Vec3(0.4 + 1e-4 * i, 0, 0), at + Vec3(0.1, 0.5, 0.01 * (i % 7))});
  }
  const UnwrapResult r = unwrap(soup);
  expect_valid(r, soup);
  expect_isometric(r);
  EXPECT_EQ(r.num_charts, 4000);
  UnwrapOptions small;
  small.resolution = 32;
  EXPECT_THROW((void)unwrap(soup, small), InvalidInput);
}

TEST(Unwrap, RefusesWhatHasNoSurface) {
  EXPECT_THROW((void)unwrap(Mesh{}), InvalidInput);
  Mesh line;
  line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  EXPECT_THROW((void)unwrap(line), InvalidInput);
  line.positions[2] = Vec3(0.0, std::nan(""), 0.0);
  EXPECT_THROW((void)unwrap(line), InvalidInput);
  UnwrapOptions options;
  options.max_stretch = std::nan("");
  EXPECT_THROW((void)unwrap(make_cube(1.0), options), InvalidInput);
}

TEST(Unwrap, CanBeStoppedAndReportsItsProgress) {
  const Mesh blob = make_blob(3);
  double last = 0.0;
  RunControl control;
  control.on_progress = [&](double f) {
    EXPECT_GE(f, last);
    last = f;
  };
  (void)unwrap(blob, {}, control);
  EXPECT_EQ(last, 1.0);
  for (double at : {0.06, 0.5, 0.8}) {
    std::stop_source source;
    RunControl stopped;
    stopped.stop = source.get_token();
    stopped.on_progress = [&](double f) {
      if (f >= at) source.request_stop();
    };
    EXPECT_THROW((void)unwrap(blob, {}, stopped), Canceled) << "at " << at;
  }
}

TEST(Unwrap, LaysScannedAndModeledMeshesFlat) {
  PATINATE_REQUIRE_DATA(meshes, "meshes");
  for (const char* name : {"spot/spot_triangulated.obj", "marble_bust/marble_bust_01_1k.gltf"}) {
    const Mesh mesh = read_mesh(meshes / name);
    const UnwrapResult r = unwrap(mesh);
    expect_valid(r, mesh);
    EXPECT_GE(r.packing, 0.6) << name;
    EXPECT_LE(r.stretch.p95, 1.5) << name;
    EXPECT_LE(r.num_charts, 60) << name;
  }
}

}  // namespace
}  // namespace patinate
