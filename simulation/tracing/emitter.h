/// \file
/// Where and how gammatons are born.
#pragma once

#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/tracing/motion_facts.h"

namespace patinate::simulation {

/// An emitter in its scene: a shape in a frame of its own. Only numbers, so that another device can use it.
struct PlacedEmitter {
  EmitterShape shape =
      EmitterShape::Point;            ///< Point, Disk, Rectangle or Sphere: Sky has become a rectangle, Surface a disk.
  Vec3 center{0, 0, 0};               ///< mm.
  Vec3 u{1, 0, 0}, v{0, 0, 1};        ///< Unit, at right angles to each other and to the direction.
  Vec3 direction{0, -1, 0};           ///< Unit; mean of the directions.
  double half_u = 0.0, half_v = 0.0;  ///< Half sides, or the radius twice, mm.
  double spread_cosine = 1.0;         ///< Directions are uniform in the cone's solid angle.
  double speed = 0.0;                 ///< mm/s.
};

/// Sky: a rectangle across the direction, above the box of all triangles by 1/1000 of its diagonal, so large that every
/// place of the box gets gammatons from the whole cone (at most 80 degrees of it) with gravity bending their ways; all
/// places at right angles to the direction are rained on alike. Surface: a disk at `distance_mm` above the nearest
/// point of the surface, looking down its normal (turned outward where the object is closed); halfway to whatever is
/// nearer than that.
/// @throws InvalidInput if a Surface emitter has no surface.
[[nodiscard]] PlacedEmitter place_emitter(const Emitter& emitter, const SceneMesh& scene_mesh, const RayTracer& tracer,
                                          const Vec3& gravity_mm_s2);

struct Birth {
  Vec3 position;  ///< mm.
  Vec3 velocity;  ///< mm/s.
};

/// The `number`-th birth of a gammaton: a function of (seed, gammaton, number) alone. Uniform over the shape's area.
[[nodiscard]] Birth make_birth(const PlacedEmitter& emitter, std::uint64_t seed, std::uint32_t gammaton,
                               std::uint32_t number);

/// Facts as kernels have them.
[[nodiscard]] EmitterFacts facts_of(const PlacedEmitter& emitter);

/// Volume that an object encloses, mm^3; negative when it is inside out.
[[nodiscard]] double signed_volume(const SceneMesh& scene_mesh, int object);

/// Nearest point of a mesh, by asking every triangle (the lowest index of several).
struct NearestOnMesh {
  int triangle = -1;  ///< -1 without triangles.
  Vec3 point{0, 0, 0};
};
[[nodiscard]] NearestOnMesh nearest_on_mesh(const Mesh& mesh, const Vec3& p);

}  // namespace patinate::simulation
