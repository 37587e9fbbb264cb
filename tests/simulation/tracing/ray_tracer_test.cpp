#include "simulation/tracing/ray_tracer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "libcommon/core/random.h"
#include "libcommon/geometry/ray_scene.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/support/test_data.h"

namespace patinate::simulation {
namespace {

using testing_support::make_cube;
using testing_support::make_icosphere;
using testing_support::make_patch;

Vec3 random_vector(RandomStream& random) {
  return {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
}

/// A bumpy closed surface with triangles of very different sizes.
Mesh bumpy_sphere(int levels) {
  Mesh mesh = make_icosphere(100.0, levels);
  for (Vec3& p : mesh.positions)
    p *= 1.0 + 0.2 * std::sin(p.x() * 0.1) * std::cos(p.y() * 0.13) * std::sin(p.z() * 0.07 + 1.0);
  return mesh;
}

TEST(RayTracer, FindsWhatAskingEveryTriangleFinds) {
  const Mesh mesh = bumpy_sphere(4);
  const RayTracer tracer(mesh);
  RandomStream random(1, 0);
  int num_hits = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 origin = 300.0 * random_vector(random);
    const Vec3 direction = random_vector(random);
    const double max = i % 3 == 0 ? 50.0 : 1e30;
    const TriangleHit fast = tracer.first_hit(origin, direction, 0.0, max);
    const TriangleHit slow = tracer.first_hit_of_all(origin, direction, 0.0, max);
    ASSERT_EQ(fast.triangle, slow.triangle) << i;
    if (fast.triangle < 0) continue;
    ++num_hits;
    EXPECT_EQ(fast.distance, slow.distance);
    EXPECT_EQ(fast.b1, slow.b1);
    EXPECT_GE(fast.b1, 0.0);
    EXPECT_GE(fast.b2, 0.0);
    EXPECT_LE(fast.b1 + fast.b2, 1.0 + 1e-15);
    const Vec3 n = area_vector(mesh, fast.triangle);
    EXPECT_EQ(fast.is_front, n.dot(direction) < 0.0);
  }
  EXPECT_GT(num_hits, 500);
}

TEST(RayTracer, AgreesWithEmbreeToRounding) {
  const Mesh mesh = bumpy_sphere(5);
  const RayTracer tracer(mesh);
  const RayScene embree(mesh);
  constexpr double kRounding = 2e-3;  // float coordinates of 300 mm, seen at an angle: 100 roundings
  RandomStream random(2, 0);
  int num_others = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 origin = 300.0 * random_vector(random);
    const Vec3 direction = random_vector(random).normalized();
    const TriangleHit ours = tracer.first_hit(origin, direction, 0.0, 1e30);
    const auto theirs = embree.first_hit(origin, direction);
    if ((ours.triangle >= 0) != theirs.has_value() ||
        (theirs && std::abs(ours.distance - theirs->distance) > kRounding))
      ++num_others;
  }
  EXPECT_LE(num_others, 2) << "a silhouette grazed within rounding may be seen by one alone";
}

TEST(RayTracer, NothingPassesThroughEdgesAndCornersOfAClosedMesh) {
  // From inside at a point of an edge or at a corner: every ray must hit.
  const Mesh mesh = bumpy_sphere(4);
  const RayTracer tracer(mesh);
  RandomStream random(3, 0);
  int num_lost = 0;
  for (int i = 0; i < testing_support::sample_count(1000000); ++i) {
    const auto t = static_cast<std::size_t>(random.below(static_cast<std::uint32_t>(mesh.num_triangles())));
    const auto corner = [&](std::size_t k) { return mesh.positions[mesh.triangles[t][k]]; };
    const double s = i % 4 == 0 ? 0.0 : random.uniform();
    const Vec3 target = (1.0 - s) * corner(0) + s * corner(1);
    const Vec3 origin = i % 2 == 0 ? Vec3::Zero() : Vec3(60.0 * random_vector(random));
    if (tracer.first_hit(origin, target - origin, 0.0, 2.0).triangle < 0) ++num_lost;
  }
  EXPECT_EQ(num_lost, 0);
}

TEST(RayTracer, GrazingRaysHitABoxAsOftenAsTheyEnterIt) {
  // Along the faces of a cube, edge-on, exactly in their planes: a ray that starts outside and ends inside hits
  // something.
  const Mesh mesh = make_cube(10.0);
  const RayTracer tracer(mesh);
  RandomStream random(4, 0);
  for (int i = 0; i < testing_support::sample_count(100000); ++i) {
    const Vec3 inside(10.0 * random.uniform(), 10.0 * random.uniform(), i % 2 == 0 ? 0.0 : 10.0);  // in a face
    const Vec3 outside(i % 4 < 2 ? -5.0 : 15.0, inside.y(), inside.z());
    ASSERT_GE(tracer.first_hit(outside, inside - outside, 0.0, 1.0).triangle, 0) << i;
  }
}

TEST(RayTracer, IntervalIsOpenBelowAndClosedAbove) {
  const RayTracer tracer(make_cube(10.0));
  const Vec3 origin(3, 4, -5), up(0, 0, 1);
  EXPECT_EQ(tracer.first_hit(origin, up, 0.0, 1e30).distance, 5.0);
  EXPECT_TRUE(tracer.first_hit(origin, up, 0.0, 1e30).is_front);
  EXPECT_EQ(tracer.first_hit(origin, up, 5.0, 1e30).distance, 15.0);
  EXPECT_FALSE(tracer.first_hit(origin, up, 5.0, 1e30).is_front);
  EXPECT_EQ(tracer.first_hit(origin, up, 0.0, 5.0).distance, 5.0);
  EXPECT_EQ(tracer.first_hit(origin, up, 0.0, 4.999).triangle, -1);
  EXPECT_EQ(tracer.first_hit(origin, 0.5 * up, 0.0, 10.0).distance, 10.0)
      << "distances are in lengths of the direction";
}

TEST(RayTracer, OfSeveralAtOneDistanceTheLowestIndexIsHit) {
  Mesh mesh = make_patch(8, 8, [](double u, double v) { return Vec3(u, v, 0.0); });
  const std::size_t n = mesh.triangles.size();
  for (std::size_t i = 0; i < n; ++i) mesh.triangles.push_back(mesh.triangles[n - 1 - i]);
  const RayTracer tracer(mesh);
  for (int i = 1; i < 8; ++i) {
    // A corner of the grid: six triangles below, and their doubles.
    const TriangleHit hit = tracer.first_hit({i / 8.0, 0.5, 1.0}, {0, 0, -1}, 0.0, 2.0);
    EXPECT_EQ(hit.triangle, tracer.first_hit_of_all({i / 8.0, 0.5, 1.0}, {0, 0, -1}, 0.0, 2.0).triangle);
    EXPECT_LT(hit.triangle, static_cast<int>(n));
  }
}

TEST(RayTracer, FarOriginsLoseNoPrecision) {
  const RayTracer tracer(make_icosphere(10.0, 4));
  const Vec3 target(0.3, 0.2, 0.1);
  const Vec3 direction = Vec3(0.3, -0.5, 0.7).normalized();
  const TriangleHit near = tracer.first_hit(target - 100.0 * direction, direction, 0.0, 1e30);
  const TriangleHit far = tracer.first_hit(target - 1e6 * direction, direction, 0.0, 1e30);
  EXPECT_EQ(near.triangle, far.triangle);
  EXPECT_NEAR(far.distance - near.distance, 1e6 - 100.0, 1e-8);
}

TEST(RayTracer, TakesDegenerateInput) {
  EXPECT_EQ(RayTracer(Mesh{}).first_hit({0, 0, 0}, {0, 0, 1}, 0.0, 1e30).triangle, -1);
  Mesh mesh = make_cube(1.0);
  mesh.triangles.push_back({0, 0, 1});
  mesh.triangles.push_back({2, 2, 2});
  for (int i = 0; i < 40; ++i) mesh.triangles.push_back({0, 1, 5});  // many with one middle
  const RayTracer tracer(mesh);
  EXPECT_EQ(tracer.first_hit({0.5, 0.5, -1}, {0, 0, 0}, 0.0, 1e30).triangle, -1);
  EXPECT_EQ(tracer.first_hit({std::nan(""), 0.5, -1}, {0, 0, 1}, 0.0, 1e30).triangle, -1);
  EXPECT_GE(tracer.first_hit({0.4, 0.5, -1}, {0, 0, 1}, 0.0, 1e30).triangle, 0);
  EXPECT_GE(tracer.first_hit({0.4, 0.5, -1}, {1e-200, 0, 1e-200}, 0.0, 1e300).triangle, -1);
}

TEST(RayTracer, AMovedMeshIsTracedAsIfNew) {
  Mesh mesh = bumpy_sphere(3);
  RayTracer tracer(mesh);
  for (Vec3& p : mesh.positions) p += Vec3(5, -7, 30);
  tracer = RayTracer(mesh);
  const RayTracer fresh(mesh);
  ASSERT_EQ(tracer.blocks().size(), fresh.blocks().size());
  RandomStream random(5, 0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 origin = 300.0 * random_vector(random), direction = random_vector(random);
    const TriangleHit a = tracer.first_hit(origin, direction, 0.0, 1e30),
                      b = fresh.first_hit(origin, direction, 0.0, 1e30);
    EXPECT_EQ(a.triangle, b.triangle);
    EXPECT_EQ(a.distance, b.distance);
  }
}

TEST(RayTracer, SeesAHydrantAsEmbreeDoes) {
  PATINATE_REQUIRE_DATA(path, "meshes/fire_hydrant/fire_hydrant_1k.gltf");
  const Mesh mesh = read_mesh(path.string());
  const RayTracer tracer(mesh);
  const RayScene embree(mesh);
  const Box box = bounding_box(mesh);
  const double size = box.diagonal();
  RandomStream random(6, 0);
  int num_others = 0, num_hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 origin = box.center() + size * random_vector(random);
    const Vec3 direction = random_vector(random).normalized();
    const TriangleHit ours = tracer.first_hit(origin, direction, 0.0, 1e30);
    const auto theirs = embree.first_hit(origin, direction);
    num_hits += ours.triangle >= 0 ? 1 : 0;
    if ((ours.triangle >= 0) != theirs.has_value() ||
        (theirs && std::abs(ours.distance - theirs->distance) > 1e-5 * size))
      ++num_others;
  }
  EXPECT_GT(num_hits, 1000);
  EXPECT_LE(num_others, 4) << "silhouettes grazed within rounding";
}

}  // namespace
}  // namespace patinate::simulation
