/// \file
/// How gammatons move and what they do where they hit [Guenther et al. 2012, sec. 4.1]:
/// docs/algorithms/gammaton_tracing.md.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/tracing/gammatons.h"
#include "simulation/tracing/motion_facts.h"
#include "simulation/transport/cargo.h"

namespace patinate::simulation {

class RayTracer;
struct DeviceArrays;
struct LifeCall;
struct WetPaths;

/// Result of one call.
struct TraceResult {
  std::vector<Contact> contacts;    ///< By gammaton. A hit that has no texel makes none.
  std::vector<std::uint32_t> born;  ///< By gammaton.
  std::vector<Death>
      died;  ///< By gammaton; a death is told before the same gammaton's next birth, which is the next call's.
  TraceCounters counters;  ///< Counters of this call; `alive` after it, among those that move.
};

/// Those gammatons that move; all others stay where they are, as they are.
struct GammatonRange {
  std::int64_t begin = 0;
  std::int64_t end = std::numeric_limits<std::int64_t>::max();  ///< Behind the last; cut to how many there are.
  /// Only one share of them is born: every num_shares-th from `begin + born_share` on.
  std::int64_t num_shares = 1;
  std::int64_t born_share = 0;

  [[nodiscard]] bool may_be_born(std::size_t gammaton) const {
    return (static_cast<std::int64_t>(gammaton) - begin) % num_shares == born_share;
  }
};

/// The normal that a gammaton is reflected about: for surfaces with heights.
class SurfaceNormals {
 public:
  virtual ~SurfaceNormals() = default;
  /// @param shading_normal  The mesh's, unit, on the triangle's front. @returns unit. Called by several threads at
  /// once.
  [[nodiscard]] virtual Vec3 normal(int triangle, double b1, double b2, const Vec3& shading_normal) const = 0;
};

/// One iteration is trace(), then what happens at the contacts, then respond(). Behavior, emitters, options and gravity
/// are those of the scene at each call. Equal bits for any number of threads and instruction set (tested on x86-64).
class GammatonTracer {
 public:
  /// @param surface  Outlives the tracer. Where `scene_mesh` is inside out or open, gammatons hit both sides alike.
  GammatonTracer(const SceneMesh& scene_mesh, const SurfaceAtlas& surface);
  ~GammatonTracer();
  GammatonTracer(GammatonTracer&&) noexcept;
  GammatonTracer& operator=(GammatonTracer&&) noexcept;

  /// Places the same triangles elsewhere. Floating gammatons move with theirs.
  void set_mesh(const SceneMesh& scene_mesh);
  [[nodiscard]] const RayTracer& rays() const;
  /// Births of those that wait and whose emitters are on; then each flies or floats for at most
  /// TracingOptions::max_segments straight pieces, until it hits something (InContact) or has left for good.
  /// @param gammatons  From make_gammatons() with as many emitters as the scene has.
  /// @throws InvalidInput if a Surface emitter has no surface, or gammatons name emitters that are not there.
  void trace(Gammatons& all, const Scene& scene, std::int64_t iteration, TraceResult& result,
             const RunControl& control = {}, const GammatonRange& moving = {});
  /// Those in contact bounce, float on, come to rest or are absorbed.
  /// @param normals  nullptr: the mesh's.
  /// @param wet      Paths that attract floating ones; may be null.
  void respond(Gammatons& all, const Scene& scene, std::int64_t iteration, TraceResult& result,
               const SurfaceNormals* normals = nullptr, const RunControl& control = {},
               const GammatonRange& moving = {}, const WetPaths* wet = nullptr);

  /// Traces all gammatons on a device, with the same bytes; contacts, births and ends stay there too. What the
  /// device needs of the scene is brought by the first call, and after set_mesh(). @throws DeviceError
  void trace_there(const Scene& scene, std::int64_t iteration, const LifeCall& life, DeviceArrays& arrays,
                   const RunControl& control);
  /// With the mesh's normals.
  void respond_there(const Scene& scene, std::int64_t iteration, const WetPaths* wet, bool is_deposited,
                     DeviceArrays& arrays);
  void end_lives_there(DeviceArrays& arrays);
  /// After a device has failed.
  void forget_there();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Gammatons as a device has them, and back. @param records  Of all.
[[nodiscard]] std::vector<DropRecord> drop_records(const Gammatons& all, const RunControl& control);
void take_drop_records(std::span<const DropRecord> records, Gammatons& all, const RunControl& control);

}  // namespace patinate::simulation
