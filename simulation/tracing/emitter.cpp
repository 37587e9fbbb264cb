#include "simulation/tracing/emitter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "simulation/tracing/random_direction.h"

namespace patinate::simulation {

namespace {

using namespace direction_types;
using random_kernel::random_next;
using random_kernel::random_state;
using random_kernel::RandomState;
#include "simulation/tracing/birth_kernel.inl"

constexpr double kWidestSky = 80.0 / 360.0;  // turns: flatter rays would need a sky without end

/// The first side is as near to world x as the direction allows.
void set_frame(PlacedEmitter& placed) {
  const Vec3& d = placed.direction;
  Vec3 u = Vec3::UnitX() - d.x() * d;
  if (!(u.norm() > 1e-6)) u = Vec3::UnitZ() - d.z() * d;
  placed.u = u.normalized();
  placed.v = d.cross(placed.u);
}

/// Time to travel `depth` along the direction, or to the turning point.
double time_to_depth(double depth, double speed, double acceleration) {
  const double discriminant = speed * speed + 2.0 * acceleration * depth;
  if (discriminant < 0.0) return -speed / acceleration;
  const double root = std::sqrt(discriminant);
  return speed + root > 0.0 ? 2.0 * depth / (speed + root) : 0.0;
}

void place_sky(PlacedEmitter& placed, double spread_deg, const Box& box, const Vec3& gravity) {
  const Vec3 half = 0.5 * (box.high - box.low);
  const Vec3& d = placed.direction;
  const auto half_extent = [&](const Vec3& axis) { return axis.cwiseAbs().dot(half); };
  const double above = 1e-3 * box.diagonal() + half_extent(d);
  const double depth = above + half_extent(d);
  const SineCosine widest = portable_sine_cosine(std::min(spread_deg / 360.0, kWidestSky));
  // Where the cone's rim and axis are when they leave the box.
  Vec2 low(0, 0), high(0, 0);
  for (int k = 0; k <= 16; ++k) {
    const SineCosine turn = portable_sine_cosine(k / 16.0);
    const double sine = k == 16 ? 0.0 : widest.sine;
    const double time = time_to_depth(depth, placed.speed * (k == 16 ? 1.0 : widest.cosine), gravity.dot(d));
    const Vec2 gone(time * placed.speed * sine * turn.cosine + 0.5 * time * time * gravity.dot(placed.u),
                    time * placed.speed * sine * turn.sine + 0.5 * time * time * gravity.dot(placed.v));
    low = low.cwiseMin(gone);
    high = high.cwiseMax(gone);
  }
  const double least = 1e-3 * box.diagonal();
  placed.shape = EmitterShape::Rectangle;
  placed.half_u = half_extent(placed.u) + 0.5 * (high.x() - low.x()) + least;
  placed.half_v = half_extent(placed.v) + 0.5 * (high.y() - low.y()) + least;
  placed.center =
      box.center() - above * d - 0.5 * (low.x() + high.x()) * placed.u - 0.5 * (low.y() + high.y()) * placed.v;
}

Vec3 nearest_on_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 ab = b - a, ac = c - a, n = ab.cross(ac);
  const double area = n.squaredNorm();
  if (area > 0.0) {
    const Vec3 ap = p - a;
    const double v = ap.cross(ac).dot(n) / area, w = ab.cross(ap).dot(n) / area;
    if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) return a + v * ab + w * ac;
  }
  const auto on_edge = [&](const Vec3& from, const Vec3& to) {
    const double length = (to - from).squaredNorm();
    return Vec3(from + (length > 0.0 ? std::clamp((p - from).dot(to - from) / length, 0.0, 1.0) : 0.0) * (to - from));
  };
  Vec3 best = on_edge(a, b);
  for (const Vec3& other : {on_edge(b, c), on_edge(c, a)}) {
    if ((other - p).squaredNorm() < (best - p).squaredNorm()) best = other;
  }
  return best;
}

void place_on_surface(PlacedEmitter& placed, const Emitter& emitter, const SceneMesh& scene_mesh,
                      const RayTracer& tracer) {
  const NearestOnMesh nearest = nearest_on_mesh(scene_mesh.mesh, emitter.position_mm);
  if (nearest.triangle < 0) throw InvalidInput("emitter '" + emitter.name + "' sits on a surface, and there is none");
  Vec3 normal = area_vector(scene_mesh.mesh, nearest.triangle).normalized();
  if (!normal.allFinite())
    throw InvalidInput("emitter '" + emitter.name + "' sits on a triangle without area; move it");
  if (signed_volume(scene_mesh, scene_mesh.object[nearest.triangle]) < 0.0) normal = -normal;
  double distance = emitter.distance_mm;
  const double skin = 1e-6 * bounding_box(scene_mesh.mesh).diagonal();
  const TriangleHit above = tracer.first_hit(nearest.point, normal, skin, distance);
  if (above.triangle >= 0) distance = 0.5 * above.distance;
  placed.shape = EmitterShape::Disk;
  placed.center = nearest.point + distance * normal;
  placed.direction = -normal;
  set_frame(placed);
  placed.half_u = placed.half_v = 0.5 * emitter.size_mm[0];
}

}  // namespace

double signed_volume(const SceneMesh& scene_mesh, int object) {
  const Mesh& mesh = scene_mesh.mesh;
  const Vec3 origin = bounding_box(mesh).center();
  double six_volumes = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (scene_mesh.object[t] != object) continue;
    const auto p = [&](std::size_t k) { return Vec3(mesh.positions[mesh.triangles[t][k]] - origin); };
    six_volumes += p(0).dot(p(1).cross(p(2)));
  }
  return six_volumes / 6.0;
}

NearestOnMesh nearest_on_mesh(const Mesh& mesh, const Vec3& p) {
  NearestOnMesh best;
  double best_distance = std::numeric_limits<double>::infinity();
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const Triangle& c = mesh.triangles[t];
    const auto corner = [&](std::size_t k) -> const Vec3& { return mesh.positions[c[k]]; };
    const Vec3 q = nearest_on_triangle(corner(0), corner(1), corner(2), p);
    const double distance = (q - p).squaredNorm();
    if (distance < best_distance) {
      best_distance = distance;
      best = {.triangle = t, .point = q};
    }
  }
  return best;
}

PlacedEmitter place_emitter(const Emitter& emitter, const SceneMesh& scene_mesh, const RayTracer& tracer,
                            const Vec3& gravity_mm_s2) {
  PlacedEmitter placed{
      .shape = emitter.shape, .center = emitter.position_mm, .direction = emitter.direction.normalized()};
  placed.spread_cosine = portable_sine_cosine(emitter.spread_deg / 360.0).cosine;
  placed.speed = emitter.speed_mm_s;
  if (emitter.shape == EmitterShape::Sky && emitter.wind_mm_s != Vec3::Zero()) {
    const Vec3 velocity = placed.speed * placed.direction + emitter.wind_mm_s;
    placed.speed = velocity.norm();
    placed.direction = velocity / placed.speed;
  }
  set_frame(placed);
  placed.half_u = 0.5 * emitter.size_mm[0];
  placed.half_v = 0.5 * emitter.size_mm[emitter.shape == EmitterShape::Rectangle ? 1 : 0];
  if (emitter.shape == EmitterShape::Sky) place_sky(placed, emitter.spread_deg, tracer.box(), gravity_mm_s2);
  if (emitter.shape == EmitterShape::Surface) place_on_surface(placed, emitter, scene_mesh, tracer);
  return placed;
}

EmitterFacts facts_of(const PlacedEmitter& emitter) {
  EmitterFacts facts{.center = vector_of(emitter.center),
                     .u = vector_of(emitter.u),
                     .v = vector_of(emitter.v),
                     .direction = vector_of(emitter.direction),
                     .half_u = emitter.half_u,
                     .half_v = emitter.half_v,
                     .spread_cosine = emitter.spread_cosine,
                     .speed = emitter.speed,
                     .shape = motion_types::kBornAtPoint,
                     .is_on = 1,
                     .end_born = 0xFFFFFFFFu,
                     .padding = 0};
  if (emitter.shape == EmitterShape::Disk) facts.shape = motion_types::kBornOnDisk;
  if (emitter.shape == EmitterShape::Sphere) facts.shape = motion_types::kBornOnSphere;
  if (emitter.shape == EmitterShape::Rectangle || emitter.shape == EmitterShape::Sky)
    facts.shape = motion_types::kBornOnRectangle;
  return facts;
}

Birth make_birth(const PlacedEmitter& emitter, std::uint64_t seed, std::uint32_t gammaton, std::uint32_t number) {
  const EmitterFacts facts = facts_of(emitter);
  Drop drop;
  give_birth(&facts, seed, gammaton, number, &drop);
  return {.position = vec3(drop.position), .velocity = vec3(drop.velocity)};
}

}  // namespace patinate::simulation
