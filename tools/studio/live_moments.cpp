// Back and forth: one list of steps. Settings, moves and looks are set back where the scene is now; a stroke goes with
// all that it has led to, and the iterations since are done again without it; the way back to the start goes whole.
#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "patinate/core/error.h"
#include "simulation/files/scene_event.h"
#include "tools/studio/live_client.h"

namespace patinate::studio {

namespace {

constexpr std::size_t kMaxMomentBytes = std::size_t{192} << 20;
constexpr std::size_t kMaxMoments = 20;
constexpr std::size_t kMaxSteps = 200;
/// Changes of one setting that follow each other as fast as this are one step: a slider that is dragged tells many.
constexpr std::chrono::milliseconds kSameStep{1200};

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
  if (material_) material_->forget();
  for (const auto& [id, client] : clients_) client->shown_state = -1;
}

/// The last step, if a change of this name now belongs to it.
LiveEngine::Step* LiveEngine::step_that_goes_on(const StepName& name) {
  if (past_.empty() || !future_.empty() || past_.back().key != name.key) return nullptr;
  const Step& last = past_.back();
  const bool is_one_gesture = name.gesture != 0 && name.gesture == last.gesture;
  return is_one_gesture || Clock::now() - last.made < kSameStep ? &past_.back() : nullptr;
}

LiveEngine::Step& LiveEngine::new_step(const StepName& name) {
  Step& step = past_.emplace_back();
  step.label = name.label;
  step.key = name.key;
  step.gesture = name.gesture;
  step.iteration = iteration();
  future_.clear();
  return step;
}

/// Before something that changes the state itself.
void LiveEngine::remember(const std::string& label, bool is_stroke) {
  Moment before = moment();
  Step& step = new_step({.label = label, .key = ""});
  step.moment = std::move(before);
  step.is_stroke = is_stroke;
  step.num_events_then = record_.num_events();
  forget_the_oldest();
}

/// @param back  opposite() of an event, which has happened since.
void LiveEngine::remember_event(const StepName& name, std::vector<BackEvent> back) {
  Step* last = step_that_goes_on(name);
  Step& step = last ? *last : new_step(name);
  for (BackEvent& one : back) {
    const bool is_known =
        std::any_of(step.events.begin(), step.events.end(), [&](const BackEvent& e) { return e.key == one.key; });
    if (!is_known) step.events.insert(step.events.begin(), std::move(one));
  }
  step.label = name.label;
  step.made = Clock::now();
  forget_the_oldest();
}

/// @param before  Unless it goes on.
void LiveEngine::remember_appearance(const StepName& name, std::optional<AppearanceState> before) {
  Step& step = before ? new_step(name) : past_.back();
  if (before) step.appearance = std::move(before);
  step.label = name.label;
  step.made = Clock::now();
  forget_the_oldest();
}

/// Does what a step keeps, which then keeps what does the opposite.
void LiveEngine::exchange(Step& step, bool is_undo) {
  step.made = {};  // What comes later is a step of its own.
  step.gesture = 0;
  if (step.appearance) {
    AppearanceState now{looks_, record_.appearance_state()};
    set_looks(std::move(step.appearance->shown));
    record_.set_appearance_state(step.appearance->recorded);
    step.appearance = std::move(now);
    for (const auto& [id, client] : clients_) client->shown_state = -1;
    return;
  }
  if (!step.moment) {
    std::vector<BackEvent> again;
    for (const BackEvent& back : step.events) {
      Json event{{"iteration", simulation_.iteration()}};
      event.update(*back.event);
      std::vector<BackEvent> opposites = opposite(parse_event(event, simulation_.scene(), file_.mm_per_unit));
      perform_now(*back.event);
      again.insert(again.begin(), std::make_move_iterator(opposites.begin()), std::make_move_iterator(opposites.end()));
    }
    step.events = std::move(again);
    return;
  }
  const bool goes_on = is_doing_again() ? replay_->goes_on && is_running_ : is_running_ && num_steps_left_ == 0;
  const std::int64_t until = std::max(iteration(), is_doing_again() ? replay_->until : 0);
  Moment now = moment();
  // What came after the stroke, and what would still come again. What is redone has all of that in it.
  SceneRecord::Events later;
  if (is_undo && step.num_events_then < now.events.size())
    later.assign(now.events.begin() + static_cast<std::ptrdiff_t>(step.num_events_then), now.events.end());
  if (is_undo && is_doing_again())
    later.insert(later.end(), replay_->events.begin() + static_cast<std::ptrdiff_t>(replay_->num_done),
                 replay_->events.end());
  go_to(*step.moment);
  step.moment = std::move(now);
  if (step.is_stroke) do_again(until, std::move(later), goes_on);
}

/// Runs to where the scene was, with the settings that were made on the way.
void LiveEngine::do_again(std::int64_t until, SceneRecord::Events events, bool goes_on) {
  is_running_ = goes_on;
  if (iteration() >= until && events.empty()) return;
  replay_ =
      Replay{.events = std::move(events), .num_done = 0, .until = until, .is_recording = false, .goes_on = goes_on};
  num_steps_left_ = 0;
  is_running_ = true;
}

void LiveEngine::undo(std::int64_t count) {
  if (past_.empty()) throw InvalidInput("there is nothing to undo");
  finish_stroke();
  for (; count > 0 && !past_.empty(); --count) {
    if (past_.back().document) {  // The rest is undone in the scene that comes.
      leave_scene(Next::Undo, count);
      return;
    }
    exchange(past_.back(), true);
    future_.push_back(std::move(past_.back()));
    past_.pop_back();
  }
  forget_the_oldest();
}

void LiveEngine::redo(std::int64_t count) {
  if (future_.empty()) throw InvalidInput("there is nothing to redo");
  finish_stroke();
  for (; count > 0 && !future_.empty(); --count) {
    if (future_.back().document) {
      leave_scene(Next::Redo, count);
      return;
    }
    exchange(future_.back(), false);
    past_.push_back(std::move(future_.back()));
    future_.pop_back();
  }
  forget_the_oldest();
}

/// Whatever memory it takes, the last one on either side stays. Behind one that has gone, none can be undone.
void LiveEngine::forget_the_oldest() {
  const auto memory = [&] {
    std::size_t sum = 0, num_moments = 0;
    for (const auto* steps : {&past_, &future_}) {
      for (const Step& step : *steps) {
        if (step.moment) ++num_moments, sum += step.moment->state.size();
        for (const auto& look :
             step.appearance ? step.appearance->shown : std::vector<simulation::MaterialAppearance>())
          sum += look.color.image.values().size() * sizeof(float);
      }
    }
    return std::pair(sum, num_moments);
  };
  const auto is_much = [&](const std::deque<Step>& steps) {
    const auto [bytes, num_moments] = memory();
    return steps.size() > kMaxSteps || bytes > kMaxMomentBytes || num_moments > kMaxMoments;
  };
  while (past_.size() > 1 && is_much(past_)) past_.pop_front();
  while (future_.size() > 1 && is_much(future_)) future_.pop_front();
}

Json LiveEngine::steps_json() const {
  Json done = Json::array(), undone = Json::array();
  for (const Step& step : past_) done.push_back({{"label", step.label}, {"iteration", step.iteration}});
  for (auto step = future_.rbegin(); step != future_.rend(); ++step)
    undone.push_back({{"label", step->label}, {"iteration", step->iteration}});
  return {{"done", std::move(done)}, {"undone", std::move(undone)}};
}

}  // namespace patinate::studio
