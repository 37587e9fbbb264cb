#include <cmath>
#include <limits>

#include "libcommon/core/random.h"
#include "simulation/tracing/device_rays.h"

namespace patinate::simulation {

namespace {

/// A square of 2 x 32 x 32 triangles whose corners lie anywhere within a step of their places.
Mesh rough_surface() {
  constexpr int kCells = 32;
  Mesh mesh;
  for (int y = 0; y <= kCells; ++y) {
    for (int x = 0; x <= kCells; ++x) {
      RandomStream random(5, static_cast<std::uint64_t>(y * (kCells + 1) + x));
      const double dx = random.uniform(), dy = random.uniform(), dz = random.uniform();
      mesh.positions.emplace_back(x + 0.9 * dx, y + 0.9 * dy, 2.0 * dz);
    }
  }
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const int i = y * (kCells + 1) + x;
      mesh.triangles.push_back({i, i + 1, i + kCells + 2});
      mesh.triangles.push_back({i, i + kCells + 2, i + kCells + 1});
    }
  }
  return mesh;
}

/// From near and far, along the surface and an axis, through corners, short ones, and what is no ray.
RayQuery any_ray(const Mesh& mesh, std::uint64_t number) {
  RandomStream random(6, number);
  const auto place = [&] {
    return Vec3(40.0 * random.uniform() - 4.0, 40.0 * random.uniform() - 4.0, 6.0 * random.uniform() - 2.0);
  };
  const Vec3 target =
      number % 4 == 0 ? mesh.positions[random.below(static_cast<std::uint32_t>(mesh.positions.size()))] : place();
  Vec3 origin = place();
  if (number % 8 == 3) origin = target + 1000.0 * (origin - target);
  if (number % 8 == 5) origin = Vec3(target.x(), target.y(), 10.0);
  Vec3 direction = target - origin;
  if (number % 64 == 7) direction = Vec3::Zero();
  if (number % 64 == 15) origin.x() = std::numeric_limits<double>::quiet_NaN();
  RayQuery query{};
  query.min_distance = number % 16 == 1 ? 0.5 : 0.0;
  query.max_distance = number % 8 == 1 ? 0.75 : 1e30;
  for (Eigen::Index a = 0; a < 3; ++a) {
    query.origin[a] = origin[a];
    query.direction[a] = direction[a];
  }
  return query;
}

}  // namespace

device::CheckResult check_rays(const device::Device& device) {
  constexpr std::uint64_t kRays = 4096;
  const Mesh mesh = rough_surface();
  const RayTracer rays(mesh);
  std::vector<RayQuery> queries;
  for (std::uint64_t i = 0; i < kRays; ++i) queries.push_back(any_ray(mesh, i));
  const std::vector<RayAnswer> found = DeviceRays(device, rays).first_hits(queries);
  device::CheckResult check{.num_items = static_cast<std::int64_t>(kRays)};
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const RayQuery& q = queries[i];
    const TriangleHit hit =
        rays.first_hit(Vec3(q.origin[0], q.origin[1], q.origin[2]),
                       Vec3(q.direction[0], q.direction[1], q.direction[2]), q.min_distance, q.max_distance);
    const RayAnswer& there = found[i];
    const bool is_equal = hit.triangle == there.triangle && hit.b1 == there.b1 && hit.b2 == there.b2 &&
                          hit.distance == there.distance && hit.is_front == (there.is_front != 0);
    check.num_different += is_equal ? 0 : 1;
  }
  return check;
}

}  // namespace patinate::simulation
