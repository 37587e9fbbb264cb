/// \file
/// One gammaton's way through a scene: what trace() and respond() are made of. The formulas stand in kernels that
/// devices read too (flight_kernel.inl, walk_kernel.inl, floating_kernel.inl, response_kernel.inl).
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/tracing/free_space.h"
#include "simulation/tracing/gammatons.h"
#include "simulation/tracing/motion_facts.h"
#include "simulation/tracing/ray_tracer.h"
#include "simulation/tracing/triangle_frames.h"
#include "simulation/tracing/wet_paths.h"

namespace patinate::simulation {

/// Triangles of one object that share an edge, by their corners' places: UV seams, hard edges and materials do not cut.
/// Where more than two meet, those that bend least are joined (triangle_neighbors()). 12 bytes a triangle.
class SurfaceLinks {
 public:
  explicit SurfaceLinks(const SceneMesh& scene_mesh);

  /// By triangle.
  [[nodiscard]] std::span<const TriangleLinks> codes() const { return codes_; }
  void prefetch([[maybe_unused]] int triangle) const {
#if defined(__GNUC__)
    if (triangle >= 0) __builtin_prefetch(&codes_[triangle]);
#endif
  }

 private:
  std::vector<TriangleLinks> codes_;
};

/// Whether the prism that stands on one side of a triangle, `height` high, is cut by no other triangle. Found when
/// first asked for; whoever asks, and when, the answer is the same. Thread-safe.
class Clearance {
 public:
  /// @param rays, frames  Outlive it.
  Clearance(const RayTracer& rays, const TriangleFrames& frames, int num_triangles, double height_mm);

  [[nodiscard]] bool is_clear(int triangle, bool is_front) {
    std::atomic<std::uint8_t>& known = known_[static_cast<std::size_t>(triangle) * 2 + (is_front ? 0 : 1)];
    const std::uint8_t value = known.load(std::memory_order_relaxed);
    if (value != kUnknown) return value == kClear;
    const bool found = find(triangle, is_front);
    known.store(found ? kClear : kCut, std::memory_order_relaxed);
    return found;
  }
  /// Clearance of all triangles, both sides: 1 where is_clear(), else 0; by triangle, its front first.
  [[nodiscard]] std::vector<std::uint8_t> all(const RunControl& control);
  [[nodiscard]] double height_mm() const { return height_; }

 private:
  static constexpr std::uint8_t kUnknown = 0, kClear = 1, kCut = 2;
  [[nodiscard]] bool find(int triangle, bool is_front) const;

  const RayTracer* rays_;
  const TriangleFrames* frames_;
  int num_triangles_;
  double height_;
  std::unique_ptr<std::atomic<std::uint8_t>[]> known_;
};

/// Scene that all gammatons of a call share.
struct MotionScene {
  const RayTracer& rays;
  const TriangleFrames& frames;
  const SurfaceLinks& links;
  const FreeSpace& free_space;
  Clearance& clearance;  ///< Clearance at epsilon.
  MotionFacts facts;
  const WetPaths* wet = nullptr;  ///< Attracts those that float; may be null.
};
[[nodiscard]] MotionScene motion_scene(const Scene& scene, const RayTracer& rays, const TriangleFrames& frames,
                                       const SurfaceLinks& links, const FreeSpace& free_space, Clearance& clearance,
                                       const WetPaths* wet = nullptr);

enum class PieceEnd { Flying, Contact, Left, Rested };
enum class Outcome { Alive, Absorbed, Rested };

/// One piece of flight: exact at its end, x + v t + g t^2 / 2 and v + g t. In free space it is as long as that is known
/// to reach; near triangles so short that its chord is nowhere farther than epsilon from the way, and a hit of the
/// chord is moved along the parabola onto the triangle's plane if it is then still in the triangle. Outside of the box
/// of all triangles one piece leads to its border, or Left when it will never be there.
[[nodiscard]] PieceEnd fly(const MotionScene& scene, Drop& drop);

/// A floating gammaton's way to its next contact: epsilon / pull times [0.5, 1), another share each time, so that those
/// who come one after another do not step into each other's footprints. Measured along the surface, from triangle to
/// triangle as if they were laid flat (walk_kernel.inl), under gravity's tangential part: where it lands does not
/// depend on how the surface is divided into triangles. It hovers meanwhile, at first at epsilon times the same share
/// (halfway to what is nearer above), and sinks evenly; a ray along that way finds what else is there. Where the
/// surface ends or rises steeply, or its triangles are too many, it moves ahead along the tangent plane and sinks by
/// `pull` per length; where it finds nothing within `reach` it looks back to where it came from, below the surface
/// there: round an edge. Flying when nothing is there either. A way that stays above one triangle with nothing else
/// above it needs no ray.
/// @param random      Uniform over its range: says how far it goes.
/// @param num_pieces  Pieces are added: one, and one more for each sharp edge or look back.
[[nodiscard]] PieceEnd float_on(const MotionScene& scene, Drop& drop, std::uint32_t random, std::int64_t& num_pieces);

/// An iteration of one gammaton up to its contact: born where that is due, then pieces, at most
/// TracingOptions::max_segments of them. @param num_births  Of this gammaton; counted here.
[[nodiscard]] Told trace_drop(const MotionScene& scene, const MotionCall& call, const EmitterFacts& emitter,
                              std::uint32_t gammaton, Drop& drop, std::uint32_t& num_births);

/// Bounce: the velocity is reflected about `normal`, turned within a Phong lobe, again and again until it leaves the
/// triangle (after 8 tries mirrored up), and slowed down. Float: the same about the triangle's own normal, projected
/// into its plane: a smoothed normal would lead drops astray on a flat wall; on ground that hangs, within rest_slope of
/// level, it drips off as soon as it does not run downhill. Whatever is slower than rest_speed on nearly level ground
/// rests.
/// @param drop          In contact; flying or floating after it.
/// @param front_normal  For bounces to reflect about, unit, for the triangle's front.
[[nodiscard]] Outcome respond_to_contact(const MotionScene& scene, const MotionCall& call, std::uint32_t gammaton,
                                         Drop& drop, const Vec3& front_normal);

/// The mesh's normals interpolated; unit; the triangle's where these cancel.
[[nodiscard]] Vec3 shading_normal(const MotionScene& scene, const SurfacePlace& at);
[[nodiscard]] Vec3 point(const MotionScene& scene, const SurfacePlace& at);

}  // namespace patinate::simulation
