/// \file
/// A running scene and its clients, without threads or sockets: what docs/studio_protocol.md says of /api/live.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/image/image.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"
#include "simulation/rules/rule_io.h"
#include "tools/studio/material_plane.h"
#include "tools/studio/mesh_glb.h"
#include "tools/studio/overlay_plane.h"
#include "tools/studio/recording.h"
#include "tools/studio/scene_record.h"
#include "tools/studio/served_folder.h"
#include "tools/studio/server.h"
#include "tools/studio/tile_messages.h"
#include "tools/studio/tile_planes.h"

namespace patinate::studio {

struct LiveOptions {
  simulation::ColorForm color_form = simulation::ColorForm::Normalized;
  int num_threads = 0;
  std::shared_ptr<const simulation::SimulationDevice> device = nullptr;  ///< Device of this scene alone; null: the CPU.
  double most_updates_s = 60.0;                                          ///< To one client.
  std::filesystem::path place;     ///< Recordings are of this place, below the served folder; "" = nothing is recorded.
  std::filesystem::path finished;  ///< A simulation folder whose end is where it begins; "" = the start of the scene.
  std::shared_ptr<const Json> document = nullptr;  ///< What the scene was read from; null: its file.
  std::shared_ptr<simulation::SceneAssets> assets = std::make_shared<simulation::SceneAssets>();  ///< Read so far.
};

/// Not thread-safe: one thread calls. Peers are called from it.
class LiveEngine {
 public:
  /// @throws InvalidInput, IoError as Simulation and read_scene().
  LiveEngine(simulation::SceneFile file, const ServedFolder& folder, const LiveOptions& options,
             const RunControl& control);
  ~LiveEngine();

  /// Sends hello.
  void join(int client, std::shared_ptr<WebSocketPeer> peer);
  /// Pauses when none is left.
  void leave(int client);
  /// One message of a client; what is wrong with it is its answer.
  void receive(int id, const std::string& text);
  /// An iteration if it runs, then what is due to each client. @returns whether there is more to do at once.
  bool advance(const std::stop_token& stop);

  [[nodiscard]] bool is_running() const { return is_running_; }
  [[nodiscard]] const simulation::Simulation& simulation() const { return simulation_; }
  [[nodiscard]] const TilePlanes& planes() const { return planes_; }
  [[nodiscard]] ReliefRange relief() const { return relief_; }
  /// Whether the scene is to be built anew: take_next() then.
  [[nodiscard]] bool has_next() const { return next_.has_value(); }
  /// The engine of the scene that an edit, undo or redo has made; this one has then given it its clients and ends.
  /// @param device  As LiveOptions::device. @returns null where that scene cannot be built: this one goes on.
  [[nodiscard]] std::unique_ptr<LiveEngine> take_next(std::shared_ptr<const simulation::SimulationDevice> device,
                                                      const RunControl& control);
  /// One part an object, where they are now.
  [[nodiscard]] PartedMesh parted_mesh() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Client;
  /// All that undo and redo bring back.
  struct Moment {
    std::vector<std::byte> state;
    SceneRecord::Events events;
    std::optional<double> slider;
    std::int64_t picture_of = 0;
    std::string opened;
  };
  /// A scene as it was written, with what set_appearance() has changed.
  struct Document {
    std::shared_ptr<const Json> root;
    bool is_edited = false;  ///< It is not that of the file any more.
  };
  /// The scene that comes after this one.
  struct Next {
    enum What { Edit, Undo, Redo, Resume };
    What what = Edit;
    std::int64_t count = 1;  ///< Of steps that are undone or redone.
    std::string label = {};
    std::shared_ptr<const Json> document = nullptr;
    int client = 0;                                 ///< Who asks.
    std::shared_ptr<const Json> request = nullptr;  ///< Its number; null = none waits.
    [[nodiscard]] Json request_id() const;
  };
  /// What set_appearance() changes.
  struct AppearanceState {
    std::vector<simulation::MaterialAppearance> shown;
    SceneRecord::Appearance recorded;
  };
  /// An event that undoes another one, as scene files have it, without its iteration.
  struct BackEvent {
    std::string key;  ///< What it sets: of several that set the same, the first one counts.
    std::shared_ptr<const Json> event;
  };
  /// What a step is called, and which others it is one with.
  struct StepName {
    std::string label, key;
    std::int64_t gesture = 0;
  };
  /// One step that undo takes back, or redo brings again: one of the three is set, and is exchanged for its opposite.
  /// A moment of another scene has its document.
  struct Step {
    std::string label;           ///< "Ratio 0.6"
    std::int64_t iteration = 0;  ///< When it was made.
    std::string key;             ///< Changes of the same, in one go of a hand or soon after, are one; "" = of its own.
    std::int64_t gesture = 0;    ///< Number that the client gives each go of a hand; 0 = it gives none.
    Clock::time_point made{};
    std::vector<BackEvent> events;  ///< Settings, moves.
    std::optional<AppearanceState> appearance;
    std::optional<Moment> moment;  ///< Strokes, returns to the start, edits.
    std::optional<Document> document;
    bool is_stroke = false;           ///< The iterations since are done again without it.
    std::size_t num_events_then = 0;  ///< Of the record, at the end of the stroke.
  };
  /// One that continues.
  struct Stroke {
    std::string emitter;
    const Client* client = nullptr;    ///< Whose hand it is.
    std::vector<BackEvent> afterward;  ///< Sets what an eraser had to change.
    std::shared_ptr<Json> shown;       ///< What clients see of that meanwhile: what it was.
    std::deque<Vec3> ahead;            ///< mm; where the brush has still to go.
    Vec3 at{0, 0, 0};                  ///< mm; the last place of `ahead` ever.
    bool is_lifted = false;            ///< It ends when `ahead` is empty.
    Clock::time_point painted{};
  };

  /// A recording that is gone through again, or the iterations after a stroke that was undone.
  struct Replay {
    SceneRecord::Events events;
    std::size_t num_done = 0;
    std::int64_t until = 0;
    bool is_recording = true;
    bool goes_on = false;  ///< It was running, and runs on behind `until`.
  };

  // live_recording.cpp
  void open_recording();
  [[nodiscard]] Json recording_json() const;
  void keep(bool is_last);
  void resume();
  void begin_replay();
  void stop_replay();
  [[nodiscard]] bool go_through(const std::stop_token& stop);
  // live_finished.cpp
  void open_finished();
  void refuse_picture() const;
  [[nodiscard]] std::int64_t iteration() const;
  /// Another one for each state of a run; go_to() tells clients in another way.
  [[nodiscard]] std::int64_t state_number() const { return simulation_.iteration() + simulation_.num_paint_steps(); }
  // live_engine.cpp
  void step(const std::stop_token& stop);
  void send_all(const std::string& text);
  void send_status();
  void make_status();
  void send_scene();
  [[nodiscard]] Json scene_json() const;
  // live_commands.cpp
  struct Commands;
  void apply(const Json& event_mm, const StepName& name);
  void perform(const Json& event_of_file, const simulation::SceneEvent& parsed);
  void set_appearance(const Json& changes, std::int64_t gesture);
  void set_looks(std::vector<simulation::MaterialAppearance> looks);
  void show_film(bool is_shown);
  // live_stroke.cpp
  void begin_stroke(const Client& client, const std::string& emitter, const std::vector<Vec3>& way,
                    const std::vector<std::string>& erased);
  void begin_erasing(const std::vector<std::string>& erased);
  void finish_erasing();
  void move_stroke(const Client& client, const std::vector<Vec3>& way, bool jumps, bool is_lifted);
  [[nodiscard]] bool can_paint(const std::string& emitter) const;
  void lengthen(const std::vector<Vec3>& way, bool jumps);
  void paint();
  void paint_at(const std::string& emitter, const Vec3& position_mm);
  void catch_up();
  void finish_stroke();
  // live_moments.cpp
  [[nodiscard]] Moment moment();
  void go_to(const Moment& moment);
  [[nodiscard]] Step* step_that_goes_on(const StepName& name);
  Step& new_step(const StepName& name);
  void remember(const std::string& label, bool is_stroke);
  void remember_event(const StepName& name, std::vector<BackEvent> back);
  void remember_appearance(const StepName& name, std::optional<AppearanceState> before);
  void undo(std::int64_t count);
  void redo(std::int64_t count);
  void exchange(Step& step, bool is_undo);
  void do_again(std::int64_t until, SceneRecord::Events events, bool goes_on);
  void forget_the_oldest();
  [[nodiscard]] bool is_doing_again() const { return replay_ && !replay_->is_recording; }
  [[nodiscard]] Json steps_json() const;
  // live_document.cpp
  [[nodiscard]] Json document() const;
  [[nodiscard]] std::uint64_t document_state() const { return record_.version() + (std::uint64_t{num_edits_} << 32); }
  [[nodiscard]] Json edited(const Json& patch, std::uint64_t state) const;
  [[nodiscard]] simulation::SceneFile read(const Json& document, const RunControl& control) const;
  void check_document(const Json& document) const;
  [[nodiscard]] Json check(const Json& patch, std::uint64_t state) const;
  void edit(const Json& patch, std::uint64_t state, const std::string& label);
  [[nodiscard]] Document written() const;
  [[nodiscard]] static std::int64_t num_edits_at_end(const std::deque<Step>& steps, std::int64_t most);
  void leave_scene(Next::What what, std::int64_t count);
  void follow(LiveEngine& before, const Next& next);
  // live_opposites.cpp
  [[nodiscard]] std::vector<BackEvent> opposite(const simulation::SceneEvent& event) const;
  void perform_now(const Json& event_without_iteration);
  // live_updates.cpp
  void refresh();
  void measure_overlays();
  [[nodiscard]] bool is_due(const Client& client) const;
  void send_update(Client& client);
  void send_gammatons(Client& client);
  // live_output.cpp
  void as_exported(const std::function<void()>& work);
  void save(const std::string& name);
  void export_to(const std::string& name, const std::vector<std::string>& what,
                 const std::shared_ptr<WebSocketPeer>& peer);
  [[nodiscard]] Json outcome();
  [[nodiscard]] static Json exported_json(const std::string& name, const std::filesystem::path& folder);
  [[nodiscard]] Json probe(int x, int y);

  const ServedFolder& folder_;
  LiveOptions options_;
  simulation::SceneFile file_;
  SceneRecord record_;
  simulation::Simulation simulation_;
  ScreenLayout layout_;
  TilePlanes planes_;
  ReliefRange relief_;
  std::map<std::string, OverlayPlane> overlays_;
  std::optional<MaterialPlane> material_;              ///< While somebody watches it.
  std::vector<simulation::MaterialAppearance> looks_;  ///< As set; the simulation's are those below the film where one
                                                       ///< is shown.
  std::map<int, std::unique_ptr<Client>> clients_;
  std::vector<std::byte> start_;
  ImageU8 start_color_;      ///< What it looked like then.
  std::deque<Step> past_;    ///< The last one is undone first.
  std::deque<Step> future_;  ///< Undone; the last one is redone first.
  std::optional<Next> next_;
  bool is_edited_ = false;       ///< The scene is not that of its file any more.
  std::uint32_t num_edits_ = 0;  ///< Of this scene and those before it.
  std::optional<Stroke> stroke_;
  std::optional<double> slider_, start_slider_;       ///< Sliders of Figure 10, unless the behavior was set otherwise.
  std::vector<simulation::RuleAsset> fitting_rules_;  ///< Built-in ones whose materials the scene has.
  std::shared_ptr<Json> said_;                        ///< scene_json() as clients know it.
  std::string opened_;                                ///< Text for clients about where it began.
  std::int64_t picture_of_ = 0;  ///< Iterations behind the amounts that are shown without their gammatons: nothing can
                                 ///< resume from there. 0 = all is there.
  bool is_running_ = false;
  std::int64_t num_steps_left_ = 0;  ///< Number of steps left of a `step`.
  Clock::time_point measured_{};     ///< Ranges of overlays.
  bool has_news_ = true;             ///< Something changed since the last status.
  std::string status_;               ///< The last one.
  Clock::time_point said_status_{};
  Clock::time_point counted_from_ = Clock::now();
  std::int64_t counted_iterations_ = 0;
  double iterations_per_s_ = 0.0;
  std::unique_ptr<RecordingFile> recording_;
  std::optional<Replay> replay_;
  bool is_resumed_ = false;         ///< The found recording has been gone through.
  bool is_keeping_ = false;         ///< There is a file of this run.
  std::uint64_t kept_version_ = 0;  ///< Kept version of the record, when it was written last.
  std::int64_t kept_iteration_ = 0;
  Clock::time_point kept_at_{};
  std::jthread exporting_;
  std::shared_ptr<std::atomic<bool>> is_exporting_;
};

}  // namespace patinate::studio
