/// \file
/// What is noted of gammatons while they move, and how it becomes a TraceResult.
#pragma once

#include <cstddef>
#include <vector>

#include "simulation/tracing/motion.h"
#include "simulation/tracing/pieces.h"

namespace patinate::simulation {

/// Notes on one gammaton.
struct Note {
  TexelIndex texel = kNoTexel;
  bool is_contact = false;
  bool is_landing = false;
  bool is_born = false;
  bool has_died = false;
  DeathReason reason = DeathReason::Absorbed;
};

/// Notes and counts the way.
void note_way(const Told& told, Note& of, TraceCounters& counters);
void note_response(Outcome outcome, Note& of);
/// Puts down what is noted of gammaton `i`.
void put_down(const Note& told, std::size_t i, bool is_alive, TraceResult& part);
/// Parts of chunks, put together in their order.
void join(const std::vector<TraceResult>& parts, TraceResult& result);

}  // namespace patinate::simulation
