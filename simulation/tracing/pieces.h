/// \file
/// One gammaton's way through a scene, piece by piece: what trace() and respond() are made of.
#pragma once

#include "patinate/simulation/scene.h"
#include "simulation/tracing/clearance.h"
#include "simulation/tracing/free_space.h"
#include "simulation/tracing/gammatons.h"
#include "simulation/tracing/ray_tracer.h"
#include "simulation/tracing/surface_links.h"
#include "simulation/tracing/triangle_frames.h"

namespace patinate::simulation {

/// What all gammatons of a call share.
struct MotionScene {
  const RayTracer& rays;
  const TriangleFrames& frames;
  const SurfaceLinks& links;
  const FreeSpace& free_space;
  Clearance& clearance;  ///< Of epsilon.
  TracingOptions options;
  Vec3 gravity{0, 0, 0};     ///< mm/s^2.
  double skin = 0.0;         ///< mm: what starts on a surface starts this far from it.
  double rest_cosine = 1.0;  ///< Of rest_slope.
};
[[nodiscard]] MotionScene motion_scene(const Scene& scene, const RayTracer& rays, const TriangleFrames& frames,
                                       const SurfaceLinks& links, const FreeSpace& free_space, Clearance& clearance);

/// A gammaton taken out of its arrays.
struct Gammaton {
  GammatonState state = GammatonState::Flying;
  bool is_front = true;
  SurfacePlace at;
  Vec3 position{0, 0, 0};
  Vec3 velocity{0, 0, 0};
};

enum class PieceEnd { Flying, Contact, Left, Rested };

/// One piece of flight: exact at its end, x + v t + g t^2 / 2 and v + g t. In free space it is as long as that is known
/// to reach; near triangles so short that its chord is nowhere farther than epsilon from the way, and a hit of the
/// chord is moved along the parabola onto the triangle's plane if it is then still in the triangle. Outside of the box
/// of all triangles one piece leads to its border, or Left when it will never be there.
[[nodiscard]] PieceEnd fly(const MotionScene& scene, Gammaton& gammaton);

/// A floating gammaton's way to its next contact: epsilon / pull times [0.5, 1), another share each time, so that those
/// who come one after another do not step into each other's footprints. Measured along the surface, from triangle to
/// triangle as if they were laid flat (SurfaceWalk), under gravity's tangential part: where it lands does not depend on
/// how the surface is divided into triangles. It hovers meanwhile, at first at epsilon times the same share (halfway to
/// what is nearer above), and sinks evenly; a ray along that way finds what else is there. Where the surface ends or
/// rises steeply, or its triangles are too many, it moves ahead along the tangent plane and sinks by `pull` per length;
/// where it finds nothing within `reach` it looks back to where it came from, below the surface there: round an edge.
/// Flying when nothing is there either. A way that stays above one triangle with nothing else above it needs no ray.
/// @param random      Uniform over its range: says how far it goes.
/// @param num_pieces  Pieces are added: one, and one more for each sharp edge or look back.
[[nodiscard]] PieceEnd float_on(const MotionScene& scene, Gammaton& gammaton, std::uint32_t random,
                                std::int64_t& num_pieces);

}  // namespace patinate::simulation
