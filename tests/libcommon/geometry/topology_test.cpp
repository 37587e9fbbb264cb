#include "libcommon/geometry/topology.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/libcommon/geometry/shapes.h"
#include "tests/support/meshes.h"

namespace patinate {
namespace {

using testing_support::make_cube;
using testing_support::make_icosphere;

// Euler characteristics: sphere 2, disc 1, torus 0.
TEST(MeshTopology, KnowsASphere) {
  const MeshTopology t = mesh_topology(make_icosphere(1.0, 2));
  EXPECT_TRUE(t.is_closed());
  EXPECT_EQ(t.num_parts, 1);
  EXPECT_EQ(t.euler_characteristic, 2);
}

TEST(MeshTopology, KnowsADiscWhateverItsCharts) {
  for (const Mesh& mesh : {testing_support::unit_plane(1.0), testing_support::cut_plane(1.0)}) {
    const MeshTopology t = mesh_topology(mesh);
    EXPECT_FALSE(t.is_closed());
    EXPECT_EQ(t.num_boundary_loops, 1);
    EXPECT_EQ(t.euler_characteristic, 1);
  }
}

TEST(MeshTopology, KnowsATorus) {
  constexpr int kSides = 12;
  Mesh mesh;
  for (int i = 0; i < kSides; ++i) {
    for (int j = 0; j < kSides; ++j) {
      const double u = 2.0 * std::numbers::pi * i / kSides, v = 2.0 * std::numbers::pi * j / kSides;
      mesh.positions.emplace_back((3.0 + std::cos(v)) * std::cos(u), (3.0 + std::cos(v)) * std::sin(u), std::sin(v));
      const auto at = [](int a, int b) { return a % kSides * kSides + b % kSides; };
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  const MeshTopology t = mesh_topology(mesh);
  EXPECT_TRUE(t.is_closed());
  EXPECT_EQ(t.euler_characteristic, 0);
}

TEST(MeshTopology, CountsPartsAndNonManifoldTriangles) {
  Mesh mesh = make_cube(1.0);
  const Mesh other = make_cube(1.0);
  for (const Vec3& p : other.positions) mesh.positions.push_back(p + Vec3(5.0, 0.0, 0.0));
  const int shift = static_cast<int>(other.positions.size());
  for (const Triangle& t : other.triangles) mesh.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  EXPECT_EQ(mesh_topology(mesh).num_parts, 2);
  EXPECT_EQ(mesh_topology(mesh).euler_characteristic, 4);
  // A fin on an edge that has two triangles already.
  mesh.positions.emplace_back(-1.0, -1.0, -1.0);
  mesh.triangles.push_back({mesh.triangles[0][0], mesh.triangles[0][1], static_cast<int>(mesh.positions.size()) - 1});
  const MeshTopology t = mesh_topology(mesh);
  EXPECT_EQ(t.num_nonmanifold_triangles, 1);
  EXPECT_FALSE(t.is_closed());
}

}  // namespace
}  // namespace patinate
