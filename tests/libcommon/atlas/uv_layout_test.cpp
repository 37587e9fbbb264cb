#include <gtest/gtest.h>

#include "patinate/atlas/atlas_mesh.h"
#include "patinate/core/error.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::cut_plane;
using testing_support::TempFolder;
using testing_support::unit_plane;

/// Copies of a plane side by side in space, each a surface of its own, with UVs moved by `uv_offset` times its number.
Mesh planes(int count, const Vec2& uv_offset, bool has_materials) {
  Mesh mesh;
  const Mesh one = unit_plane(1.0);
  for (int i = 0; i < count; ++i) {
    const int first = static_cast<int>(mesh.positions.size()), first_uv = static_cast<int>(mesh.uvs.size());
    for (const Vec3& p : one.positions) mesh.positions.emplace_back(p + Vec3(2.0 * i, 0, 0));
    for (const Vec2& uv : one.uvs) mesh.uvs.emplace_back(uv + i * uv_offset);
    for (Triangle t : one.triangles) {
      for (int& corner : t) corner += first;
      mesh.triangles.push_back(t);
      mesh.triangle_surface.push_back(i);
    }
    for (Triangle t : one.uv_triangles) {
      for (int& corner : t) corner += first_uv;
      mesh.uv_triangles.push_back(t);
    }
    mesh.surfaces.push_back({"node " + std::to_string(i), has_materials ? "paint/" + std::to_string(i) : "paint"});
  }
  return mesh;
}

TEST(UvLayout, OneSquareWithoutOverlapIsTakenAsItIs) {
  const UvLayout layout = find_uv_layout(cut_plane(10.0));
  EXPECT_EQ(layout.problem, "");
  EXPECT_EQ(layout.remark, "");
  ASSERT_EQ(layout.tiles.size(), 1u);
  EXPECT_EQ(layout.tiles[0].name, "");
  EXPECT_EQ(layout.tiles[0].scale, 1.0);
  EXPECT_EQ(layout.tiles[0].shift, Vec2(0, 0));
  EXPECT_EQ(layout.overlap_share, 0.0);
}

TEST(UvLayout, TrianglesThatKeepToIntegerSquaresAreUdim) {
  const UvLayout layout = find_uv_layout(planes(3, {1.0, 1.0}, false));
  EXPECT_EQ(layout.rule, UvLayoutRule::Udim);
  ASSERT_EQ(layout.tiles.size(), 3u);
  EXPECT_EQ(layout.tiles[0].name, "1001");
  EXPECT_EQ(layout.tiles[1].name, "1012");  // 1001 + u + 10 v
  EXPECT_EQ(layout.tiles[2].name, "1023");
  EXPECT_EQ(layout.tiles[2].origin, Vec2(2, 2));
  EXPECT_EQ(layout.triangle_tile.back(), 2);
  EXPECT_EQ(layout.problem, "");
}

TEST(UvLayout, ASquareLeftOfTheFirstOneIsMovedThere) {
  Mesh mesh = unit_plane(1.0);
  for (Vec2& uv : mesh.uvs) uv -= Vec2(3.0, 1.0);
  const UvLayout layout = find_uv_layout(mesh);
  EXPECT_EQ(layout.problem, "");
  ASSERT_EQ(layout.tiles.size(), 1u);
  EXPECT_EQ(layout.tiles[0].shift, Vec2(-3, -1));
  EXPECT_NE(layout.remark, "");
}

TEST(UvLayout, MaterialsThatEachFillTheSquareGetATileEach) {
  const UvLayout layout = find_uv_layout(planes(2, {0.0, 0.0}, true));
  EXPECT_EQ(layout.rule, UvLayoutRule::Material);
  ASSERT_EQ(layout.tiles.size(), 2u);
  EXPECT_EQ(layout.tiles[0].name, "paint_0");  // fit for a file
  EXPECT_EQ(layout.overlap_share, 0.0);
  EXPECT_EQ(layout.problem, "");
}

TEST(UvLayout, NodesOfOneMaterialGetATileEach) {
  const UvLayout layout = find_uv_layout(planes(3, {0.0, 0.0}, false));
  EXPECT_EQ(layout.rule, UvLayoutRule::Node);
  EXPECT_EQ(layout.tiles.size(), 3u);
}

TEST(UvLayout, MoreNodesThanTilesAreAProblem) {
  const UvLayout layout = find_uv_layout(planes(kMaxTiles + 1, {0.0, 0.0}, false));
  EXPECT_NE(layout.problem.find("more than one place"), std::string::npos) << layout.problem;
  EXPECT_EQ(layout.tiles.size(), 1u);  // for those who insist
  EXPECT_EQ(layout.overlap_share, 1.0);
}

TEST(UvLayout, RepeatedTexturesAreAProblemWithoutTiles) {
  Mesh mesh = unit_plane(1.0, 3);
  for (Vec2& uv : mesh.uvs) uv *= 2.5;  // Triangles cross the borders of squares.
  const UvLayout layout = find_uv_layout(mesh);
  EXPECT_NE(layout.problem.find("leave [0, 1]"), std::string::npos) << layout.problem;
  EXPECT_TRUE(layout.tiles.empty());
}

TEST(UvLayout, HugeUvsAreAProblemAndNotACrash) {
  Mesh mesh = unit_plane(1.0, 3);
  for (Vec2& uv : mesh.uvs) uv *= 1e30;
  EXPECT_NE(find_uv_layout(mesh).problem, "");
  EXPECT_TRUE(find_uv_layout(mesh).tiles.empty());
}

TEST(UvLayout, MissingAndFlatUvsAreAProblem) {
  Mesh mesh = unit_plane(1.0);
  mesh.uv_triangles[3][1] = -1;
  EXPECT_NE(find_uv_layout(mesh).problem.find("1 of its 32 triangles"), std::string::npos)
      << find_uv_layout(mesh).problem;
  mesh.uvs.clear();
  mesh.uv_triangles.clear();
  EXPECT_EQ(find_uv_layout(mesh).problem, "it has no UVs");
  mesh = unit_plane(1.0);
  for (Vec2& uv : mesh.uvs) uv = Vec2(0.5, 0.5);  // A palette.
  EXPECT_NE(find_uv_layout(mesh).problem.find("100 % of its surface has no area"), std::string::npos);
}

TEST(UvLayout, MirroredHalvesAreAProblemByTheirOverlap) {
  Mesh mesh = unit_plane(1.0, 8);
  for (Vec2& uv : mesh.uvs) uv.x() = std::abs(uv.x() - 0.5);
  const UvLayout layout = find_uv_layout(mesh);
  EXPECT_NEAR(layout.overlap_share, 1.0, 0.05);  // centers on the diagonals of the cells count for no one
  EXPECT_NE(layout.problem, "");
}

TEST(UvLayout, WellMadeFilesHaveNoProblem) {
  PATINATE_REQUIRE_DATA(meshes, "meshes");
  for (const char* file : {"spot/spot_triangulated.obj", "blub/blub_triangulated.obj", "sphere/icosphere5_smart_uv.obj",
                           "plane/plane.obj", "marble_bust/marble_bust_01_1k.gltf"}) {
    const UvLayout layout = find_uv_layout(read_mesh(meshes / file));
    EXPECT_EQ(layout.problem, "") << file;
    EXPECT_EQ(layout.rule, UvLayoutRule::Square) << file;
  }
  const Mesh hydrants = read_mesh(meshes / "fire_hydrant/fire_hydrant_1k.gltf");
  EXPECT_EQ(find_uv_layout(hydrants).rule, UvLayoutRule::Material);  // clean and aged share all UVs
  EXPECT_EQ(find_uv_layout(select_surfaces(hydrants, "", "fire_hydrant")).problem, "");
}

}  // namespace
}  // namespace patinate
