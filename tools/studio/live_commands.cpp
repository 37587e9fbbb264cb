// Commands of clients to a running scene: a table from `op` to what it does.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/files/scene_event.h"
#include "simulation/files/scene_json.h"
#include "simulation/files/scene_lengths.h"
#include "simulation/job/frame_maps.h"
#include "tools/studio/live_client.h"
#include "tools/studio/live_labels.h"
#include "tools/studio/outside_json.h"
#include "tools/studio/scene_text.h"

namespace patinate::studio {

namespace {

constexpr std::size_t kMaxUnread = std::size_t{512} << 20;
constexpr std::int64_t kMaxGammatons = 100'000;
constexpr std::size_t kMaxLabel = 100;
constexpr std::size_t kMaxPositions = 10'000;  ///< Of a stroke in one message.

/// A member of a request, with an error that a person understands.
const Json& member(const Json& request, const char* key) {
  if (!request.contains(key)) throw InvalidInput(std::string("/") + key + ": is missing");
  return request.at(key);
}

std::string text_member(const Json& request, const char* key) {
  const Json& value = member(request, key);
  if (!value.is_string()) throw InvalidInput(std::string("/") + key + ": found " + value.dump() + "; expected text");
  return value.get<std::string>();
}

std::int64_t integer_member(const Json& request, const char* key, std::int64_t low, std::int64_t high) {
  const Json& value = member(request, key);
  if (!value.is_number_integer() || value.get<std::int64_t>() < low || value.get<std::int64_t>() > high) {
    throw InvalidInput(std::string("/") + key + ": found " + value.dump() + "; expected a whole number from " +
                       std::to_string(low) + " to " + std::to_string(high));
  }
  return value.get<std::int64_t>();
}

/// "position", or "positions" on the way of a stroke, mm.
std::vector<Vec3> positions(const Json& request) {
  std::vector<Vec3> way;
  const auto add = [&](const JsonReader& json) { way.push_back(simulation::read_position(json, 1.0)); };
  if (request.contains("position")) add(JsonReader("stroke", request.at("position"), "/position"));
  if (!request.contains("positions")) return way;
  for (const JsonReader& position : JsonReader("stroke", request.at("positions"), "/positions").elements(kMaxPositions))
    add(position);
  return way;
}

std::vector<std::string> texts_member(const Json& request, const char* key) {
  const Json& list = member(request, key);
  std::vector<std::string> texts;
  for (const Json& element : list.is_array() ? list : Json::array()) {
    if (element.is_string()) texts.push_back(element.get<std::string>());
  }
  if (!list.is_array() || texts.size() != list.size())
    throw InvalidInput(std::string("/") + key + ": found " + list.dump() + "; expected a list of names");
  return texts;
}

/// What two changes have in common that set the same to other numbers.
std::string without_numbers(const std::string& label) {
  std::string key;
  for (const char c : label) {
    if (!(c >= '0' && c <= '9') && c != '.' && c != '-') key += c;
  }
  return key;
}

/// What a change of looks is called, and what it has in common with others of the same.
std::pair<std::string, std::string> look_label(const Json& changes) {
  std::string label, key = "look";
  for (const auto& [material, members] : changes.items()) {
    for (const auto& [name, value] : members.items()) {
      label += (label.empty() ? "Look of " : ", ") + material + ": " + name;
      if (value.is_number()) label += " " + short_number_text(rounded(value.get<double>(), 3));
      key += " " + material + " " + name;
    }
  }
  return {label.empty() ? "Look" : label, key};
}

}  // namespace

struct LiveEngine::Commands {
  struct Call {
    LiveEngine& engine;
    Client& client;
    const Json& request;
    Json& answer;  ///< Members of what the client gets besides "done".
  };
  struct Command {
    std::string_view op;
    void (*run)(const Call& call);
  };

  static void run(const Call& c) {
    c.engine.refuse_picture();
    c.engine.opened_.clear();
    c.engine.is_running_ = true;
    c.engine.num_steps_left_ = 0;
    c.engine.counted_from_ = Clock::now();
    c.engine.counted_iterations_ = 0;
  }
  static void pause(const Call& c) {
    c.engine.is_running_ = false;
    c.engine.num_steps_left_ = 0;
  }
  static void step(const Call& c) {
    c.engine.refuse_picture();
    c.engine.num_steps_left_ =
        c.request.contains("iterations") ? integer_member(c.request, "iterations", 1, 1'000'000) : 1;
    c.engine.is_running_ = true;
    c.engine.opened_.clear();
  }
  static void reset(const Call& c) {
    c.engine.finish_stroke();
    if (c.engine.record_.num_events() > 0 || c.engine.iteration() > 0) c.engine.remember("Back to the start", false);
    c.engine.go_to(
        {.state = c.engine.start_, .events = {}, .slider = c.engine.start_slider_, .picture_of = 0, .opened = ""});
    c.engine.is_running_ = false;
    c.engine.num_steps_left_ = 0;
  }
  static std::int64_t gesture(const Call& c) {
    return c.request.contains("gesture") ? integer_member(c.request, "gesture", 1, 1'000'000'000) : 0;
  }
  static void event(const Call& c) {
    const std::string label = c.request.contains("label") ? text_member(c.request, "label") : "";
    if (label.size() > kMaxLabel) throw InvalidInput("/label: is longer than " + std::to_string(kMaxLabel) + " bytes");
    c.engine.apply(member(c.request, "event"), {.label = label, .key = label, .gesture = gesture(c)});
  }
  static void stroke(const Call& c) {
    const std::string phase = text_member(c.request, "phase");
    if (phase != "begin" && phase != "move" && phase != "end")
      throw InvalidInput("/phase: found \"" + phase + "\"; expected begin, move or end");
    const std::vector<Vec3> way = positions(c.request);
    if (phase == "begin") {
      if (way.empty()) (void)member(c.request, "position");
      const std::vector<std::string> erased =
          c.request.contains("erase") ? texts_member(c.request, "erase") : std::vector<std::string>();
      return c.engine.begin_stroke(c.client, text_member(c.request, "emitter"), way, erased);
    }
    const bool jumps = c.request.contains("jump") && c.request.at("jump") == true;
    c.engine.move_stroke(c.client, way, jumps, phase == "end");
  }
  static std::int64_t num_steps(const Call& c) {
    return c.request.contains("steps") ? integer_member(c.request, "steps", 1, 1000) : 1;
  }
  static void undo(const Call& c) { c.engine.undo(num_steps(c)); }
  static void redo(const Call& c) { c.engine.redo(num_steps(c)); }
  static void appearance(const Call& c) { c.engine.set_appearance(member(c.request, "appearance"), gesture(c)); }
  static void resume(const Call& c) { c.engine.resume(); }
  static void watch(const Call& c) {
    Client& client = c.client;
    if (c.request.contains("planes")) {
      const std::vector<std::string> planes = texts_member(c.request, "planes");
      const auto wants = [&](const char* name) {
        return std::find(planes.begin(), planes.end(), name) != planes.end();
      };
      for (const std::string& plane : planes) {
        if (plane != "surface" && plane != "relief" && plane != "material" && plane != "overlay")
          throw InvalidInput("/planes: found \"" + plane + "\"; expected surface, relief, material or overlay");
      }
      client.wants_surface = wants("surface");
      client.wants_relief = wants("relief");
      if (wants("material") != client.wants_material) watch_material(c, wants("material"));
    }
    if (c.request.contains("overlay")) watch_overlay(c, c.request.at("overlay"));
    if (c.request.contains("gammatons"))
      client.num_gammatons = integer_member(c.request, "gammatons", 0, kMaxGammatons);
    client.shown_state = -1;
  }
  static void watch_material(const Call& c, bool is_wanted) {
    c.client.wants_material = is_wanted;
    if (is_wanted) c.client.material.add_all();
    const auto& all = c.engine.clients_;
    c.engine.show_film(std::any_of(all.begin(), all.end(), [](const auto& one) { return one.second->wants_material; }));
  }
  static void watch_overlay(const Call& c, const Json& asked) {
    LiveEngine& e = c.engine;
    const std::string name = asked.is_null() ? "" : text_member(c.request, "overlay");
    if (name == c.client.overlay_name) return;
    if (!name.empty()) {
      const auto [overlay, is_new] = e.overlays_.try_emplace(name, name, e.simulation_, e.layout_);
      (void)overlay->second.update(e.simulation_);
      if (is_new) (void)overlay->second.measure(e.simulation_);
      c.client.overlay.add_all();
    }
    c.client.overlay_name = name;
    std::erase_if(e.overlays_, [&](const auto& overlay) {
      return std::none_of(e.clients_.begin(), e.clients_.end(),
                          [&](const auto& other) { return other.second->overlay_name == overlay.first; });
    });
  }
  static void hash(const Call& c) { c.client.wants_hash = true; }
  static void save(const Call& c) { c.engine.save(text_member(c.request, "path")); }
  static void export_all(const Call& c) {
    c.engine.export_to(text_member(c.request, "path"), texts_member(c.request, "what"), c.client.peer);
  }
  static void outcome(const Call& c) {
    c.engine.catch_up();
    c.client.peer->send_text(c.engine.outcome().dump(-1, ' ', false, Json::error_handler_t::replace));
  }
  static void probe(const Call& c) {
    const int x = static_cast<int>(integer_member(c.request, "x", 0, c.engine.layout_.width() - 1));
    const int y = static_cast<int>(integer_member(c.request, "y", 0, c.engine.layout_.height() - 1));
    c.client.peer->send_text(c.engine.probe(x, y).dump(-1, ' ', false, Json::error_handler_t::replace));
  }
  static std::uint64_t state(const Call& c) {
    return static_cast<std::uint64_t>(integer_member(c.request, "state", 0, std::int64_t{1} << 60));
  }
  static void document(const Call& c) {
    const Json document = c.engine.document();
    c.answer = {{"document", document}, {"state", c.engine.document_state()}, {"text", readable_text(document)}};
  }
  static void check(const Call& c) { c.answer = {{"problem", c.engine.check(member(c.request, "patch"), state(c))}}; }
  static void edit(const Call& c) {
    const std::string label = text_member(c.request, "label");
    if (label.empty() || label.size() > kMaxLabel)
      throw InvalidInput("/label: found \"" + label + "\"; expected 1 to " + std::to_string(kMaxLabel) + " bytes");
    c.engine.edit(member(c.request, "patch"), state(c), label);
  }
  static void cancel(const Call& c) { c.engine.exporting_.request_stop(); }

  static constexpr std::array kAll{Command{"run", run},       Command{"pause", pause},
                                   Command{"step", step},     Command{"reset", reset},
                                   Command{"event", event},   Command{"stroke", stroke},
                                   Command{"undo", undo},     Command{"redo", redo},
                                   Command{"resume", resume}, Command{"appearance", appearance},
                                   Command{"watch", watch},   Command{"hash", hash},
                                   Command{"save", save},     Command{"export", export_all},
                                   Command{"cancel", cancel}, Command{"outcome", outcome},
                                   Command{"probe", probe},   Command{"document", document},
                                   Command{"check", check},   Command{"edit", edit}};
};

void LiveEngine::receive(int id, const std::string& text) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  Client& client = *found->second;
  Json request;
  if (client.peer->num_waiting_bytes() > kMaxUnread) return client.peer->close();  // asks, and does not listen
  try {
    request = parse_outside_json(text);
  } catch (const IoError& e) {
    return client.peer->send_text(error_text(nullptr, e.what()));
  }
  const Json request_id = request.is_object() && request.contains("id") ? request["id"] : Json(nullptr);
  try {
    if (!request.is_object()) throw InvalidInput("found no object; expected {\"op\": ...}");
    const std::string op = text_member(request, "op");
    if (op == "ack") {
      client.num_acknowledged =
          std::max(client.num_acknowledged, integer_member(request, "update", 0, client.num_sent));
      return;
    }
    const auto command = std::find_if(Commands::kAll.begin(), Commands::kAll.end(),
                                      [&](const Commands::Command& c) { return c.op == op; });
    if (command == Commands::kAll.end())
      throw InvalidInput(
          "/op: found \"" + op +
          "\"; expected run, pause, step, reset, event, stroke, undo, redo, resume, appearance, watch, ack, "
          "hash, save, export, cancel, outcome, probe, document, check or edit");
    Json answer = Json::object();
    command->run({*this, client, request, answer});
    has_news_ = true;
    if (next_) {  // The scene that comes answers.
      next_->client = id;
      next_->request = std::make_shared<const Json>(request_id);
      return;
    }
    client.peer->send_text(done_text(request_id, answer));
    send_scene();
  } catch (const std::exception& e) {
    client.peer->send_text(error_text(request_id, e.what()));
  }
}

void LiveEngine::set_appearance(const Json& changes, std::int64_t gesture) {
  const simulation::Scene& scene = simulation_.scene();
  simulation::SceneContext context;
  context.materials = scene.materials;
  context.read_picture = [](const JsonReader& json, int) -> ImageF { json.fail("a color [r, g, b]"); };
  const JsonReader reader("appearance", changes);
  std::vector<simulation::MaterialAppearance> appearance = looks_;
  Json cleaned = Json::object();
  for (const std::string& name : reader.keys()) {
    const Json said = name;
    const auto i =
        static_cast<std::size_t>(simulation::material_index(JsonReader("appearance", said), name, scene.materials));
    cleaned[name] = changes.at(name);
    if (cleaned[name].is_object() && cleaned[name].contains("color") && cleaned[name]["color"].is_null())
      cleaned[name].erase("color");  // a picture or colors by amount, as it was sent
    appearance[i] = simulation::read_material_appearance(JsonReader("appearance", cleaned[name], "/" + name),
                                                         appearance[i], context);
  }
  const auto [label, key] = look_label(cleaned);
  const StepName step{.label = label, .key = key, .gesture = gesture};
  std::optional<AppearanceState> before;
  if (!step_that_goes_on(step)) before = AppearanceState{looks_, record_.appearance_state()};
  set_looks(std::move(appearance));
  for (const auto& [name, change] : cleaned.items()) record_.set_appearance(name, change);
  for (const auto& [id, client] : clients_) client->shown_state = -1;
  remember_appearance(step, std::move(before));
}

/// Below a film that is shown, water adds no color of its own.
void LiveEngine::set_looks(std::vector<simulation::MaterialAppearance> looks) {
  const simulation::Scene& scene = simulation_.scene();
  looks_ = std::move(looks);
  simulation_.set_appearance(
      material_ && MaterialPlane::film_of(scene) >= 0 ? simulation::looks_below_film(scene, looks_) : looks_);
  if (material_) material_->forget();  // What covers metal depends on strengths.
}

/// While somebody watches what texels are made of, water is a film: the surface is composed without it.
void LiveEngine::show_film(bool is_shown) {
  if (is_shown == material_.has_value()) return;
  if (material_) {
    material_.reset();
  } else {
    material_.emplace(simulation_, layout_,
                      RunControl{.on_progress = {}, .stop = {}, .num_threads = options_.num_threads});
  }
  set_looks(std::move(looks_));
}

/// @param name  Without a label: by what the event does.
void LiveEngine::apply(const Json& event_mm, const StepName& name) {
  refuse_picture();
  const Json event = event_of_file(event_mm, file_.mm_per_unit, simulation_.iteration());
  const simulation::SceneEvent parsed = parse_event(event, simulation_.scene(), file_.mm_per_unit);
  catch_up();  // what was painted before this was painted as things were then
  StepName said = name;
  if (said.label.empty()) {
    said.label = label_of(parsed, simulation_.scene());
    said.key = without_numbers(said.label);
  }
  if (std::holds_alternative<simulation::PaintEvent>(parsed.what)) {
    remember(said.label, true);
    perform(event, parsed);
    past_.back().num_events_then = record_.num_events();
    return;
  }
  std::vector<BackEvent> back = opposite(parsed);
  perform(event, parsed);
  remember_event(said, std::move(back));
}

void LiveEngine::perform(const Json& event, const simulation::SceneEvent& parsed) {
  simulation_.apply(parsed);
  if (!is_doing_again()) stop_replay();
  record_.add_event(event);
  if (stroke_ && !can_paint(stroke_->emitter)) finish_stroke();
  if (std::holds_alternative<simulation::BehaviorEvent>(parsed.what)) {
    slider_ =
        event["behavior"].contains("slider") ? std::optional(event["behavior"]["slider"].get<double>()) : std::nullopt;
  }
}

}  // namespace patinate::studio
