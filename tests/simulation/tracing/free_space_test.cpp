#include "simulation/tracing/free_space.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libcommon/core/random.h"
#include "simulation/tracing/ray_tracer.h"
#include "tests/libcommon/geometry/shapes.h"

namespace patinate::simulation {
namespace {

using testing_support::make_icosphere;

TEST(FreeSpace, NothingLiesNearerThanItSays) {
  const RayTracer rays(make_icosphere(50.0, 3));
  const FreeSpace free_space(rays);
  RandomStream random(1, 0);
  int num_free = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p = 100.0 * Vec3(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
    const double free = free_space.distance(p);
    num_free += free > 0.0 ? 1 : 0;
    // A ball's surface is |50 - |p|| away in the Euclidean norm, at most sqrt(3) times the maximum norm; facets lie a
    // little within.
    EXPECT_LE(free, std::abs(50.0 - p.norm()) + 0.3);
    const Vec3 d = Vec3(random.normal(), random.normal(), random.normal());
    EXPECT_EQ(rays.first_hit(p, d / d.cwiseAbs().maxCoeff(), 0.0, free).triangle, -1);
  }
  EXPECT_GT(num_free, 10000);
}

}  // namespace
}  // namespace patinate::simulation
