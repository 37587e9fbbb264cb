#include "tools/studio/live_engine.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "simulation/job/frame_maps.h"
#include "simulation/tracing/gammatons.h"
#include "simulation/transport/ledger_json.h"
#include "tools/studio/live_client.h"
#include "tools/studio/scene_text.h"

namespace patinate::studio {

namespace {

constexpr double kStatusSeconds = 0.2;
constexpr std::size_t kMaxBytesBeforeStatus = std::size_t{1}
                                              << 20;  ///< A client that takes less gets no status meanwhile.

simulation::SimulationOptions simulation_options(const simulation::SceneFile& file, const LiveOptions& live) {
  simulation::SimulationOptions options{
      .parameter_maps = file.controls, .color_form = live.color_form, .device = live.device};
  if (!live.finished.empty()) return options;  // what was not counted then is not known
  if (std::find(options.parameter_maps.begin(), options.parameter_maps.end(), "hits") == options.parameter_maps.end())
    options.parameter_maps.push_back("hits");
  return options;
}

double memory_mb() {
  std::ifstream in("/proc/self/statm");
  double total = 0.0, resident = 0.0;
  in >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

std::optional<double> slider_of(const Json& root) {
  if (!root.contains("behavior") || !root.at("behavior").contains("slider")) return std::nullopt;
  return root.at("behavior").at("slider").get<double>();
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

std::string done_text(const Json& id, const Json& answer) {
  Json done{{"type", "done"}, {"id", id}};
  done.update(answer);
  return done.dump(-1, ' ', false, Json::error_handler_t::replace);
}
std::string error_text(const Json& id, const std::string& message) {
  return Json{{"type", "error"}, {"id", id}, {"message", message}}.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void refuse(WebSocketPeer& peer, const std::string& why) {
  peer.send_text(Json{{"type", "error"}, {"id", nullptr}, {"message", why}, {"fatal", true}}.dump(
      -1, ' ', false, Json::error_handler_t::replace));
  peer.refuse(why);
}

LiveEngine::LiveEngine(simulation::SceneFile file, const ServedFolder& folder, const LiveOptions& options,
                       const RunControl& control)
    : folder_(folder),
      options_(options),
      file_(std::move(file)),
      record_(file_, options.document ? *options.document : load_json(file_.file)),
      simulation_(with_brush(file_, record_), simulation_options(file_, options), control),
      layout_(simulation_.atlas().surface()),
      planes_(layout_),
      looks_(simulation_.scene().appearance),
      start_(simulation_.snapshot()),
      slider_(slider_of(*record_.written())),
      start_slider_(slider_),
      fitting_rules_(simulation::built_in_rules_for(file_.scene.materials)),
      is_exporting_(std::make_shared<std::atomic<bool>>(false)) {
  relief_.high_mm = simulation_.texel_size_mm();
  for (const simulation::MaterialAppearance& look : file_.scene.appearance)
    relief_.high_mm = std::max(relief_.high_mm, std::abs(look.height_mm));
  relief_.low_mm = -relief_.high_mm;
  refresh();
  start_color_ = simulation_.compose(control).color_srgb8();
  if (!options.finished.empty()) {
    open_finished();
    refresh();
  }
  open_recording();
  kept_version_ = record_.version();
  kept_iteration_ = iteration();
  said_ = std::make_shared<Json>(scene_json());
}

LiveEngine::~LiveEngine() {
  try {
    keep(true);
  } catch (const std::exception&) {
    // There is nobody left to tell; what was kept before is whole.
  }
}

void LiveEngine::join(int client, std::shared_ptr<WebSocketPeer> peer) {
  Json hello = *said_;
  hello["type"] = "hello";
  peer->send_text(hello.dump(-1, ' ', false, Json::error_handler_t::replace));
  clients_[client] = std::make_unique<Client>(std::move(peer), layout_.num_tiles());
  has_news_ = true;
}

void LiveEngine::leave(int client) {
  const auto found = clients_.find(client);
  if (found == clients_.end()) return;
  if (stroke_ && stroke_->client == found->second.get()) finish_stroke();
  clients_.erase(found);
  has_news_ = true;
  if (!clients_.empty()) {
    show_film(std::any_of(clients_.begin(), clients_.end(), [](const auto& c) { return c.second->wants_material; }));
    return;
  }
  is_running_ = false;
  num_steps_left_ = 0;
  overlays_.clear();
  show_film(false);
  keep(true);
}

void LiveEngine::send_all(const std::string& text) {
  for (const auto& [id, client] : clients_) client->peer->send_text(text);
}

Json LiveEngine::scene_json() const {
  const simulation::Scene& scene = simulation_.scene();
  const Box box = bounding_box(simulation_.mesh());
  Json overlays = Json::array();
  const auto add_overlay = [&](const std::string& name, const std::string& unit) {
    Json overlay{{"name", name}, {"unit", unit}, {"high", 1.0}};
    if (const auto shown = overlays_.find(name); shown != overlays_.end()) {
      const OverlayRange& range = shown->second.range();
      overlay.update({{"high", shown->second.high()}, {"range", {range.low, range.high}}, {"most", range.most}});
    }
    overlays.push_back(std::move(overlay));
  };
  for (const std::string& m : scene.materials) add_overlay(m, "amount");
  for (const std::string& name : simulation_options(file_, options_).parameter_maps) {
    if (name.find(".final") != std::string::npos) continue;  // is the amount
    const std::string unit = simulation_.parameter_map(name).unit;
    add_overlay(name, unit == "time" ? std::string(shown_time_unit(file_.time_unit)) : unit);
  }
  const auto name_of = [&](int material) {
    return material < 0 ? Json(nullptr) : Json(scene.materials[static_cast<std::size_t>(material)]);
  };
  std::vector<std::string> notes = file_.notes;
  if (!opened_.empty()) notes.insert(notes.begin(), opened_);
  for (const std::string& note : simulation_.notes()) {
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
  }
  Json json{{"type", "scene"},
            {"name", file_.name},
            {"width", layout_.width()},
            {"height", layout_.height()},
            {"materials", scene.materials},
            {"appearance", appearance_json(scene, looks_)},
            {"look",
             {{"metal", simulation::TexelMetal::is_in(scene)},
              {"film", name_of(MaterialPlane::film_of(scene))},
              {"plants", name_of(simulation::plant_material(scene))}}},
            {"emitters", emitters_json(scene)},
            {"objects", objects_json(scene)},
            {"behavior", behavior_json(scene.behavior)},
            {"slider", slider_ ? Json(*slider_) : Json(nullptr)},
            {"exchange", exchange_json(scene)},
            {"rules", rules_json(scene)},
            {"more_rules", more_rules_json(scene, fitting_rules_)},
            {"time_unit", shown_time_unit(file_.time_unit)},
            {"time_per_iteration", scene.time_per_iteration},
            {"overlays", std::move(overlays)},
            {"relief_mm", {relief_.low_mm, relief_.high_mm}},
            {"bounds_mm", {{box.low.x(), box.low.y(), box.low.z()}, {box.high.x(), box.high.y(), box.high.z()}}},
            {"notes", notes},
            {"steps", steps_json()},
            {"edited", is_edited_ || record_.num_events() > 0 || !record_.appearance().empty()},
            {"can_edit", options_.finished.empty()},
            {"recording", recording_json()}};
  if (stroke_ && stroke_->shown) json.update(*stroke_->shown);
  return json;
}

void LiveEngine::send_scene() {
  Json now = scene_json(), changed = Json::object();
  for (const auto& [key, value] : now.items()) {
    if ((*said_)[key] != value) changed[key] = value;
  }
  *said_ = std::move(now);
  if (changed.empty()) return;
  changed["type"] = "scene";
  send_all(changed.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// To everyone who listens now; to the others once they do.
void LiveEngine::send_status() {
  make_status();
  for (const auto& [id, client] : clients_) {
    if (!client->wants_status || client->peer->num_waiting_bytes() >= kMaxBytesBeforeStatus) continue;
    client->peer->send_text(status_);
    client->wants_status = false;
  }
}

void LiveEngine::make_status() {
  if (seconds_since(said_status_) < kStatusSeconds || !(has_news_ || is_running_)) return;
  if (const double span = seconds_since(counted_from_); span > 1.0) {
    iterations_per_s_ = static_cast<double>(std::exchange(counted_iterations_, 0)) / span;
    counted_from_ = Clock::now();
  }
  const simulation::TraceCounters& c = simulation_.counters();
  status_ = Json{{"type", "status"},
                 {"running", is_running_},
                 {"iteration", iteration()},
                 {"time", rounded(static_cast<double>(iteration()) * simulation_.scene().time_per_iteration, 12)},
                 {"iterations_per_s", is_running_ ? iterations_per_s_ : 0.0},
                 {"counters",
                  {{"emitted", c.emitted},
                   {"absorbed", c.absorbed},
                   {"left", c.left},
                   {"rested", c.rested},
                   {"alive", c.alive},
                   {"segments", c.segments},
                   {"contacts", c.contacts}}},
                 {"ledger", simulation::ledger_json(simulation_.ledger(), simulation_.scene().materials)},
                 {"clients", clients_.size()},
                 {"painting", stroke_.has_value()},
                 {"catching_up", is_doing_again() ? Json(replay_->until) : Json(nullptr)},
                 {"can_undo", !past_.empty()},
                 {"can_redo", !future_.empty()},
                 {"exporting", is_exporting_->load()},
                 {"memory_mb", memory_mb()}}
                .dump();
  for (const auto& [id, client] : clients_) client->wants_status = true;
  said_status_ = Clock::now();
  has_news_ = false;
}

void LiveEngine::step(const std::stop_token& stop) {
  if (replay_ && !go_through(stop)) return send_scene();
  simulation_.step({.on_progress = {}, .stop = stop, .num_threads = options_.num_threads});
  ++counted_iterations_;
  has_news_ = true;
  if (num_steps_left_ > 0 && --num_steps_left_ == 0) is_running_ = false;
}

bool LiveEngine::advance(const std::stop_token& stop) {
  keep(false);  // before an iteration, which may take long
  if (stroke_) {
    paint();  // weather and time stand still meanwhile
  } else if (is_running_) {
    step(stop);
  }
  measure_overlays();
  if (std::any_of(clients_.begin(), clients_.end(), [&](const auto& c) { return is_due(*c.second); })) {
    refresh();
    for (const auto& [id, client] : clients_) {
      if (is_due(*client)) send_update(*client);
    }
  }
  send_status();
  return stroke_ ? stroke_->is_lifted || !stroke_->ahead.empty() : is_running_;
}

PartedMesh LiveEngine::parted_mesh() const {
  const simulation::Scene& scene = simulation_.scene();
  PartedMesh mesh{.mesh = simulation_.mesh(), .parts = {}};
  for (const simulation::SceneObject& object : scene.objects) mesh.parts.push_back({object.name, {}, {}});
  const simulation::SurfaceAtlas& surface = simulation_.atlas().surface();
  for (int t = 0; t < surface.num_triangles(); ++t) mesh.parts[surface.object(t)].triangles.push_back(t);
  return mesh;
}

}  // namespace patinate::studio
