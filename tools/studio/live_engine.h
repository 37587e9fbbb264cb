/// \file
/// A running scene and its clients, without threads or sockets: what docs/studio_protocol.md says of /api/live.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "libcommon/core/json.h"
#include "simulation/engine.h"
#include "simulation/rules/rule_io.h"
#include "simulation/scene/scene_io.h"
#include "tools/studio/overlay_plane.h"
#include "tools/studio/scene_record.h"
#include "tools/studio/served_folder.h"
#include "tools/studio/server.h"
#include "tools/studio/tile_messages.h"
#include "tools/studio/tile_planes.h"

namespace patinate {

struct LiveOptions {
  ColorForm color_form = ColorForm::Normalised;
  int num_threads = 0;
  double most_updates_s = 60.0;  ///< To one client.
  std::filesystem::path finished;  ///< A simulation folder whose end is where it begins; "" = the start of the scene.
};

/// Not thread-safe: one thread calls. Peers are called from it.
class LiveEngine {
 public:
  /// @throws InvalidInput, IoError as Simulation and read_scene().
  LiveEngine(SceneFile file, const ServedFolder& folder, const LiveOptions& options, const RunControl& control);
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
  [[nodiscard]] const Simulation& simulation() const { return simulation_; }
  [[nodiscard]] const TilePlanes& planes() const { return planes_; }
  [[nodiscard]] ReliefRange relief() const { return relief_; }
  /// One node an object, where they are now.
  [[nodiscard]] std::string mesh_glb() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Client;
  struct Stroke {
    std::vector<std::byte> before;
    std::size_t mark = 0;
    std::optional<double> slider;
  };

  // live_finished.cpp
  void open_finished();
  void refuse_picture() const;
  [[nodiscard]] std::int64_t iteration() const;
  // live_engine.cpp
  void step(const std::stop_token& stop);
  void send_all(const std::string& text);
  void send_status();
  void make_status();
  void send_scene();
  [[nodiscard]] Json scene_json() const;
  // live_commands.cpp
  struct Commands;
  void apply(const Json& event_mm);
  void begin_stroke(const std::string& emitter, const Json& position);
  void end_stroke();
  void go_back(std::span<const std::byte> snapshot, std::size_t mark);
  void add_brush();
  // live_updates.cpp
  void refresh();
  [[nodiscard]] bool is_due(const Client& client) const;
  void send_update(Client& client);
  void send_gammatons(Client& client);
  // live_output.cpp
  void save(const std::string& name);
  void export_to(const std::string& name, const std::vector<std::string>& what, const std::shared_ptr<WebSocketPeer>& peer);

  const ServedFolder& folder_;
  LiveOptions options_;
  SceneFile file_;
  SceneRecord record_;
  Simulation simulation_;
  ScreenLayout layout_;
  TilePlanes planes_;
  ReliefRange relief_;
  std::map<std::string, OverlayPlane> overlays_;
  std::map<int, std::unique_ptr<Client>> clients_;
  std::vector<std::byte> start_;
  std::deque<Stroke> strokes_;
  std::string brush_;        ///< The emitter of the stroke that goes on; "" = none.
  std::optional<double> slider_, start_slider_;  ///< Of Figure 10, unless the behaviour was set otherwise.
  std::vector<RuleAsset> fitting_rules_;         ///< Built-in ones whose materials the scene has.
  std::shared_ptr<Json> said_;  ///< scene_json() as clients know it.
  std::string opened_;            ///< What a client should know of where it began.
  std::int64_t picture_of_ = 0;   ///< Iterations behind the amounts that are shown without their gammatons: nothing can go on from there. 0 = all is there.
  bool is_running_ = false;
  std::int64_t num_steps_left_ = 0;  ///< Of a `step`.
  void measure_overlays();
  bool has_news_ = true;     ///< Something changed since the last status.
  std::string status_;       ///< The last one.
  Clock::time_point said_status_{};
  Clock::time_point counted_from_ = Clock::now();
  std::int64_t counted_iterations_ = 0;
  double iterations_per_s_ = 0.0;
  std::jthread exporting_;
  std::shared_ptr<std::atomic<bool>> is_exporting_;
};

}  // namespace patinate
  Clock::time_point measured_{};     ///< Ranges of overlays.
