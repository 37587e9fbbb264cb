#include "simulation/tracing/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"
#include "simulation/tracing/device_motion.h"
#include "simulation/tracing/emitter.h"
#include "simulation/tracing/gammatons.h"
#include "simulation/tracing/motion_notes.h"
#include "simulation/tracing/pieces.h"

namespace patinate::simulation {

namespace {

/// Size of the chunks that work on `n` gammatons is split into: large enough for neighbors to meet, small enough for
/// some threads.
[[nodiscard]] inline std::int64_t chunk_of(std::int64_t n) { return std::clamp<std::int64_t>(n / 16, 1024, 32768); }

/// Indices [begin, end) by triangle, roughly, and then by index. @param num_triangles  Of the scene.
[[nodiscard]] inline std::vector<std::uint32_t> place_order(const Gammatons& gammatons, std::int64_t begin,
                                                            std::int64_t end, std::int64_t num_triangles) {
  int shift = 0;
  while ((num_triangles >> shift) > 8192) ++shift;
  std::vector<std::uint32_t> first(static_cast<std::size_t>((num_triangles >> shift) + 3), 0);
  const auto bucket = [&](std::int64_t i) {
    return static_cast<std::size_t>((gammatons.triangle[i] + 1) >> shift) + 1;
  };
  for (std::int64_t i = begin; i < end; ++i) ++first[bucket(i)];
  for (std::size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
  std::vector<std::uint32_t> order(static_cast<std::size_t>(end - begin));
  for (std::int64_t i = begin; i < end; ++i) order[first[bucket(i) - 1]++] = static_cast<std::uint32_t>(i);
  return order;
}

/// Asks for what is needed of a gammaton soon.
inline void prefetch(const Gammatons& gammatons, std::size_t i) {
#if defined(__GNUC__)
  __builtin_prefetch(&gammatons.state[i], 1);
  __builtin_prefetch(&gammatons.is_front[i], 1);
  __builtin_prefetch(&gammatons.b1[i], 1);
  __builtin_prefetch(&gammatons.b2[i], 1);
  __builtin_prefetch(&gammatons.position[i], 1);
  __builtin_prefetch(&gammatons.velocity[i], 1);
#else
  (void)gammatons;
  (void)i;
#endif
}

constexpr std::size_t kMaxGammatons = 100'000'000;

Drop take(const Gammatons& all, std::size_t i) {
  return {.state = static_cast<std::uint32_t>(all.state[i]),
          .is_front = all.is_front[i] != 0,
          .at = {.triangle = all.triangle[i], .b1 = all.b1[i], .b2 = all.b2[i]},
          .position = vector_of(all.position[i]),
          .velocity = vector_of(all.velocity[i])};
}

void put(Gammatons& all, std::size_t i, const Drop& g) {
  all.state[i] = static_cast<GammatonState>(g.state);
  all.is_front[i] = g.is_front ? 1 : 0;
  all.triangle[i] = g.at.triangle;
  all.b1[i] = g.at.b1;
  all.b2[i] = g.at.b2;
  all.position[i] = vec3(g.position);
  all.velocity[i] = vec3(g.velocity);
}

bool is_same(const Emitter& a, const Emitter& b) {
  return a.shape == b.shape && a.position_mm == b.position_mm && a.direction == b.direction && a.size_mm == b.size_mm &&
         a.spread_deg == b.spread_deg && a.speed_mm_s == b.speed_mm_s && a.distance_mm == b.distance_mm &&
         a.wind_mm_s == b.wind_mm_s;
}

MotionCall call_of(const Scene& scene, std::int64_t iteration, const GammatonRange& moving) {
  return {.iteration = static_cast<std::uint64_t>(iteration),
          .seed = scene.seed,
          .begin = moving.begin,
          .num_shares = moving.num_shares,
          .born_share = moving.born_share};
}

/// Those of a range that there are.
struct Range {
  std::int64_t begin = 0, num = 0;
};
Range range_of(const Gammatons& all, const GammatonRange& moving) {
  return {moving.begin, std::min(moving.end, static_cast<std::int64_t>(all.size())) - moving.begin};
}

/// Calls move(i, told, counters) for every gammaton of a range, neighbors on the surface one after the other, and lists
/// what is told by gammaton. Texels of contacts are looked up in a loop of their own, where the waiting for memory of
/// many overlaps.
template <class Move>
void for_all(Gammatons& all, const MotionScene& motion, const SurfaceAtlas& surface, const RunControl& control,
             const GammatonRange& moving, TraceResult& result, Move&& move) {
  constexpr std::size_t kAhead = 12;  // gammatons; memory's latency over the time that one needs
  const Range range = range_of(all, moving);
  const std::int64_t first = range.begin, n = range.num;
  const std::int64_t chunk = chunk_of(n);
  std::vector<TraceResult> parts(static_cast<std::size_t>((n + chunk - 1) / chunk));
  parallel_for(n, chunk, control, [&](std::int64_t from, std::int64_t to) {
    const std::int64_t begin = first + from, end = first + to;
    TraceResult& part = parts[from / chunk];
    const std::vector<std::uint32_t> order = place_order(all, begin, end, motion.frames.num_triangles());
    std::vector<Note> told(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      if (k + kAhead < order.size()) {
        prefetch(all, order[k + kAhead]);
        motion.frames.prefetch(all.triangle[order[k + kAhead]]);
        motion.links.prefetch(all.triangle[order[k + kAhead]]);
      }
      const std::size_t i = order[k];
      move(i, told[i - static_cast<std::size_t>(begin)], part.counters);
    }
    for (const std::uint32_t i : order) {
      Note& of = told[i - static_cast<std::size_t>(begin)];
      if (of.is_contact) of.texel = surface.texel_of(all.triangle[i], all.b1[i], all.b2[i]);
    }
    for (std::size_t k = 0; k < told.size(); ++k) {
      const std::size_t i = k + static_cast<std::size_t>(begin);
      put_down(told[k], i, all.state[i] != GammatonState::Waiting, part);
    }
  });
  result = {};
  join(parts, result);
}

}  // namespace

Gammatons make_gammatons(const Scene& scene) {
  std::size_t n = 0;
  for (const Emitter& emitter : scene.emitters)
    n += static_cast<std::size_t>(std::max<std::int64_t>(0, emitter.gammatons));
  if (n > kMaxGammatons)
    throw InvalidInput("the emitters have " + std::to_string(n) + " gammatons together; use at most 10^8");
  Gammatons all;
  all.state.assign(n, GammatonState::Waiting);
  all.is_front.assign(n, 1);
  all.num_births.assign(n, 0);
  all.triangle.assign(n, -1);
  all.b1.assign(n, 0.0);
  all.b2.assign(n, 0.0);
  all.position.assign(n, Vec3::Zero());
  all.velocity.assign(n, Vec3::Zero());
  for (std::size_t k = 0; k < scene.emitters.size(); ++k) {
    all.emitter.insert(all.emitter.end(),
                       static_cast<std::size_t>(std::max<std::int64_t>(0, scene.emitters[k].gammatons)),
                       static_cast<std::uint16_t>(k));
  }
  return all;
}

struct GammatonTracer::Impl {
  Impl(const SceneMesh& scene_mesh, const SurfaceAtlas& atlas, std::shared_ptr<const SurfaceLinks> joined)
      : mesh(&scene_mesh),
        surface(&atlas),
        rays(scene_mesh.mesh),
        frames(scene_mesh, rays),
        links(std::move(joined)),
        free_space(rays) {}

  /// Places those emitters that are new or changed.
  void place(const Scene& scene) {
    const bool is_other = placed_for.size() != scene.emitters.size() || gravity != scene.gravity_mm_s2;
    if (is_other) {
      placed_for.assign(scene.emitters.size(), std::nullopt);
      placed.resize(scene.emitters.size());
      gravity = scene.gravity_mm_s2;
    }
    for (std::size_t k = 0; k < scene.emitters.size(); ++k) {
      const Emitter& emitter = scene.emitters[k];
      if (!emitter.is_on || (placed_for[k] && is_same(*placed_for[k], emitter))) continue;
      placed[k] = place_emitter(emitter, *mesh, rays, scene.gravity_mm_s2);
      placed_for[k] = emitter;
    }
  }

  /// By emitter: those of a share come first in its range of gammatons.
  [[nodiscard]] std::vector<EmitterFacts> emitters(const Scene& scene) const {
    std::vector<EmitterFacts> facts;
    std::int64_t begin = 0;
    for (std::size_t k = 0; k < scene.emitters.size(); ++k) {
      const Emitter& emitter = scene.emitters[k];
      EmitterFacts& of = facts.emplace_back(facts_of(placed[k]));
      const auto share = static_cast<double>(emitter.gammatons) * std::clamp(emitter.born_share, 0.0, 1.0);
      of.is_on = emitter.is_on ? 1 : 0;
      of.end_born = static_cast<std::uint32_t>(begin + static_cast<std::int64_t>(std::floor(share + 0.5)));
      begin += emitter.gammatons;
    }
    return facts;
  }

  const SceneMesh* mesh;
  const SurfaceAtlas* surface;
  RayTracer rays;
  TriangleFrames frames;
  std::shared_ptr<const SurfaceLinks> links;  ///< Equal wherever the objects stand.
  FreeSpace free_space;
  /// Scene that all gammatons of a call share.
  MotionScene motion(const Scene& scene, const WetPaths* wet = nullptr) {
    if (!clearance || clearance->height_mm() != scene.tracing.epsilon_mm) {
      clearance.emplace(rays, frames, mesh->mesh.num_triangles(), scene.tracing.epsilon_mm);
      there.reset();
    }
    return motion_scene(scene, rays, frames, *links, free_space, *clearance, wet);
  }

  std::unique_ptr<DeviceMotion> there;  ///< State of the present scene on a device; null before it is asked.
  std::optional<Clearance> clearance;
  std::vector<std::optional<Emitter>> placed_for;
  std::vector<PlacedEmitter> placed;
  Vec3 gravity{0, 0, 0};
};

GammatonTracer::GammatonTracer(const SceneMesh& scene_mesh, const SurfaceAtlas& surface)
    : impl_(std::make_unique<Impl>(scene_mesh, surface, std::make_shared<const SurfaceLinks>(scene_mesh))) {}
GammatonTracer::~GammatonTracer() = default;
GammatonTracer::GammatonTracer(GammatonTracer&&) noexcept = default;
GammatonTracer& GammatonTracer::operator=(GammatonTracer&&) noexcept = default;

void GammatonTracer::set_mesh(const SceneMesh& scene_mesh) {
  impl_ = std::make_unique<Impl>(scene_mesh, *impl_->surface, impl_->links);
}

const RayTracer& GammatonTracer::rays() const { return impl_->rays; }

void GammatonTracer::trace(Gammatons& all, const Scene& scene, std::int64_t iteration, TraceResult& result,
                           const RunControl& control, const GammatonRange& moving) {
  const auto most = std::max_element(all.emitter.begin(), all.emitter.end());
  if (most != all.emitter.end() && *most >= scene.emitters.size())
    throw InvalidInput("there are gammatons of emitters that the scene does not have");
  impl_->place(scene);
  const MotionScene motion = impl_->motion(scene);
  const MotionCall call = call_of(scene, iteration, moving);
  const std::vector<EmitterFacts> emitters = impl_->emitters(scene);
  for_all(all, motion, *impl_->surface, control, moving, result, [&](std::size_t i, Note& of, TraceCounters& counters) {
    const EmitterFacts& emitter = emitters[all.emitter[i]];
    if (all.state[i] == GammatonState::Waiting && (emitter.is_on == 0 || i >= emitter.end_born)) return;
    Drop g = take(all, i);
    const Told told = trace_drop(motion, call, emitter, static_cast<std::uint32_t>(i), g, all.num_births[i]);
    note_way(told, of, counters);
    put(all, i, g);
  });
}

void GammatonTracer::respond(Gammatons& all, const Scene& scene, std::int64_t iteration, TraceResult& result,
                             const SurfaceNormals* normals, const RunControl& control, const GammatonRange& moving,
                             const WetPaths* wet) {
  const MotionScene motion = impl_->motion(scene, wet);
  const MotionCall call = call_of(scene, iteration, moving);
  for_all(all, motion, *impl_->surface, control, moving, result, [&](std::size_t i, Note& of, TraceCounters&) {
    if (all.state[i] != GammatonState::InContact) return;
    Drop g = take(all, i);
    Vec3 normal = shading_normal(motion, g.at);
    if (normals) normal = normals->normal(g.at.triangle, g.at.b1, g.at.b2, normal);
    const Outcome outcome = respond_to_contact(motion, call, static_cast<std::uint32_t>(i), g, normal);
    if (outcome != Outcome::Alive) g.state = motion_types::kIsWaiting;
    note_response(outcome, of);
    put(all, i, g);
  });
}

void GammatonTracer::trace_there(const Scene& scene, std::int64_t iteration, const LifeCall& life, DeviceArrays& arrays,
                                 const RunControl& control) {
  impl_->place(scene);
  const MotionScene motion = impl_->motion(scene);
  if (!impl_->there) impl_->there = std::make_unique<DeviceMotion>(arrays.device, motion, *impl_->surface, control);
  impl_->there->trace(motion, call_of(scene, iteration, {}), impl_->emitters(scene), life, arrays);
}

void GammatonTracer::respond_there(const Scene& scene, std::int64_t iteration, const WetPaths* wet, bool is_deposited,
                                   DeviceArrays& arrays) {
  impl_->there->respond(impl_->motion(scene, wet), call_of(scene, iteration, {}), is_deposited, arrays);
}

void GammatonTracer::end_lives_there(DeviceArrays& arrays) {
  if (impl_->there) impl_->there->end_lives(arrays);
}

void GammatonTracer::forget_there() { impl_->there.reset(); }

std::vector<DropRecord> drop_records(const Gammatons& all, const RunControl& control) {
  std::vector<DropRecord> records(all.size());
  const auto num = static_cast<std::int64_t>(all.size());
  parallel_for(num, chunk_of(num), control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const Drop drop = take(all, i);
      put_drop(&drop, &records[i]);
      records[i].emitter = all.emitter[i];
      records[i].num_births = all.num_births[i];
    }
  });
  return records;
}

void take_drop_records(std::span<const DropRecord> records, Gammatons& all, const RunControl& control) {
  const auto num = static_cast<std::int64_t>(all.size());
  parallel_for(num, chunk_of(num), control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      put(all, i, drop_of(&records[i]));
      all.num_births[i] = records[i].num_births;
    }
  });
}

}  // namespace patinate::simulation
