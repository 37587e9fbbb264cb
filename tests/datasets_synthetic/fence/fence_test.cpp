#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/error.h"
#include "patinate/datasets/objects.h"

namespace patinate::datasets {
namespace {

/// Volume by the divergence theorem, and whether every edge has two triangles.
double closed_volume(const Mesh& mesh) {
  double volume = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const auto p = [&](std::size_t k) { return mesh.positions[t[k]]; };
    volume += p(0).dot(p(1).cross(p(2))) / 6.0;
  }
  for (const std::array<int, 3>& around : triangle_neighbors(mesh)) {
    for (const int n : around) EXPECT_GE(n, 0);
  }
  return volume;
}

TEST(Fence, IsMadeOfClosedBodiesThatFaceOutward) {
  const Mesh mesh = fence({.num_planks = 5, .cells = 6});
  const Box box = bounding_box(mesh);
  EXPECT_NEAR(box.low.y(), 0.0, 1e-9);  // posts stand on the ground
  EXPECT_NEAR(box.high.y(), 1.04 * 900.0, 1e-9);
  EXPECT_NEAR(box.low.x() + box.high.x(), 0.0, 1e-9);
  // Posts alone are two times 90 x 90 x some 929; planks five times some 100 x 21.6 x 830, rails two times some 620 x
  // 67 x 49.
  EXPECT_NEAR(closed_volume(mesh), 2 * 7.5e6 + 5 * 1.8e6 + 2 * 2.1e6, 3e6);
}

TEST(Fence, UvsDoNotOverlap) {
  const TexelMap map(fence(), 512, 512);
  EXPECT_EQ(map.num_overlapping(), 0);
  EXPECT_GT(map.num_covered(), 512 * 512 / 2);
}

TEST(Fence, GrainRunsAlongPlanks) {
  const FenceOptions options{.num_planks = 4, .texture_px = 256};
  const ImageF grain = fence_grain(options);
  const TexelMap map(fence(options), 256, 256);
  double along = 0.0, across = 0.0;
  for (TexelId t = 256; t < map.num_texels() - 256; ++t) {
    if (!map.is_covered(t) || !map.is_covered(t + 1) || !map.is_covered(t + 256)) continue;
    if (map.point(t + 1).triangle != map.point(t).triangle || map.point(t + 256).triangle != map.point(t).triangle)
      continue;
    const auto x = static_cast<int>(t % 256), y = static_cast<int>(t / 256);
    const bool is_upright =
        std::abs(map.mm_per_texel(map.point(t).triangle).col(1).y()) > 1.0;  // the texture's columns run up the fence
    const double right = std::abs(static_cast<double>(grain.at(x + 1, y, 0)) - static_cast<double>(grain.at(x, y, 0)));
    const double down = std::abs(static_cast<double>(grain.at(x, y + 1, 0)) - static_cast<double>(grain.at(x, y, 0)));
    if (!is_upright) continue;
    along += down;
    across += right;
  }
  EXPECT_GT(across, 2.0 * along);
}

TEST(Fence, EqualSeedsGiveEqualFences) {
  EXPECT_EQ(fence().positions, fence().positions);
  EXPECT_NE(fence({.seed = 2}).positions, fence().positions);
  EXPECT_EQ(fence_grain({.texture_px = 64}), fence_grain({.texture_px = 64}));
  EXPECT_THROW((void)fence({.num_planks = 0}), InvalidInput);
}

TEST(Fence, SceneIsJson) {
  const auto json = nlohmann::json::parse(fence_scene({}, "mesh.obj", "grain.png"));
  EXPECT_EQ(json["objects"][0]["mesh"], "mesh.obj");
  EXPECT_EQ(json["objects"][0]["maps"]["color"], "grain.png");
}

TEST(Ledge, CutIntoChartsItIsTheSameSurface) {
  const Mesh whole = ledge({.cells = 12}), cut = ledge({.cells = 12, .num_charts = 6});
  EXPECT_NEAR(closed_volume(cut), closed_volume(whole), 1e-3);
  EXPECT_EQ(cut.num_triangles(), whole.num_triangles());
  const TexelMap map(cut, 512, 512);
  EXPECT_EQ(map.num_overlapping(), 0);
  int num_charts = 0;
  for (TexelId t = 0; t < map.num_texels(); ++t) num_charts = std::max(num_charts, map.chart(t) + 1);
  EXPECT_GT(num_charts, 36);
}

}  // namespace
}  // namespace patinate::datasets
