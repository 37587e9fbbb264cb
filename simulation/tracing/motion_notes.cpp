#include "simulation/tracing/motion_notes.h"

namespace patinate::simulation {

namespace {

void bury(Note& of, DeathReason reason) {
  of.has_died = true;
  of.reason = reason;
}

}  // namespace

void note_way(const Told& told, Note& of, TraceCounters& counters) {
  of.is_born = told.is_born != 0;
  of.is_landing = told.is_landing != 0;
  counters.segments += told.num_pieces;
  switch (told.end) {
    case motion_types::kEndContact:
      ++counters.contacts;
      of.is_contact = true;
      break;
    case motion_types::kEndLeft:
      bury(of, DeathReason::Left);
      break;
    case motion_types::kEndRested:
      bury(of, DeathReason::Rested);
      break;
    default:
      break;
  }
}

void note_response(Outcome outcome, Note& of) {
  if (outcome == Outcome::Absorbed) bury(of, DeathReason::Absorbed);
  if (outcome == Outcome::Rested) bury(of, DeathReason::Rested);
}

void put_down(const Note& told, std::size_t i, bool is_alive, TraceResult& part) {
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

void join(const std::vector<TraceResult>& parts, TraceResult& result) {
  for (const TraceResult& part : parts) {
    result.contacts.insert(result.contacts.end(), part.contacts.begin(), part.contacts.end());
    result.born.insert(result.born.end(), part.born.begin(), part.born.end());
    result.died.insert(result.died.end(), part.died.begin(), part.died.end());
    result.counters += part.counters;
  }
}

}  // namespace patinate::simulation
