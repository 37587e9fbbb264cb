// Back and forth: strokes and returns to the start are undone and redone, with all that they have led to.
#include "patinate/core/error.h"
#include "tools/studio/live_client.h"

namespace patinate::studio {

namespace {

constexpr std::size_t kMaxMomentBytes = std::size_t{192} << 20;
constexpr std::size_t kMaxMoments = 20;

}  // namespace

LiveEngine::Moment LiveEngine::moment() {
  return {simulation_.snapshot(), record_.events(), slider_, picture_of_, opened_};
}

void LiveEngine::go_to(const Moment& moment) {
  stop_replay();
  simulation_.restore(moment.state);
  record_.set_events(moment.events);
  slider_ = moment.slider;
  picture_of_ = moment.picture_of;
  opened_ = moment.opened;
  for (auto& [name, overlay] : overlays_) overlay.forget();
  for (const auto& [id, client] : clients_) client->shown_state = -1;
}

/// Before something that can be undone.
void LiveEngine::remember() {
  past_.push_back(moment());
  future_.clear();
  forget_the_oldest();
}

void LiveEngine::undo() {
  if (past_.empty()) throw InvalidInput("there is nothing to undo");
  finish_stroke();
  future_.push_back(moment());
  go_to(past_.back());
  past_.pop_back();
  forget_the_oldest();
}

void LiveEngine::redo() {
  if (future_.empty()) throw InvalidInput("there is nothing to redo");
  finish_stroke();
  past_.push_back(moment());
  go_to(future_.back());
  future_.pop_back();
  forget_the_oldest();
}

/// Whatever memory it takes, the last one on either side stays.
void LiveEngine::forget_the_oldest() {
  const auto bytes = [&] {
    std::size_t sum = 0;
    for (const auto* moments : {&past_, &future_}) {
      for (const Moment& m : *moments) sum += m.state.size();
    }
    return sum;
  };
  while (past_.size() > 1 && (past_.size() > kMaxMoments || bytes() > kMaxMomentBytes)) past_.pop_front();
  while (future_.size() > 1 && (future_.size() > kMaxMoments || bytes() > kMaxMomentBytes)) future_.pop_front();
}

}  // namespace patinate::studio
