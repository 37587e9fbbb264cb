#include "simulation/tracing/pieces.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "libcommon/core/random.h"
#include "simulation/tracing/random_direction.h"

namespace patinate::simulation {

namespace {

using namespace direction_types;
using namespace ray_types;
using random_kernel::philox4x32_10;
using random_kernel::random_next;
using random_kernel::random_state;
using random_kernel::RandomState;

// What the kernels below leave to whoever includes them.
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
