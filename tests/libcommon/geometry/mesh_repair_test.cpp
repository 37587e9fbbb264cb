#include "libcommon/geometry/mesh_repair.h"

#include <gtest/gtest.h>

#include "libcommon/geometry/mesh_key.h"
#include "libcommon/geometry/topology.h"
#include "patinate/core/error.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::make_cube;
using testing_support::make_icosphere;
using testing_support::make_patch;

Mesh patch() {
  Mesh mesh = make_patch(4, 4, [](double u, double v) { return Vec3(u, v, 0.0); });
  mesh.surfaces = {{"patch", ""}};
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  return mesh;
}

void turn_round(Mesh& mesh, std::size_t t) {
  std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  if (!mesh.uv_triangles.empty()) std::swap(mesh.uv_triangles[t][1], mesh.uv_triangles[t][2]);
  if (!mesh.normal_triangles.empty()) std::swap(mesh.normal_triangles[t][1], mesh.normal_triangles[t][2]);
}

double volume(const Mesh& mesh) {
  double sum = 0.0;
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    sum += mesh.positions[mesh.triangles[static_cast<std::size_t>(t)][0]].dot(area_vector(mesh, t)) / 6.0;
  }
  return sum;
}

TEST(RepairMesh, LeavesACleanMeshAlone) {
  for (const Mesh& mesh : {make_icosphere(3.0, 2), make_cube(2.0), patch()}) {
    const RepairedMesh repaired = repair_mesh(mesh);
    EXPECT_EQ(repaired.repairs.text(), "");
    EXPECT_EQ(mesh_content_key(repaired.mesh), mesh_content_key(mesh));
  }
}

TEST(RepairMesh, TurnsSingleTrianglesBack) {
  Mesh cube = make_cube(2.0);
  turn_round(cube, 3);
  turn_round(cube, 8);
  const RepairedMesh repaired = repair_mesh(cube);
  EXPECT_EQ(repaired.repairs.num_turned, 2);
  EXPECT_NEAR(volume(repaired.mesh), 8.0, 1e-12);  // divergence theorem
  EXPECT_TRUE(mesh_topology(repaired.mesh).is_closed());
}

TEST(RepairMesh, KeepsAPieceThatIsInsideOut) {
  Mesh cube = make_cube(1.0);
  for (std::size_t t = 0; t < cube.triangles.size(); ++t) turn_round(cube, t);
  EXPECT_EQ(repair_mesh(cube).repairs.num_turned, 0);
}

TEST(RepairMesh, TurnsNormalsThatWereMadeFromTheWrongWinding) {
  Mesh mesh = patch();
  turn_round(mesh, 5);
  mesh.normals = {{0, 0, 1}, {0, 0, -1}};
  mesh.normal_triangles.assign(mesh.triangles.size(), {0, 0, 0});
  mesh.normal_triangles[5] = {1, 1, 1};
  const Mesh repaired = repair_mesh(mesh).mesh;
  for (std::size_t t = 0; t < repaired.triangles.size(); ++t) {
    for (int n : repaired.normal_triangles[t]) EXPECT_EQ(repaired.normals[n], Vec3(0, 0, 1));
  }
}

TEST(RepairMesh, LeavesOutWhatHasNoAreaAndWhatIsThereTwice) {
  Mesh mesh = patch();
  const auto num = mesh.triangles.size();
  const auto repeat = [&mesh](std::size_t t) {
    mesh.triangles.push_back(mesh.triangles[t]);
    mesh.uv_triangles.push_back(mesh.uv_triangles[t]);
    mesh.triangle_surface.push_back(0);
  };
  repeat(2);
  repeat(7);
  turn_round(mesh, num + 1);  // The back of a sheet.
  mesh.positions.emplace_back(0.5 * (mesh.positions[0] + mesh.positions[1]));
  mesh.triangles.push_back({0, 1, static_cast<int>(mesh.positions.size()) - 1});
  mesh.uv_triangles.push_back({0, 1, 2});
  mesh.triangle_surface.push_back(0);
  const RepairedMesh repaired = repair_mesh(mesh);
  EXPECT_EQ(repaired.repairs.num_degenerate, 1);
  EXPECT_EQ(repaired.repairs.num_duplicates, 2);
  EXPECT_EQ(repaired.mesh.triangles.size(), num);
  EXPECT_EQ(mesh_content_key(repaired.mesh), mesh_content_key(patch()));
}

TEST(RepairMesh, KeepsBothSidesOfASheetThatHaveUvsOfTheirOwn) {
  Mesh mesh = patch();
  const auto num = mesh.triangles.size();
  for (std::size_t t = 0; t < num; ++t) {
    Triangle uv{};
    for (std::size_t k = 0; k < 3; ++k) {
      uv[k] = static_cast<int>(mesh.uvs.size());
      mesh.uvs.emplace_back(mesh.uvs[mesh.uv_triangles[t][k]] + Vec2(2.0, 0.0));
    }
    mesh.triangles.push_back(mesh.triangles[t]);
    mesh.uv_triangles.push_back(uv);
    mesh.triangle_surface.push_back(0);
    turn_round(mesh, mesh.triangles.size() - 1);
  }
  const RepairedMesh repaired = repair_mesh(mesh);
  EXPECT_EQ(repaired.mesh.triangles.size(), 2 * num);
  EXPECT_EQ(repaired.repairs.num_turned, 0);
  EXPECT_GT(repaired.repairs.num_complex_edges, 0);
}

TEST(RepairMesh, RefusesAMeshWithoutArea) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.triangle_surface = {0};
  mesh.surfaces = {{"", ""}};
  EXPECT_THROW((void)repair_mesh(mesh), InvalidInput);
}

TEST(RepairMesh, FindsNothingToMendInWellMadeFiles) {
  PATINATE_REQUIRE_DATA(meshes, "meshes");
  for (const char* file : {"spot/spot_triangulated.obj", "blub/blub_triangulated.obj", "sphere/icosphere5_smart_uv.obj",
                           "cylinder/cylinder.obj", "plane/plane.obj", "marble_bust/marble_bust_01_1k.gltf"}) {
    EXPECT_EQ(repair_mesh(read_mesh(meshes / file)).repairs.num_turned, 0) << file;
  }
}

}  // namespace
}  // namespace patinate
