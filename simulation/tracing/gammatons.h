/// \file
/// The particles of a simulation: one stream of plain arrays in which every emitter owns a fixed range.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/simulation/scene.h"

namespace patinate::simulation {

enum class GammatonState : std::uint8_t {
  Waiting,    ///< Not there: not born yet, or dead. Born by the next trace() if its emitter is on.
  Flying,     ///< A free particle: position and velocity count.
  Floating,   ///< Held to a triangle: triangle, b1, b2, is_front and velocity (tangential) count; position follows.
  InContact,  ///< Between trace() and respond(): has hit triangle, b1, b2 on the side is_front, with the velocity of
              ///< its arrival.
};

/// All arrays have one value for each gammaton, and together are the whole state (a checkpoint saves them and nothing
/// else).
struct Gammatons {
  std::vector<GammatonState> state;
  std::vector<std::uint8_t> is_front;     ///< Side of the triangle that it is on; 1 where the triangle's normal points.
  std::vector<std::uint16_t> emitter;     ///< Index into Scene::emitters.
  std::vector<std::uint32_t> num_births;  ///< Times born.
  std::vector<std::int32_t> triangle;     ///< Last one touched; -1 before.
  std::vector<double> b1;                 ///< Barycentric weights of its corners 1 and 2.
  std::vector<double> b2;
  std::vector<Vec3> position;  ///< mm, world.
  std::vector<Vec3> velocity;  ///< mm/s, world.

  [[nodiscard]] std::size_t size() const { return state.size(); }

  /// Calls f(name, array) for every array: for files.
  template <class F>
  void for_each_array(F&& f) {
    f("state", state);
    f("is_front", is_front);
    f("emitter", emitter);
    f("num_births", num_births);
    f("triangle", triangle);
    f("b1", b1);
    f("b2", b2);
    f("position", position);
    f("velocity", velocity);
  }
};

/// All waiting; emitter after emitter. @throws InvalidInput if they are more than 10^8.
[[nodiscard]] Gammatons make_gammatons(const Scene& scene);

enum class DeathReason : std::uint8_t { Absorbed, Left, Rested };

struct Death {
  std::uint32_t gammaton = 0;
  DeathReason reason = DeathReason::Absorbed;
  friend bool operator==(const Death&, const Death&) = default;
};

/// Sums over a run; emitted = absorbed + left + rested + alive, always.
struct TraceCounters {
  std::int64_t segments = 0;  ///< Straight pieces followed.
  std::int64_t contacts = 0;  ///< Hits, with or without a texel.
  std::int64_t emitted = 0;
  std::int64_t absorbed = 0;
  std::int64_t left = 0;  ///< Flew out of the scene.
  std::int64_t rested = 0;
  std::int64_t alive = 0;  ///< Under way after the last call.
  /// Sums, `alive` too: of parts of one call. Over calls `alive` is that of the last one.
  TraceCounters& operator+=(const TraceCounters& other) {
    segments += other.segments;
    contacts += other.contacts;
    emitted += other.emitted;
    absorbed += other.absorbed;
    left += other.left;
    rested += other.rested;
    alive += other.alive;
    return *this;
  }
  friend bool operator==(const TraceCounters&, const TraceCounters&) = default;
};

}  // namespace patinate::simulation
