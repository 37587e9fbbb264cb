// The scene as the document that it is in a file: shown, checked while it is typed, and edited. Every edit is a step;
// its scene is built anew, from the start.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "patinate/core/error.h"
#include "patinate/simulation/scene_io.h"
#include "tools/studio/live_client.h"

namespace patinate::studio {

namespace {

/// Texels along each side that an edit may ask for; a slip of the hand fills no memory. Files may have more.
constexpr int kMaxTexels = 4096;

/// What an error says of a document: the JSON pointer ("" = none) and the rest, without the file's name.
Json problem_json(const std::filesystem::path& file, const std::string& what) {
  std::string text = what, pointer;
  const std::string name = file.string() + ": ", folder = (file.parent_path() / "").string();
  const bool is_of_file = text.starts_with(name);
  if (is_of_file || text.starts_with(folder)) text = text.substr(is_of_file ? name.size() : folder.size());
  if (is_of_file && text.starts_with("/")) {
    const std::size_t end = std::min(text.find(": "), text.size());
    pointer = text.substr(0, end);
    text = text.substr(std::min(end + 2, text.size()));
  }
  return {{"pointer", pointer}, {"text", text}};
}

}  // namespace

/// Everything as it is set now, from the start of the scene on.
Json LiveEngine::document() const { return record_.settled(simulation_.scene()); }

/// @throws InvalidInput if the document has changed since, or the patch does not fit it.
Json LiveEngine::edited(const Json& patch, std::uint64_t state) const {
  if (!options_.finished.empty())
    throw InvalidInput("a finished simulation stays as it is; save its scene, and edit that");
  if (state != document_state()) throw InvalidInput("the scene was changed meanwhile; nothing was done, so try again");
  try {
    return document().patch(patch);
  } catch (const Json::exception& e) {
    throw InvalidInput(std::string("/patch: ") + e.what());
  }
}

simulation::SceneFile LiveEngine::read(const Json& document, const RunControl& control) const {
  return simulation::read_scene(file_.file, document, *options_.assets, control);
}

/// @throws IoError if it is no scene, or one that is too fine to be built here.
void LiveEngine::check_document(const Json& document) const {
  const int max = std::max(kMaxTexels, file_.scene.resolution);
  const Json atlas = document.contains("atlas") ? document.at("atlas") : Json();
  if (atlas.is_object() && atlas.contains("resolution") && atlas.at("resolution").is_number() &&
      atlas.at("resolution").get<double>() > max) {
    throw IoError(file_.file.string(), "/atlas/resolution: found " + atlas.at("resolution").dump() +
                                           "; expected at most " + std::to_string(max) +
                                           " here; patinate simulate takes more");
  }
  (void)read(document, {});
}

/// @returns what is wrong; null = nothing.
Json LiveEngine::check(const Json& patch, std::uint64_t state) const {
  const Json document = edited(patch, state);
  try {
    check_document(document);
  } catch (const InputError& e) {
    return problem_json(file_.file, e.what());
  }
  return nullptr;
}

void LiveEngine::edit(const Json& patch, std::uint64_t state, const std::string& label) {
  auto document = std::make_shared<const Json>(edited(patch, state));
  check_document(*document);
  finish_stroke();
  stop_replay();
  next_ = Next{.what = Next::Edit, .label = label, .document = std::move(document)};
}

/// Edits that follow each other are undone, or redone, at once: only the last scene is built.
std::int64_t LiveEngine::num_edits_at_end(const std::deque<Step>& steps, std::int64_t most) {
  std::int64_t count = 0;
  for (auto step = steps.rbegin(); step != steps.rend() && count < most && step->document; ++step) ++count;
  return count;
}

/// Undoes (or redoes) that many steps; the last one is an edit.
void LiveEngine::leave_scene(Next::What what, std::int64_t count) {
  const std::deque<Step>& steps = what == Next::Undo ? past_ : future_;
  const std::int64_t num_edits = num_edits_at_end(steps, count);
  next_ = Next{.what = what,
               .count = count,
               .document = steps[steps.size() - static_cast<std::size_t>(num_edits)].document->root};
}

LiveEngine::Document LiveEngine::written() const { return {record_.written(), is_edited_}; }

/// @returns nothing, after its client has been told, if there is no such scene: then this one goes on.
std::unique_ptr<LiveEngine> LiveEngine::take_next(std::shared_ptr<const simulation::SimulationDevice> device,
                                                  const RunControl& control) {
  const Next next = *std::exchange(next_, std::nullopt);
  const auto answer = [&](const std::string& text) {
    if (const auto found = clients_.find(next.client); found != clients_.end()) found->second->peer->send_text(text);
  };
  try {
    LiveOptions options = options_;
    options.device = std::move(device);
    options.place.clear();  // The recording goes on.
    options.document = next.document;
    auto engine = std::make_unique<LiveEngine>(read(*options.document, control.part(0.0, 0.5)), folder_, options,
                                               control.part(0.5, 1.0));
    engine->follow(*this, next);
    return engine;
  } catch (const Canceled&) {
    throw;
  } catch (const std::exception& e) {
    answer(error_text(next.request_id(), e.what()));
    return nullptr;
  }
}

/// Takes what outlives a scene from the one before.
Json LiveEngine::Next::request_id() const { return request == nullptr ? Json() : *request; }

void LiveEngine::follow(LiveEngine& before, const Next& next) {
  Moment then = before.moment();
  Document document = before.written();
  options_.place = before.options_.place;
  past_ = std::move(before.past_);
  future_ = std::move(before.future_);
  recording_ = std::move(before.recording_);
  is_resumed_ = before.is_resumed_;
  is_keeping_ = before.is_keeping_;
  exporting_ = std::move(before.exporting_);
  is_exporting_ = before.is_exporting_;
  is_edited_ = true;
  std::int64_t num_done = 1;
  num_edits_ = before.num_edits_ + 1;
  if (next.what == Next::Undo || next.what == Next::Redo) {
    auto& from = next.what == Next::Undo ? past_ : future_;
    auto& to = next.what == Next::Undo ? future_ : past_;
    num_done = num_edits_at_end(from, next.count);
    for (std::int64_t k = 0; k < num_done; ++k) {
      std::swap(*from.back().document, document);
      std::swap(*from.back().moment, then);
      to.push_back(std::move(from.back()));
      from.pop_back();
    }
    is_edited_ = document.is_edited;
    go_to(then);
  } else {
    Step& step = new_step({.label = next.label, .key = ""});
    step.iteration = before.iteration();
    step.document = document;
    step.moment = std::move(then);
    is_running_ = before.is_running_ && before.num_steps_left_ == 0;
  }
  forget_the_oldest();
  kept_version_ = record_.version() + 1;  // There is something to keep.
  if (next.what == Next::Resume) begin_replay();
  const std::int64_t num_left = next.count - num_done;
  if (num_left > 0 && next.what == Next::Undo && !past_.empty()) undo(num_left);
  if (num_left > 0 && next.what == Next::Redo && !future_.empty()) redo(num_left);
  refresh();
  said_ = std::make_shared<Json>(scene_json());
  for (auto& [id, client] : before.clients_) {
    join(id, client->peer);
    Client& here = *clients_.at(id);
    here.wants_surface = client->wants_surface;
    here.wants_relief = client->wants_relief;
    if (client->wants_material) {
      here.wants_material = true;
      here.material.add_all();
      show_film(true);
    }
    here.num_gammatons = client->num_gammatons;
    here.num_sent = here.num_acknowledged = client->num_sent;
  }
  if (next_) {  // It is not there yet.
    next_->client = next.client;
    next_->request = next.request;
    return;
  }
  if (const auto found = clients_.find(next.client); found != clients_.end())
    found->second->peer->send_text(done_text(next.request_id()));
}

}  // namespace patinate::studio
