#include "simulation/tracing/pieces.h"

#include <emmintrin.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "simulation/tracing/random_direction.h"

#ifdef __SSE2__
#endif

namespace patinate::simulation {

namespace {

/// Indices of positions, one for all that are equal and belong to one object.
std::vector<int> welded_positions(const SceneMesh& scene_mesh) {
  const Mesh& mesh = scene_mesh.mesh;
  std::vector<int> object(mesh.positions.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const int p : mesh.triangles[t]) object[p] = scene_mesh.object[t];
  }
  const auto key = [&](int i) {
    const Vec3& p = mesh.positions[i];
    return std::tuple(object[i], p.x(), p.y(), p.z());
  };
  std::vector<int> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const auto ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a < b;
  });
  std::vector<int> welded(mesh.positions.size());
  int first = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || key(order[i]) != key(first)) first = order[i];
    welded[order[i]] = first;
  }
  return welded;
}

/// Coordinates in a triangle's prism: barycentric weights of its corners, and the height above it.
struct PrismPoint {
  std::array<double, 3> b;
  double height;
};

/// A convex polygon: a triangle cut by five planes has at most eight corners.
struct Polygon {
  std::array<PrismPoint, 12> corner;
  std::size_t size = 0;
};

/// Part of a polygon where value(corner) >= 0.
template <class Value>
Polygon cut(const Polygon& polygon, Value&& value) {
  Polygon left;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    const PrismPoint& p = polygon.corner[i];
    const PrismPoint& q = polygon.corner[(i + 1) % polygon.size];
    const double a = value(p), b = value(q);
    if (a >= 0.0) left.corner[left.size++] = p;
    if ((a < 0.0) == (b < 0.0)) continue;
    const double s = a / (a - b);
    PrismPoint between{};
    for (std::size_t k = 0; k < 3; ++k) between.b[k] = p.b[k] + s * (q.b[k] - p.b[k]);
    between.height = p.height + s * (q.height - p.height);
    left.corner[left.size++] = between;
  }
  return left;
}

constexpr double kInside =
    0.5e-6;  // half of what moved_inside() keeps from edges: walls that stand on an edge do not cut
constexpr double kLowest = 1e-3;  // of the height: what lies in the triangle's own plane is not above it

using namespace direction_types;
using namespace ray_types;
using random_kernel::philox4x32_10;
using random_kernel::random_next;
using random_kernel::random_state;
using random_kernel::RandomState;

// Types that the kernels below leave to whoever includes them.
struct Surroundings;
using Clear = Clearance*;
using Wet = const WetPaths*;
bool is_clear(const Surroundings* s, i32 triangle, bool is_front);
double wet_amount(const Surroundings* s, i32 triangle, double b1, double b2);

// Each stands on those before it.
// clang-format off
#include "simulation/tracing/four_lanes.inl"
#include "simulation/tracing/ray_kernel.inl"
#include "simulation/tracing/flight_kernel.inl"
#include "simulation/tracing/walk_kernel.inl"
#include "simulation/tracing/floating_kernel.inl"
#include "simulation/tracing/birth_kernel.inl"
#include "simulation/tracing/response_kernel.inl"
// clang-format on

bool is_clear(const Surroundings* s, i32 triangle, bool is_front) { return s->clear->is_clear(triangle, is_front); }

double wet_amount(const Surroundings* s, i32 triangle, double b1, double b2) {
  const TexelIndex texel = s->wet->atlas->surface().texel_of(triangle, b1, b2);
  return texel == kNoTexel ? 0.0 : static_cast<double>(s->wet->atlas->amount(s->wet->material, texel)) / kAmountOne;
}

Surroundings surroundings(const MotionScene& scene) {
  return {.facts = &scene.facts,
          .nodes = scene.rays.nodes().data(),
          .blocks = scene.rays.blocks().data(),
          .frames = scene.frames.frames().data(),
          .corner_normals = scene.frames.corner_normals().data(),
          .links = scene.links.codes().data(),
          .empty_cells = scene.free_space.empty().data(),
          .clear = &scene.clearance,
          .wet = scene.wet};
}

}  // namespace

SurfaceLinks::SurfaceLinks(const SceneMesh& scene_mesh) {
  const std::vector<int> welded = welded_positions(scene_mesh);
  Mesh mesh;
  mesh.positions = scene_mesh.mesh.positions;
  mesh.triangles = scene_mesh.mesh.triangles;
  for (Triangle& t : mesh.triangles) {
    for (int& p : t) p = welded[p];
  }
  const std::vector<std::array<int, 3>> neighbors = triangle_neighbors(mesh);
  constexpr std::uint32_t kNone = motion_types::kNoLink;
  codes_.assign(neighbors.size(), TriangleLinks{.across = {kNone, kNone, kNone}});
  for (std::size_t t = 0; t < neighbors.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (neighbors[t][k] < 0) continue;
      const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      const Triangle& there = mesh.triangles[neighbors[t][k]];
      for (std::uint32_t j = 0; j < 3; ++j) {
        const int c = there[j], d = there[(j + 1) % 3];
        if (!((a == d && b == c) || (a == c && b == d))) continue;
        codes_[t].across[k] = static_cast<std::uint32_t>(neighbors[t][k]) << 3 | j << 1 | (a == c ? 1u : 0u);
        break;
      }
    }
  }
}

Clearance::Clearance(const RayTracer& rays, const TriangleFrames& frames, int num_triangles, double height_mm)
    : rays_(&rays),
      frames_(&frames),
      num_triangles_(num_triangles),
      height_(height_mm),
      known_(std::make_unique<std::atomic<std::uint8_t>[]>(static_cast<std::size_t>(num_triangles) * 2)) {}

std::vector<std::uint8_t> Clearance::all(const RunControl& control) {
  std::vector<std::uint8_t> clear(static_cast<std::size_t>(num_triangles_) * 2);
  parallel_for(num_triangles_, 256, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<int>(begin); t < end; ++t) {
      for (const int side : {0, 1}) clear[2 * t + side] = is_clear(t, side == 0) ? std::uint8_t{1} : std::uint8_t{0};
    }
  });
  return clear;
}

bool Clearance::find(int triangle, bool is_front) const {
  const Vec3 a = frames_->corner(triangle, 0), e1 = frames_->corner(triangle, 1) - a,
             e2 = frames_->corner(triangle, 2) - a;
  const Vec3 area = e1.cross(e2);
  const double square = area.squaredNorm();
  if (!(square > 0.0)) return false;
  const Vec3 up = (is_front ? 1.0 : -1.0) / std::sqrt(square) * area;
  const Vec3 gradient_1 = e2.cross(area) / square, gradient_2 = area.cross(e1) / square;
  const double top = 1.001 * height_;
  Box box;
  for (const Vec3& p : {a, Vec3(a + e1), Vec3(a + e2)}) {
    box.low = box.low.cwiseMin(p).cwiseMin(p + top * up);
    box.high = box.high.cwiseMax(p).cwiseMax(p + top * up);
  }
  return rays_->none_in_box(box, [&](int other) {
    if (other == triangle) return false;
    Polygon polygon{.corner = {}, .size = 3};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = frames_->corner(other, k) - a;
      const double b1 = p.dot(gradient_1), b2 = p.dot(gradient_2);
      polygon.corner[k] = {.b = {1.0 - b1 - b2, b1, b2}, .height = p.dot(up)};
    }
    for (std::size_t k = 0; k < 3; ++k) polygon = cut(polygon, [&](const PrismPoint& p) { return p.b[k] - kInside; });
    polygon = cut(polygon, [&](const PrismPoint& p) { return p.height - kLowest * height_; });
    polygon = cut(polygon, [&](const PrismPoint& p) { return top - p.height; });
    return polygon.size > 0;
  });
}

MotionScene motion_scene(const Scene& scene, const RayTracer& rays, const TriangleFrames& frames,
                         const SurfaceLinks& links, const FreeSpace& free_space, Clearance& clearance,
                         const WetPaths* wet) {
  const TracingOptions& o = scene.tracing;
  const Behavior& b = scene.behavior;
  const double diagonal = rays.box().diagonal();
  const MotionFacts facts{.rays = rays.frame(),
                          .box_low = vector_of(rays.box().low),
                          .box_high = vector_of(rays.box().high),
                          .box_diagonal = diagonal,
                          .center = vector_of(frames.center()),
                          .gravity = vector_of(scene.gravity_mm_s2),
                          .skin = 1e-9 * diagonal,
                          .rest_cosine = portable_sine_cosine(o.rest_slope_deg / 360.0).cosine,
                          .epsilon = o.epsilon_mm,
                          .pull = o.pull,
                          .reach = o.reach_mm,
                          .lobe_bounce = o.lobe_exponent_bounce,
                          .lobe_float = o.lobe_exponent_float,
                          .rest_speed = o.rest_speed_mm_s,
                          .bounce = b.bounce,
                          .floating = b.floating,
                          .deceleration_bounce = b.deceleration_bounce,
                          .deceleration_float = b.deceleration_float,
                          .wet_attraction = wet != nullptr ? wet->weight : 0.0,
                          .rivulet = wet != nullptr ? wet->width_mm : 0.0,
                          .space = free_space.facts(),
                          .max_segments = o.max_segments,
                          .is_slowed_tangentially = o.tangential_slowdown ? 1 : 0,
                          .has_nodes = rays.nodes().empty() ? 0 : 1,
                          .has_normals = frames.corner_normals().empty() ? 0 : 1};
  return {.rays = rays,
          .frames = frames,
          .links = links,
          .free_space = free_space,
          .clearance = clearance,
          .facts = facts,
          .wet = wet};
}

PieceEnd fly(const MotionScene& scene, Drop& drop) {
  const Surroundings s = surroundings(scene);
  return static_cast<PieceEnd>(fly_on(&s, &drop));
}

PieceEnd float_on(const MotionScene& scene, Drop& drop, std::uint32_t random, std::int64_t& num_pieces) {
  const Surroundings s = surroundings(scene);
  return static_cast<PieceEnd>(float_along(&s, &drop, random, &num_pieces));
}

Told trace_drop(const MotionScene& scene, const MotionCall& call, const EmitterFacts& emitter, std::uint32_t gammaton,
                Drop& drop, std::uint32_t& num_births) {
  const Surroundings s = surroundings(scene);
  return trace_one(&s, &call, &emitter, gammaton, &drop, &num_births);
}

Outcome respond_to_contact(const MotionScene& scene, const MotionCall& call, std::uint32_t gammaton, Drop& drop,
                           const Vec3& front_normal) {
  const Surroundings s = surroundings(scene);
  return static_cast<Outcome>(respond_to(&s, &call, gammaton, &drop, vector_of(front_normal)));
}

Vec3 shading_normal(const MotionScene& scene, const SurfacePlace& at) {
  const Surroundings s = surroundings(scene);
  return vec3(shading_normal_of(&s, at));
}

Vec3 point(const MotionScene& scene, const SurfacePlace& at) {
  const Surroundings s = surroundings(scene);
  return vec3(point_of(&s, at));
}

}  // namespace patinate::simulation
