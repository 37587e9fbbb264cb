#include "patinate/geometry/mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>

#include "libcommon/mesh_files/mesh_builder.h"
#include "patinate/core/error.h"
#include "patinate/geometry/crease_normals.h"
#include "tests/libcommon/geometry/shapes.h"

namespace patinate {
namespace {

using testing_support::make_cube;
using testing_support::make_icosphere;
using testing_support::make_patch;

constexpr double kMeshRounding = 1e-12;

double total_area(const Mesh& mesh) {
  double area = 0.0;
  for (int t = 0; t < mesh.num_triangles(); ++t) area += 0.5 * area_vector(mesh, t).norm();
  return area;
}

double longest_edge(const Mesh& mesh) {
  double longest = 0.0;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 edge = mesh.positions[t[(k + 1) % 3]] - mesh.positions[t[k]];
      longest = std::max(longest, edge.norm());
    }
  }
  return longest;
}

int num_open_sides(const Mesh& mesh) {
  int num = 0;
  for (const auto& sides : triangle_neighbors(mesh)) {
    for (int n : sides) num += n < 0;
  }
  return num;
}

TEST(Mesh, VertexNormalsOfASphereAreRadial) {
  const Mesh sphere = make_icosphere(3.0, 3);
  const std::vector<Vec3> normals = vertex_normals(sphere);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    EXPECT_GT(normals[i].dot(sphere.positions[i].normalized()), 1.0 - 1e-3);  // O(h^2)
  }
}

TEST(Mesh, VertexNormalsOfACubeDoNotDependOnItsDiagonals) {
  // Angle weights: every corner gets 90 degrees from each of three faces, however they are cut in triangles.
  const Mesh cube = make_cube(2.0);
  const std::vector<Vec3> normals = vertex_normals(cube);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Vec3 outward = (cube.positions[i] - Vec3::Ones()).normalized();
    EXPECT_LT((normals[i] - outward).norm(), kMeshRounding);
  }
}

TEST(Mesh, NormalOfAnUnusedPositionIsZ) {
  Mesh mesh = make_cube(1.0);
  mesh.positions.push_back(Vec3(9, 9, 9));
  EXPECT_EQ(vertex_normals(mesh).back(), Vec3(0, 0, 1));
  EXPECT_EQ(bounding_box(mesh).high, Vec3(1, 1, 1));
}

TEST(Mesh, NeighborsOfAClosedSurfaceAreMutual) {
  const Mesh sphere = make_icosphere(1.0, 2);
  const auto neighbors = triangle_neighbors(sphere);
  for (int t = 0; t < sphere.num_triangles(); ++t) {
    for (int n : neighbors[t]) {
      ASSERT_GE(n, 0);
      const auto& back = neighbors[n];
      EXPECT_NE(std::find(back.begin(), back.end(), t), back.end());
    }
  }
}

TEST(Mesh, EdgesOfThreeTrianglesGoOnWhereTheSurfaceBendsLeast) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 4}, {0, 1, 2}, {1, 0, 3}};  // A fin on a floor.
  const auto neighbors = triangle_neighbors(mesh);
  EXPECT_EQ(neighbors[0][0], -1);
  EXPECT_EQ(neighbors[1][0], 2);
  EXPECT_EQ(neighbors[2][0], 1);
}

TEST(Mesh, SheetsWithTwoSidesGoOnOnTheirOwnSide) {
  Mesh mesh;  // A folded strip and the same strip from behind: four triangles at the edge 0-1.
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.3}, {0, -1, 0.3}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 2}, {0, 1, 3}, {1, 0, 3}};
  const auto neighbors = triangle_neighbors(mesh);
  EXPECT_EQ(neighbors[0][0], 3);
  EXPECT_EQ(neighbors[1][0], 2);
}

TEST(Mesh, AnEdgeOfManyTrianglesTakesNoQuadraticTime) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < 100'000; ++i) {
    mesh.positions.emplace_back(std::cos(i), std::sin(i), 0.0);
    mesh.triangles.push_back({i % 2, 1 - i % 2, i + 2});
  }
  EXPECT_EQ(triangle_neighbors(mesh)[0][0], -1);
}

TEST(RefineEdges, SplitsUntilNoEdgeIsLongerAndLeavesNoCracks) {
  for (double max_edge : {0.9, 0.31, 0.1}) {
    const Mesh refined = refine_edges(make_cube(1.0), max_edge);
    EXPECT_LE(longest_edge(refined), max_edge);
    EXPECT_NEAR(total_area(refined), 6.0, 1e-9);
    EXPECT_EQ(num_open_sides(refined), 0);
    double volume = 0.0;  // divergence theorem: the winding is kept everywhere
    for (int t = 0; t < refined.num_triangles(); ++t) {
      const Triangle& c = refined.triangles[t];
      volume += refined.positions[c[0]].dot(area_vector(refined, t)) / 6.0;
    }
    EXPECT_NEAR(volume, 1.0, 1e-9);
  }
}

TEST(RefineEdges, InterpolatesUvsAndNormals) {
  Mesh patch = make_patch(1, 1, [](double u, double v) { return Vec3(2 * u, v, 0); });
  patch = refine_edges(with_normals(patch), 0.2);
  ASSERT_TRUE(patch.has_uvs());
  ASSERT_EQ(patch.normal_triangles.size(), patch.triangles.size());
  for (std::size_t t = 0; t < patch.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = patch.positions[patch.triangles[t][k]];
      const Vec2& uv = patch.uvs[patch.uv_triangles[t][k]];
      EXPECT_LT((uv - Vec2(p.x() / 2, p.y())).norm(), kMeshRounding);
      EXPECT_EQ(patch.normals[patch.normal_triangles[t][k]], Vec3(0, 0, 1));
    }
  }
}

TEST(RefineEdges, StaysUnderItsLimitOfTrianglesWithoutCracks) {
  const Mesh refined = refine_edges(make_cube(1.0), 1e-3, 500);
  EXPECT_LE(refined.num_triangles(), 500);
  EXPECT_GT(refined.num_triangles(), 450);
  EXPECT_EQ(num_open_sides(refined), 0);
}

TEST(RefineEdges, RejectsLengthsThatAreNotPositive) {
  EXPECT_THROW((void)refine_edges(make_cube(1.0), 0.0), InvalidInput);
  EXPECT_THROW((void)refine_edges(make_cube(1.0), std::nan("")), InvalidInput);
}

TEST(RefineEdges, CurvedFollowsTheSurfaceThatNormalsDescribe) {
  // Flat facets of this sphere lie up to several per cent inside; curved edges keep a small share of that.
  Mesh sphere = make_icosphere(1.0, 1);
  sphere.normals = sphere.positions;
  sphere.normal_triangles = sphere.triangles;
  const auto worst = [](const Mesh& mesh) {
    double error = 0.0;
    for (const Vec3& p : mesh.positions) error = std::max(error, std::abs(p.norm() - 1.0));
    return error;
  };
  EXPECT_GT(worst(refine_edges(sphere, 0.1)), 0.03);
  const Mesh curved = refine_edges(sphere, 0.1, 1'000'000, RefineShape::Curved);
  EXPECT_LT(worst(curved), 0.005);
  EXPECT_EQ(num_open_sides(curved), 0);
}

TEST(RefineEdges, CurvedKeepsCreases) {
  // A cube without normals, with one a face, and with normals that are wrongly smooth (55 degrees off its faces).
  const Mesh plain = make_cube(1.0);
  Mesh hard = plain;
  for (int t = 0; t < hard.num_triangles(); ++t) {
    hard.normals.push_back(area_vector(hard, t).normalized());
    hard.normal_triangles.push_back({t, t, t});
  }
  for (const Mesh& cube : {plain, hard, with_normals(plain)}) {
    const Mesh refined = refine_edges(cube, 0.2, 1'000'000, RefineShape::Curved);
    EXPECT_NEAR(total_area(refined), 6.0, 1e-9);
    for (const Vec3& p : refined.positions)
      EXPECT_NEAR((p - Vec3(0.5, 0.5, 0.5)).cwiseAbs().maxCoeff(), 0.5, kMeshRounding);
  }
}

TEST(CreaseNormals, AreHardWhereEdgesBendByMoreThanTheCrease) {
  const Mesh cube = with_crease_normals(make_cube(1.0));
  EXPECT_EQ(cube.normals.size(), 24u);
  for (int t = 0; t < cube.num_triangles(); ++t) {
    for (const int n : cube.normal_triangles[t])
      EXPECT_LT((cube.normals[n] - area_vector(cube, t).normalized()).norm(), kMeshRounding);
  }
  const Mesh smooth_cube = with_crease_normals(make_cube(1.0), 91.0);
  EXPECT_EQ(smooth_cube.normals.size(), 8u);
  // A sphere of 320 triangles bends by 18 degrees at most: smooth, as vertex_normals() has it.
  const Mesh sphere = with_crease_normals(make_icosphere(1.0, 2));
  const std::vector<Vec3> smooth = vertex_normals(sphere);
  EXPECT_EQ(sphere.normals.size(), sphere.positions.size());
  for (std::size_t t = 0; t < sphere.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LT((sphere.normals[sphere.normal_triangles[t][k]] - smooth[sphere.triangles[t][k]]).norm(), kMeshRounding);
    }
  }
  EXPECT_EQ(with_crease_normals(cube, 91.0).normals.size(), 24u) << "a mesh's own normals stay";
}

TEST(SelectSurfaces, KeepsOnlyWhatIsUsed) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  mesh.surfaces = {{"a", "clean"}, {"b", "aged"}};
  mesh.triangle_surface = {0, 1};
  const Mesh aged = select_surfaces(mesh, "", "aged");
  EXPECT_EQ(aged.positions.size(), 3u);
  EXPECT_EQ(aged.triangles, (std::vector<Triangle>{{0, 1, 2}}));
  ASSERT_EQ(aged.surfaces.size(), 1u);
  EXPECT_EQ(aged.surfaces[0].node, "b");
  EXPECT_EQ(select_surfaces(mesh, "", "").num_triangles(), 2);
  try {
    (void)select_surfaces(mesh, "c", "aged");
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_STREQ(e.what(), "no surface has node `c` with material `aged`; nodes: `a`, `b`; materials: `clean`, `aged`");
  }
}

TEST(TriangulatePolygon, CoversConcavePolygonsExactly) {
  // An L of area 3 and a star-like comb of area 2.5, in a tilted plane: triangles keep the winding, so signed areas add
  // up.
  const std::vector<std::vector<Vec2>> polygons = {
      {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
      {{0, 0}, {4, 0}, {4, 1}, {3, 0.5}, {2, 1}, {1, 0.5}, {0, 1}},
  };
  const std::vector<double> areas{3.0, 3.0};
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    std::vector<Vec3> corners;
    for (const Vec2& p : polygons[i]) corners.emplace_back(p.x(), p.y(), 0.3 * p.x() - 0.2 * p.y());
    const double stretch = std::sqrt(1 + 0.09 + 0.04);
    double sum = 0.0, absolute = 0.0;
    const std::vector<Triangle> triangles = triangulate_polygon(corners);
    EXPECT_EQ(triangles.size(), corners.size() - 2);
    for (const Triangle& t : triangles) {
      const auto at = [&](std::size_t k) { return corners[t[k]]; };
      const double z = 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).z();
      sum += z;
      absolute += std::abs(z);
    }
    EXPECT_NEAR(sum * stretch, areas[i] * stretch, kMeshRounding);
    EXPECT_NEAR(absolute, sum, kMeshRounding);
  }
}

}  // namespace
}  // namespace patinate
