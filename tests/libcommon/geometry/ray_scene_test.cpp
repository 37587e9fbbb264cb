#include "libcommon/geometry/ray_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/libcommon/geometry/shapes.h"

namespace patinate {
namespace {

constexpr double kFloat = 1e-5;  // Embree computes in float

TEST(RayScene, HitsTheSphereWhereTheFormulaSaysAndGivesItsBarycentrics) {
  const double radius = 2.0;
  Mesh sphere = testing_support::make_icosphere(radius, 4);
  const Vec3 center(1e5, 0, 0);  // far from the origin: float coordinates are kept relative to the mesh
  for (Vec3& p : sphere.positions) p += center;
  const RayScene scene(sphere);
  RandomStream random(1, 0);
  for (int i = 0; i < 200; ++i) {
    const Vec3 direction = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    const auto hit = scene.first_hit(center + 5.0 * direction, -direction);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance, 3.0, 0.01);  // facets lie inside by up to h^2 / 8R
    const Triangle& t = sphere.triangles[hit->triangle];
    const auto at = [&](std::size_t k) { return sphere.positions[t[k]]; };
    const Vec3 point = (1 - hit->b1 - hit->b2) * at(0) + hit->b1 * at(1) + hit->b2 * at(2);
    EXPECT_LT((point - (center + (5.0 - hit->distance) * direction)).norm(), kFloat * 5);
  }
  EXPECT_FALSE(scene.first_hit(center + Vec3(5, 0, 0), Vec3::UnitX()));
}

TEST(RayScene, KeepsToItsRangeOfDistances) {
  const RayScene scene(testing_support::make_cube(1.0));
  const Vec3 origin(0.3, 0.4, -1.0);
  EXPECT_NEAR(scene.first_hit(origin, Vec3::UnitZ())->distance, 1.0, kFloat);
  EXPECT_NEAR(scene.first_hit(origin, Vec3::UnitZ(), 1.5)->distance, 2.0, kFloat);
  EXPECT_FALSE(scene.first_hit(origin, Vec3::UnitZ(), 0.0, 0.9));
  EXPECT_TRUE(scene.is_blocked_along(origin, Vec3::UnitZ()));
  EXPECT_TRUE(scene.is_blocked_along(origin, Vec3::UnitZ(), 1.1));
  EXPECT_FALSE(scene.is_blocked_along(origin, Vec3::UnitZ(), 0.9));
  EXPECT_FALSE(scene.is_blocked_along(origin, -Vec3::UnitZ(), std::numeric_limits<double>::infinity()));
}

// A single ray is the truth: eight at once must find the same. Rays start beside a cube, so that some miss it.
TEST(RayScene, EightAtOnceFindWhatOneByOneFind) {
  const RayScene scene(testing_support::make_cube(1.0));
  const Vec3 origin(0.5, 0.5, -1.0);
  std::vector<Vec3> origins, directions;
  std::vector<double> distances;
  for (int i = 0; i < 8; ++i) {
    origins.emplace_back(0.3 * i - 0.1, 0.4, -1.0);
    directions.push_back((Vec3(0.3 * i - 0.1, 0.5, 0.0) - origin).normalized());
    distances.push_back(i % 3 == 2 ? 0.5 : 2.0);  // Nothing lies within 0.5.
  }
  for (const std::size_t n : {8, 3}) {
    const unsigned side_by_side = scene.blocked_of_8(std::span(origins).first(n), Vec3::UnitZ(), 2.0);
    const unsigned fan = scene.blocked_of_8(origin, std::span(directions).first(n), std::span(distances).first(n));
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ((side_by_side >> i & 1u) != 0u, scene.is_blocked_along(origins[i], Vec3::UnitZ(), 2.0)) << i;
      EXPECT_EQ((fan >> i & 1u) != 0u, scene.is_blocked_along(origin, directions[i], distances[i])) << i;
    }
    EXPECT_EQ(side_by_side >> n, 0u);
    EXPECT_EQ(fan >> n, 0u);
    EXPECT_NE(fan, 0u);
  }
  EXPECT_THROW((void)scene.blocked_of_8(std::vector<Vec3>(9, origin), Vec3::UnitZ(), 2.0), InvalidInput);
}

TEST(RayScene, SegmentsAreBlockedOnlyBetweenTheirEnds) {
  const RayScene scene(testing_support::make_cube(1.0));
  EXPECT_TRUE(scene.is_blocked(Vec3(0.3, 0.4, -1), Vec3(0.3, 0.4, 2), 1e-3));
  EXPECT_FALSE(scene.is_blocked(Vec3(0.3, 0.4, -1), Vec3(0.3, 0.4, 0), 1e-3));
  EXPECT_FALSE(scene.is_blocked(Vec3(0.3, 0.4, 0), Vec3(0.3, 0.4, 1), 1e-3));
  EXPECT_FALSE(scene.is_blocked(Vec3(2, 2, 2), Vec3(2, 2, 2), 1e-3));
}

TEST(RayScene, RaysDoNotSlipThroughEdges) {
  const RayScene scene(testing_support::make_icosphere(1.0, 2));
  const Mesh sphere = testing_support::make_icosphere(1.0, 2);
  for (const Vec3& p : sphere.positions) EXPECT_TRUE(scene.first_hit(3.0 * p, -p.normalized()));
}

TEST(RayScene, OfAnEmptyMeshIsNeverHit) {
  const RayScene scene{Mesh{}};
  EXPECT_FALSE(scene.first_hit(Vec3::Zero(), Vec3::UnitX()));
  EXPECT_FALSE(scene.is_blocked(Vec3::Zero(), Vec3::UnitX(), 0.0));
}

}  // namespace
}  // namespace patinate
