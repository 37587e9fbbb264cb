#include "simulation/tracing/pieces.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "libcommon/core/random.h"
#include "simulation/tracing/ray_tracer.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/simulation/tracing/tracing_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::make_icosphere;
using testing_support::scene_with;
using testing_support::with_any_uvs;

TEST(FloatOn, WithoutRaysIsAsWithRays) {
  // In a ball: a prism a meter high is cut by the other side everywhere, so that rays are asked; one of epsilon is not.
  Scene scene = scene_with(with_any_uvs(make_icosphere(50.0, 3)));
  const SceneMesh mesh = make_scene_mesh(scene);
  const RayTracer rays(mesh.mesh);
  const TriangleFrames frames(mesh, rays);
  const SurfaceLinks links(mesh);
  const FreeSpace free_space(rays);
  scene.gravity_mm_s2 = {0, -9810.0, 0};
  Clearance low(rays, frames, mesh.mesh.num_triangles(), scene.tracing.epsilon_mm),
      high(rays, frames, mesh.mesh.num_triangles(), 1e3);
  const MotionScene without = motion_scene(scene, rays, frames, links, free_space, low),
                    with = motion_scene(scene, rays, frames, links, free_space, high);
  RandomStream random(1, 0);
  int num_same = 0;
  for (int i = 0; i < 5000; ++i) {
    const auto t = static_cast<std::int32_t>(random.below(static_cast<std::uint32_t>(mesh.mesh.num_triangles())));
    EXPECT_TRUE(low.is_clear(t, false));
    EXPECT_FALSE(high.is_clear(t, false));
    const Drop from{.state = motion_types::kIsFloating,
                    .is_front = false,
                    .at = {.triangle = t, .b1 = 0.5 * random.uniform(), .b2 = 0.5 * random.uniform()},
                    .position = {},
                    .velocity = vector_of(1000.0 * Vec3(random.normal(), random.normal(), random.normal()))};
    Drop a = from, b = from;
    std::int64_t pieces_a = 0, pieces_b = 0;
    const auto hover = static_cast<std::uint32_t>(0x9E3779B9u * static_cast<std::uint32_t>(i));
    ASSERT_EQ(float_on(without, a, hover, pieces_a), float_on(with, b, hover, pieces_b));
    ASSERT_EQ(a.at.triangle, b.at.triangle);
    constexpr double kRounding = 1e-5;  // mm: normals and gradients in float, over 50 mm
    EXPECT_LT((vec3(a.position) - vec3(b.position)).norm(), kRounding);
    EXPECT_LT((vec3(a.velocity) - vec3(b.velocity)).norm(), 1e3 * kRounding);  // mm/s, of 1000
    num_same += a.at.triangle == t ? 1 : 0;
  }
  EXPECT_GT(num_same, 3000) << "most stay on their triangle";
}

}  // namespace
}  // namespace patinate::simulation
