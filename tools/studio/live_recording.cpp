// Recording: changes are on the disk within a second, and an earlier run's can be gone through again.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "patinate/core/error.h"
#include "simulation/files/scene_event.h"
#include "tools/studio/live_client.h"
#include "tools/studio/recording.h"
#include "tools/studio/scene_text.h"

namespace patinate::studio {

namespace {

constexpr const char* kResumeStep = "Resume what was painted";
constexpr double kKeepSeconds = 0.4;            ///< From one writing to the next.
constexpr double kKeepIterationsSeconds = 5.0;  ///< Where nothing was done and only iterations passed.

}  // namespace

void LiveEngine::open_recording() {
  if (options_.place.empty()) return;
  if (recording_folder(folder_).empty()) {
    file_.notes.push_back(
        "The folder that is served is a finished result and stays as it was made, so what is done here is not kept on "
        "the disk. Serve the folder around it.");
    return;
  }
  recording_ = std::make_unique<RecordingFile>(folder_, options_.place, scene_content_key(file_));
  if (!recording_->note().empty()) file_.notes.push_back(recording_->note());
}

/// Recording that can be resumed, for clients.
Json LiveEngine::recording_json() const {
  if (!recording_ || !recording_->found() || (replay_ && replay_->is_recording) || is_resumed_) return nullptr;
  const Recording& found = *recording_->found();
  return {{"iterations", found.iterations}, {"events", found.events->size()}, {"saved", found.modified}};
}

/// While it is gone through nothing is written: what is on the disk is more.
void LiveEngine::keep(bool is_last) {
  if (!recording_ || replay_) return;
  if (const std::string problem = clients_.empty() ? std::string() : recording_->take_problem(); !problem.empty())
    send_all(Json{{"type", "notice"}, {"text", problem}}.dump(-1, ' ', false, Json::error_handler_t::replace));
  const bool has_changed = record_.version() != kept_version_, has_run = iteration() != kept_iteration_;
  if (!has_changed && !has_run) return;
  const bool is_due = is_last || !is_running_ ||
                      std::chrono::duration<double>(Clock::now() - kept_at_).count() >
                          (has_changed ? kKeepSeconds : kKeepIterationsSeconds);
  if (!is_due ||
      (has_changed && !is_last && std::chrono::duration<double>(Clock::now() - kept_at_).count() < kKeepSeconds))
    return;
  kept_at_ = Clock::now();
  kept_version_ = record_.version();
  kept_iteration_ = iteration();
  if (record_.num_events() == 0 && record_.appearance().empty() && !is_edited_) {
    if (std::exchange(is_keeping_, false)) recording_->put_aside();
    return;
  }
  is_keeping_ = true;
  recording_->keep(iteration(), record_.events_json(), record_.appearance(),
                   record_.file_for(recording_->folder(), iteration()), is_edited_ ? record_.written() : nullptr);
}

void LiveEngine::resume() {
  if (!recording_ || !recording_->found() || (replay_ && replay_->is_recording) || is_resumed_)
    throw InvalidInput("there is no recording of an earlier run to resume");
  finish_stroke();
  stop_replay();
  if (const auto& edited = recording_->found()->document) {
    next_ = Next{.what = Next::Resume, .label = kResumeStep, .document = edited};
    return;
  }
  if (record_.num_events() > 0 || iteration() > 0) remember(kResumeStep, false);
  begin_replay();
}

/// Of the found recording.
void LiveEngine::begin_replay() {
  const Recording& found = *recording_->found();
  Replay replay;
  for (const Json& event : *found.events) replay.events.push_back(std::make_shared<Json>(event));
  replay.until = found.iterations;
  // A recording that began where this is now resumes from here; the same bytes come of it as from the start.
  const std::int64_t first =
      replay.events.empty() ? found.iterations : (*replay.events.front())["iteration"].get<std::int64_t>();
  const bool goes_on = record_.num_events() == 0 && simulation_.num_paint_steps() == 0 &&
                       iteration() <= std::min(first, found.iterations) && (picture_of_ == 0 || replay.events.empty());
  if (!goes_on) go_to({.state = start_, .events = {}, .slider = start_slider_, .picture_of = 0, .opened = ""});
  if (!found.appearance->empty()) set_appearance(*found.appearance, 0);
  replay_ = std::move(replay);
  num_steps_left_ = 0;
  is_running_ = true;
  opened_.clear();
  counted_from_ = Clock::now();
  counted_iterations_ = 0;
}

/// Something else is done: a recording does not continue by itself, and can be resumed from the start.
void LiveEngine::stop_replay() {
  if (!replay_) return;
  replay_.reset();
  is_running_ = false;
  num_steps_left_ = 0;
}

/// Recorded events that happened here. @returns whether there is an iteration to do.
bool LiveEngine::go_through(const std::stop_token& stop) {
  Replay& replay = *replay_;
  const std::size_t before = replay.num_done;
  try {
    while (replay.num_done < replay.events.size() &&
           (*replay.events[replay.num_done])["iteration"] == simulation_.iteration()) {
      const Json& event = *replay.events[replay.num_done];
      const simulation::SceneEvent parsed = parse_event(event, simulation_.scene(), file_.mm_per_unit);
      simulation_.apply(parsed, {.on_progress = {}, .stop = stop, .num_threads = options_.num_threads});
      if (std::holds_alternative<simulation::BehaviorEvent>(parsed.what)) {
        slider_ = event["behavior"].contains("slider") ? std::optional(event["behavior"]["slider"].get<double>())
                                                       : std::nullopt;
      }
      record_.append(replay.events[replay.num_done]);
      ++replay.num_done;
    }
  } catch (const InvalidInput& e) {
    send_all(error_text(nullptr, std::string("the recording cannot be gone through any further: ") + e.what()));
    replay.until = simulation_.iteration();
  }
  if (replay.num_done > before) {
    has_news_ = true;
    send_scene();
  }
  if (iteration() < replay.until) return true;
  has_news_ = true;
  if (!replay.is_recording) {
    is_running_ = replay.goes_on;
    replay_.reset();
    return is_running_;
  }
  const bool is_whole = replay.num_done == replay.events.size();
  if (is_whole) recording_->go_on();
  stop_replay();
  is_resumed_ = true;
  send_all(Json{{"type", "notice"},
                {"text", "This is where the recording ended, after " + std::to_string(iteration()) + " iterations"}}
               .dump());
  return false;
}

}  // namespace patinate::studio
