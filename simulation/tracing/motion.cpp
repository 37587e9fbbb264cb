#include "simulation/tracing/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "simulation/tracing/emitter.h"
#include "simulation/tracing/pieces.h"
#include "simulation/tracing/place_order.h"
#include "simulation/tracing/response.h"

namespace patinate::simulation {

namespace {

constexpr std::uint32_t kResponsePurpose = 0x726f756c;
constexpr std::uint32_t kStridePurpose = 0x73747264;
constexpr std::size_t kMostGammatons = 100'000'000;

Gammaton take(const Gammatons& all, std::size_t i) {
  return {.state = all.state[i],
          .is_front = all.is_front[i] != 0,
          .at = {.triangle = all.triangle[i], .b1 = all.b1[i], .b2 = all.b2[i]},
          .position = all.position[i],
          .velocity = all.velocity[i]};
}

void put(Gammatons& all, std::size_t i, const Gammaton& g) {
  all.state[i] = g.state;
  all.is_front[i] = g.is_front ? 1 : 0;
  all.triangle[i] = g.at.triangle;
  all.b1[i] = g.at.b1;
  all.b2[i] = g.at.b2;
  all.position[i] = g.position;
  all.velocity[i] = g.velocity;
}

bool is_same(const Emitter& a, const Emitter& b) {
  return a.shape == b.shape && a.position_mm == b.position_mm && a.direction == b.direction && a.size_mm == b.size_mm &&
         a.spread_deg == b.spread_deg && a.speed_mm_s == b.speed_mm_s && a.distance_mm == b.distance_mm &&
         a.wind_mm_s == b.wind_mm_s;
}

/// Behind the last gammaton of each emitter that may be born: those of a share come first in its range.
std::vector<std::size_t> ends_of_births(const Scene& scene) {
  std::vector<std::size_t> ends;
  std::int64_t begin = 0;
  for (const Emitter& emitter : scene.emitters) {
    const auto share = static_cast<double>(emitter.gammatons) * std::clamp(emitter.born_share, 0.0, 1.0);
    ends.push_back(static_cast<std::size_t>(begin + static_cast<std::int64_t>(std::floor(share + 0.5))));
    begin += emitter.gammatons;
  }
  return ends;
}

/// What is told of one gammaton.
struct Told {
  TexelIndex texel = kNoTexel;
  bool is_contact = false;
  bool is_landing = false;
  bool is_born = false;
  bool has_died = false;
  DeathReason reason = DeathReason::Absorbed;
};

void bury(Gammaton& g, Told& told, DeathReason reason) {
  g.state = GammatonState::Waiting;
  told.has_died = true;
  told.reason = reason;
}

/// Puts down what is told of gammaton `i`.
void note(const Told& told, std::size_t i, bool is_alive, TraceResult& part) {
  const auto gammaton = static_cast<std::uint32_t>(i);
  if (told.texel != kNoTexel)
    part.contacts.push_back({.texel = told.texel, .gammaton = gammaton, .is_landing = told.is_landing});
  if (told.is_born) part.born.push_back(gammaton);
  part.counters.emitted += told.is_born ? 1 : 0;
  part.counters.alive += is_alive ? 1 : 0;
  if (!told.has_died) return;
  part.died.push_back({.gammaton = gammaton, .reason = told.reason});
  switch (told.reason) {
    case DeathReason::Absorbed:
      ++part.counters.absorbed;
      break;
    case DeathReason::Left:
      ++part.counters.left;
      break;
    case DeathReason::Rested:
      ++part.counters.rested;
      break;
  }
}

/// Parts of chunks, put together in their order.
void join(const std::vector<TraceResult>& parts, TraceResult& result) {
  for (const TraceResult& part : parts) {
    result.contacts.insert(result.contacts.end(), part.contacts.begin(), part.contacts.end());
    result.born.insert(result.born.end(), part.born.begin(), part.born.end());
    result.died.insert(result.died.end(), part.died.begin(), part.died.end());
    result.counters += part.counters;
  }
}

/// Calls move(i, told, counters) for every gammaton of a range, neighbors on the surface one after the other, and lists
/// what is told by gammaton. Texels of contacts are looked up in a loop of their own, where the waiting for memory of
/// many overlaps.
template <class Move>
void for_all(Gammatons& all, const MotionScene& motion, const SurfaceAtlas& surface, const RunControl& control,
             const GammatonRange& moving, TraceResult& result, Move&& move) {
  constexpr std::size_t kAhead = 12;  // gammatons; memory's latency over the time that one needs
  const std::int64_t first = moving.begin, n = std::min(moving.end, static_cast<std::int64_t>(all.size())) - first;
  const std::int64_t chunk = chunk_of(n);
  std::vector<TraceResult> parts(static_cast<std::size_t>((n + chunk - 1) / chunk));
  parallel_for(n, chunk, control, [&](std::int64_t from, std::int64_t to) {
    const std::int64_t begin = first + from, end = first + to;
    TraceResult& part = parts[static_cast<std::size_t>(from / chunk)];
    const std::vector<std::uint32_t> order = place_order(all, begin, end, motion.frames.num_triangles());
    std::vector<Told> told(order.size());
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
      Told& of = told[i - static_cast<std::size_t>(begin)];
      if (of.is_contact) of.texel = surface.texel_of(all.triangle[i], all.b1[i], all.b2[i]);
    }
    for (std::size_t k = 0; k < told.size(); ++k) {
      const std::size_t i = k + static_cast<std::size_t>(begin);
      note(told[k], i, all.state[i] != GammatonState::Waiting, part);
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
  if (n > kMostGammatons)
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

  const SceneMesh* mesh;
  const SurfaceAtlas* surface;
  RayTracer rays;
  TriangleFrames frames;
  std::shared_ptr<const SurfaceLinks> links;  ///< The same wherever the objects stand.
  FreeSpace free_space;
  /// What all gammatons of a call share.
  MotionScene motion(const Scene& scene) {
    if (!clearance || clearance->height_mm() != scene.tracing.epsilon_mm) {
      clearance.emplace(rays, frames, mesh->mesh.num_triangles(), scene.tracing.epsilon_mm);
    }
    return motion_scene(scene, rays, frames, *links, free_space, *clearance);
  }

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
  const std::array<std::uint32_t, 2> key{static_cast<std::uint32_t>(scene.seed),
                                         static_cast<std::uint32_t>(scene.seed >> 32)};
  const auto when = static_cast<std::uint64_t>(iteration);
  impl_->place(scene);
  const MotionScene motion = impl_->motion(scene);
  const std::vector<std::size_t> ends = ends_of_births(scene);
  for_all(
      all, motion, *impl_->surface, control, moving, result, [&](std::size_t i, Told& told, TraceCounters& counters) {
        if (all.state[i] == GammatonState::Waiting &&
            (!scene.emitters[all.emitter[i]].is_on || i >= ends[all.emitter[i]] || !moving.may_be_born(i)))
          return;
        Gammaton g = take(all, i);
        if (g.state == GammatonState::Waiting) {
          const Birth birth =
              make_birth(impl_->placed[all.emitter[i]], scene.seed, static_cast<std::uint32_t>(i), all.num_births[i]++);
          g = {.state = GammatonState::Flying,
               .is_front = true,
               .at = {},
               .position = birth.position,
               .velocity = birth.velocity};
          told.is_born = true;
        }
        std::int64_t num_pieces = 0;
        PieceEnd piece = PieceEnd::Flying;
        if (g.state == GammatonState::Floating) {
          const std::uint32_t random = philox4x32({static_cast<std::uint32_t>(when >> 32), kStridePurpose,
                                                   static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(when)},
                                                  key)[0];
          piece = float_on(motion, g, random, num_pieces);
        }
        told.is_landing = piece == PieceEnd::Flying;
        while (piece == PieceEnd::Flying && num_pieces < motion.options.max_segments) {
          piece = fly(motion, g);
          ++num_pieces;
        }
        counters.segments += num_pieces;
        switch (piece) {
          case PieceEnd::Contact:
            ++counters.contacts;
            told.is_contact = true;
            break;
          case PieceEnd::Left:
            bury(g, told, DeathReason::Left);
            break;
          case PieceEnd::Rested:
            bury(g, told, DeathReason::Rested);
            break;
          case PieceEnd::Flying:
            break;
        }
        put(all, i, g);
      });
}

void GammatonTracer::respond(Gammatons& all, const Scene& scene, std::int64_t iteration, TraceResult& result,
                             const SurfaceNormals* normals, const RunControl& control, const GammatonRange& moving,
                             const WetPaths* wet) {
  const MotionScene motion = impl_->motion(scene);
  const std::array<std::uint32_t, 2> key{static_cast<std::uint32_t>(scene.seed),
                                         static_cast<std::uint32_t>(scene.seed >> 32)};
  const auto when = static_cast<std::uint64_t>(iteration);
  for_all(all, motion, *impl_->surface, control, moving, result, [&](std::size_t i, Told& told, TraceCounters&) {
    if (all.state[i] != GammatonState::InContact) return;
    Gammaton g = take(all, i);
    const auto words = [&](std::uint32_t attempt) {
      return philox4x32({attempt | static_cast<std::uint32_t>(when >> 32) << 8, kResponsePurpose,
                         static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(when)},
                        key);
    };
    Vec3 normal = impl_->frames.shading_normal(g.at);
    if (normals) normal = normals->normal(g.at.triangle, g.at.b1, g.at.b2, normal);
    switch (respond_to_contact(motion, scene.behavior, g, normal, words, wet)) {
      case Outcome::Alive:
        break;
      case Outcome::Absorbed:
        bury(g, told, DeathReason::Absorbed);
        break;
      case Outcome::Rested:
        bury(g, told, DeathReason::Rested);
        break;
    }
    put(all, i, g);
  });
}

}  // namespace patinate::simulation
