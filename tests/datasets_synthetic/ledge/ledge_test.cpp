#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/error.h"
#include "patinate/datasets/objects.h"

namespace patinate::datasets {
namespace {

TEST(Ledge, IsMadeOfClosedBodiesThatFaceOutward) {
  const Mesh mesh = ledge({.cells = 12});
  double volume = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const auto p = [&](std::size_t k) { return mesh.positions[t[k]]; };
    volume += p(0).dot(p(1).cross(p(2))) / 6.0;
  }
  // Wall 1000 x 1000 x 100; a sill's section is a trapezoid 130 deep, 30 high in front and 30 + (0.08 + 0.8) * 130 at
  // its back.
  EXPECT_NEAR(volume, 1e8 + (480.0 + 440.0 + 400.0) * 130.0 * (30.0 + 0.44 * 130.0), 1.0);
  for (const std::array<int, 3>& around : triangle_neighbors(mesh)) {
    for (const int n : around) EXPECT_GE(n, 0);
  }
  EXPECT_NEAR(bounding_box(mesh).high.z(), 90.0, 1e-9);
}

TEST(Ledge, UvsDoNotOverlapAndAreEven) {
  const Mesh mesh = ledge();
  const TexelMap map(mesh, 512, 512);
  EXPECT_EQ(map.num_overlapping(), 0);
  EXPECT_GT(map.num_covered(), 512 * 512 / 2);
  const Eigen::Matrix<double, 3, 2> step = map.mm_per_texel(0);
  for (int t = 0; t < mesh.num_triangles(); t += 17) {
    EXPECT_NEAR(map.mm_per_texel(t).col(0).norm(), step.col(0).norm(), 1e-6);
    EXPECT_NEAR(map.mm_per_texel(t).col(1).norm(), step.col(0).norm(), 1e-6);
  }
}

TEST(Ledge, RefusesSillsThatAreTooThick) { EXPECT_THROW((void)ledge({.thickness_mm = 300}), InvalidInput); }

TEST(Ledge, SceneIsJson) {
  const auto json = nlohmann::json::parse(ledge_scene({}, "mesh.obj"));
  EXPECT_EQ(json["format"], "patinate.scene");
  EXPECT_EQ(json["objects"][0]["mesh"], "mesh.obj");
}

}  // namespace
}  // namespace patinate::datasets
