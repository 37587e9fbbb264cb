#include "simulation/tracing/device_rays.h"

#include <gtest/gtest.h>

#include "libcommon/core/random.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/support/on_devices.h"

namespace patinate::simulation {
namespace {

using device::Device;
using device::DeviceInfo;

class RaysOnDevices : public testing_support::OnDevices<> {};

TEST_F(RaysOnDevices, PassTheirOwnCheck) {
  for (const DeviceInfo& info : all) {
    const device::CheckResult check = check_rays(Device(info));
    EXPECT_TRUE(check.is_passed()) << info.name << ": " << check.num_different << " of " << check.num_items;
  }
}

// From inside and outside of a surface, some of whose triangles have no area; more rays than one launch takes, a number
// that is no multiple of a group.
TEST_F(RaysOnDevices, HitWhatTheCpuHits) {
  constexpr std::size_t kRays = (std::size_t{1} << 18) + 777;
  Mesh mesh = testing_support::make_icosphere(100.0, 4);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 7) mesh.triangles[t][2] = mesh.triangles[t][t % 2];
  const RayTracer rays(mesh);
  std::vector<RayQuery> queries(kRays);
  for (std::size_t i = 0; i < kRays; ++i) {
    RandomStream random(2, i);
    for (int a = 0; a < 3; ++a) {
      queries[i].origin[a] = 300.0 * (random.uniform() - 0.5);
      queries[i].direction[a] = random.uniform() - 0.5;
    }
    queries[i].max_distance = i % 3 == 0 ? 80.0 : 1e30;
  }
  for (const DeviceInfo& info : all) {
    const std::vector<RayAnswer> found = DeviceRays(Device(info), rays).first_hits(queries);
    std::size_t num_hits = 0, num_different = 0;
    for (std::size_t i = 0; i < kRays; ++i) {
      const RayQuery& q = queries[i];
      const TriangleHit hit = rays.first_hit({q.origin[0], q.origin[1], q.origin[2]},
                                             {q.direction[0], q.direction[1], q.direction[2]}, 0.0, q.max_distance);
      num_hits += hit.triangle >= 0 ? 1 : 0;
      if (hit.triangle != found[i].triangle || hit.b1 != found[i].b1 || hit.b2 != found[i].b2 ||
          hit.distance != found[i].distance || hit.is_front != (found[i].is_front != 0))
        ++num_different;
    }
    EXPECT_EQ(num_different, 0U) << info.name;
    EXPECT_GT(num_hits, kRays / 8) << "the comparison has looked at something";
  }
}

TEST_F(RaysOnDevices, HitNothingWhereThereIsNothing) {
  const std::vector<RayQuery> queries(3, RayQuery{.origin = {0, 0, 0}, .direction = {1, 0, 0}, .max_distance = 1e30});
  for (const RayAnswer& answer : DeviceRays(Device(all[0]), RayTracer(Mesh{})).first_hits(queries))
    EXPECT_EQ(answer.triangle, -1);
}

}  // namespace
}  // namespace patinate::simulation
