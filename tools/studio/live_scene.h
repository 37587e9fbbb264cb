/// \file
/// Running scenes: each with a thread of its own, shared by the clients of its place.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tools/studio/live_engine.h"
#include "tools/studio/place.h"
#include "tools/studio/served_folder.h"
#include "tools/studio/server.h"

namespace patinate::studio {

/// State that running scenes share.
struct LiveMeans {
  int num_threads = 0;  ///< 0 = all.
  /// Called for every scene, on its thread; empty, or where it gives null: the CPU.
  std::function<std::shared_ptr<const simulation::SimulationDevice>()> open_device = {};
};

/// A LiveEngine in a thread. Thread-safe; calls but parted_mesh() return at once.
class LiveScene {
 public:
  /// Begins to read the scene; clients that have joined hear how far it is, and why it failed.
  /// @param path  A scene file, or the folder of a finished simulation. @param folder  Outlives this.
  LiveScene(const std::filesystem::path& path, PlaceKind kind, const ServedFolder& folder, LiveMeans means);
  ~LiveScene();
  /// Waits until what was done is kept, and lets go of its clients, whose connections hold it. Nothing is heard
  /// afterwards.
  void end();

  void join(int client, const std::shared_ptr<WebSocketPeer>& peer);
  void leave(int client);
  void receive(int client, std::string text);
  [[nodiscard]] int num_clients() const;
  /// Why it cannot run, in one line; "" while it can.
  [[nodiscard]] std::string problem() const;
  /// It has been read.
  [[nodiscard]] bool is_running() const;
  /// Where its objects are now. @throws InvalidInput with problem(); CannotComplete if it takes more than a minute to
  /// get there.
  [[nodiscard]] PartedMesh parted_mesh();

 private:
  void run(const std::filesystem::path& path, PlaceKind kind, const ServedFolder& folder, const LiveMeans& means,
           const std::stop_token& stop);
  void serve(std::unique_ptr<LiveEngine> engine, const LiveMeans& means, const RunControl& control);
  void tell_all(const std::string& text);
  void post(std::function<void(LiveEngine&)> task);

  mutable std::mutex mutex_;
  std::condition_variable_any has_task_;
  std::vector<std::function<void(LiveEngine&)>> tasks_;
  std::size_t num_task_bytes_ = 0;                       ///< Bytes of messages that wait in them.
  std::map<int, std::shared_ptr<WebSocketPeer>> peers_;  ///< Connections of all clients.
  std::string problem_;                                  ///< Problem as problem().
  bool is_running_ = false;
  std::jthread thread_;  ///< Last: it uses the others.
};

/// The scenes that run, one a place; of those that nobody watches the last few are kept, unless their file changes.
/// Thread-safe.
class LiveScenes {
 public:
  /// @param folder  Outlives this.
  LiveScenes(const ServedFolder& folder, LiveMeans means) : folder_(folder), means_(std::move(means)) {}
  /// Ends them all, also those that are watched.
  ~LiveScenes();
  LiveScenes(const LiveScenes&) = delete;
  LiveScenes& operator=(const LiveScenes&) = delete;

  /// A new client of a place. @returns who hears its messages.
  [[nodiscard]] std::shared_ptr<WebSocketListener> open(const std::filesystem::path& path, PlaceKind kind,
                                                        const std::shared_ptr<WebSocketPeer>& peer);
  /// The scene of a place, which may have failed; nothing if nobody has opened it, or it has ended.
  [[nodiscard]] std::shared_ptr<LiveScene> find(const std::filesystem::path& path);

 private:
  struct Entry {
    std::filesystem::path path;
    std::filesystem::file_time_type changed;
    std::shared_ptr<LiveScene> scene;
  };
  const ServedFolder& folder_;
  LiveMeans means_;
  std::mutex mutex_;
  std::list<Entry> entries_;  ///< Last opened first.
  int num_clients_ = 0;       ///< Ever: numbers of clients.
};

}  // namespace patinate::studio
