#include "tools/studio/live_scene.h"

#include <algorithm>
#include <chrono>
#include <future>
#include <nlohmann/json.hpp>

#include "patinate/core/error.h"
#include "simulation/job/simulation_job.h"
#include "tools/studio/live_client.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxTasks = 10'000;
constexpr std::size_t kMaxTaskBytes = std::size_t{32} << 20;
constexpr std::size_t kMaxUnwatched = 2;
constexpr std::chrono::milliseconds kIdle{20};

/// Reads the scene of a place as it is run there.
std::pair<simulation::SceneFile, LiveOptions> source_of(const fs::path& path, PlaceKind kind, const LiveMeans& means,
                                                        const RunControl& control) {
  LiveOptions options;
  options.num_threads = means.num_threads;
  if (means.open_device) options.device = means.open_device();
  options.place = path;
  if (kind == PlaceKind::Scene) {
    options.document = std::make_shared<const Json>(load_json(path));
    return {simulation::read_scene(path, *options.document, *options.assets, control), options};
  }
  const simulation::SimulationManifest manifest = simulation::read_simulation_manifest(path);
  options.color_form = manifest.color_form;
  options.finished = path;
  std::error_code error;
  if (!fs::is_regular_file(manifest.scene, error))
    throw IoError(manifest.scene.string(),
                  "is not there any more: the simulation was made of this scene file; put it back to run it again");
  simulation::SceneFile file = simulation::read_scene(manifest.scene, control);
  manifest.apply_to(file);
  return {std::move(file), options};
}

}  // namespace

LiveScene::LiveScene(const fs::path& path, PlaceKind kind, const ServedFolder& folder, LiveMeans means)
    : thread_([this, path, kind, &folder, means = std::move(means)](const std::stop_token& stop) {
        run(path, kind, folder, means, stop);
      }) {}

LiveScene::~LiveScene() = default;

void LiveScene::end() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  std::map<int, std::shared_ptr<WebSocketPeer>> gone;
  const std::lock_guard lock(mutex_);
  gone.swap(peers_);
  tasks_.clear();
}

void LiveScene::tell_all(const std::string& text) {
  const std::lock_guard lock(mutex_);
  for (const auto& [id, peer] : peers_) peer->send_text(text);
}

void LiveScene::run(const fs::path& path, PlaceKind kind, const ServedFolder& folder, const LiveMeans& means,
                    const std::stop_token& stop) {
  try {
    double said = -1.0;
    RunControl control{.on_progress = {}, .stop = stop, .num_threads = means.num_threads};
    control.on_progress = [&](double f) {
      if (f - said < 0.02 && f < 1.0) return;
      said = f;
      tell_all(Json{{"type", "progress"}, {"text", "Reading the scene"}, {"done", f}, {"total", 1}}.dump());
    };
    auto [file, options] = source_of(path, kind, means, control.part(0.0, 0.5));
    auto engine = std::make_unique<LiveEngine>(std::move(file), folder, options, control.part(0.5, 1.0));
    serve(std::move(engine), means, control);
  } catch (const Canceled&) {
  } catch (const std::exception& e) {
    const std::lock_guard lock(mutex_);
    problem_ = e.what();
    tasks_.clear();  // whoever waits for one hears that it will not come
    for (const auto& [id, peer] : peers_) refuse(*peer, problem_);
  }
}

void LiveScene::serve(std::unique_ptr<LiveEngine> engine, const LiveMeans& means, const RunControl& control) {
  const std::stop_token& stop = control.stop;
  {
    const std::lock_guard lock(mutex_);
    is_running_ = true;
  }
  bool has_more = false;
  while (!stop.stop_requested()) {
    std::vector<std::function<void(LiveEngine&)>> tasks;
    {
      std::unique_lock lock(mutex_);
      const auto wait = peers_.empty() ? std::chrono::milliseconds(1000) : kIdle;
      if (!has_more) has_task_.wait_for(lock, stop, wait, [&] { return !tasks_.empty(); });
      tasks.swap(tasks_);
      num_task_bytes_ = 0;
    }
    for (const auto& task : tasks) {
      task(*engine);
      while (engine->has_next()) {
        auto next = engine->take_next(means.open_device ? means.open_device() : nullptr, control);
        if (next) engine = std::move(next);
      }
    }
    has_more = engine->advance(stop);
  }
}

void LiveScene::post(std::function<void(LiveEngine&)> task) {
  {
    const std::lock_guard lock(mutex_);
    if (!problem_.empty()) return;  // `task` goes unheard, and whoever waits for it hears that
    tasks_.push_back(std::move(task));
  }
  has_task_.notify_one();
}

void LiveScene::join(int client, const std::shared_ptr<WebSocketPeer>& peer) {
  {
    const std::lock_guard lock(mutex_);
    if (!problem_.empty()) {
      return refuse(*peer, problem_);
    }
    peers_[client] = peer;
  }
  post([client, peer](LiveEngine& engine) { engine.join(client, peer); });
}

void LiveScene::leave(int client) {
  {
    const std::lock_guard lock(mutex_);
    peers_.erase(client);
  }
  post([client](LiveEngine& engine) { engine.leave(client); });
}

void LiveScene::receive(int client, std::string text) {
  {
    const std::lock_guard lock(mutex_);
    num_task_bytes_ += text.size();
    if (tasks_.size() > kMaxTasks || num_task_bytes_ > kMaxTaskBytes) {  // asks faster than anything can be done
      if (const auto found = peers_.find(client); found != peers_.end()) found->second->close();
      return;
    }
  }
  post([client, text = std::move(text)](LiveEngine& engine) { engine.receive(client, text); });
}

int LiveScene::num_clients() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(peers_.size());
}

std::string LiveScene::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

bool LiveScene::is_running() const {
  const std::lock_guard lock(mutex_);
  return is_running_;
}

PartedMesh LiveScene::parted_mesh() {
  const auto promise = std::make_shared<std::promise<PartedMesh>>();
  std::future<PartedMesh> mesh = promise->get_future();
  post([promise](LiveEngine& engine) {
    try {
      promise->set_value(engine.parted_mesh());
    } catch (...) {
      promise->set_exception(std::current_exception());
    }
  });
  const bool is_ready = mesh.wait_for(std::chrono::minutes(1)) == std::future_status::ready;
  if (const std::string why = problem(); !why.empty()) throw InvalidInput(why);
  if (!is_ready) throw CannotComplete("the scene is still being read; ask again");
  return mesh.get();
}

namespace {

/// One client's connection to its scene.
class LiveConnection : public WebSocketListener {
 public:
  LiveConnection(std::shared_ptr<LiveScene> scene, int client) : scene_(std::move(scene)), client_(client) {}
  void received(std::string text) override { scene_->receive(client_, std::move(text)); }
  void closed() override { scene_->leave(client_); }

 private:
  std::shared_ptr<LiveScene> scene_;
  int client_;
};

}  // namespace

/// A scene and its clients' connections hold each other, so none would end by itself.
LiveScenes::~LiveScenes() {
  for (const Entry& entry : entries_) entry.scene->end();
}

std::shared_ptr<WebSocketListener> LiveScenes::open(const fs::path& path, PlaceKind kind,
                                                    const std::shared_ptr<WebSocketPeer>& peer) {
  std::vector<std::shared_ptr<LiveScene>> ended;  // they join their threads without the lock
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.path == path; });
  std::error_code error;
  const fs::file_time_type changed =
      fs::last_write_time(kind == PlaceKind::Scene ? path : path / "simulation.json", error);
  const bool is_kept = found != entries_.end() && found->scene->problem().empty() &&
                       (found->changed == changed || found->scene->num_clients() > 0);
  if (is_kept) {
    entries_.splice(entries_.begin(), entries_, found);
  } else {
    if (found != entries_.end()) {
      ended.push_back(found->scene);
      entries_.erase(found);
    }
    entries_.push_front({path, changed, std::make_shared<LiveScene>(path, kind, folder_, means_)});
  }
  const std::shared_ptr<LiveScene> scene = entries_.front().scene;
  const int client = ++num_clients_;
  scene->join(client, peer);
  std::size_t num_unwatched = 0;
  for (auto it = entries_.begin(); it != entries_.end();) {
    const bool goes = it->scene->num_clients() == 0 && it->scene != scene && ++num_unwatched > kMaxUnwatched;
    if (goes) ended.push_back(it->scene);
    it = goes ? entries_.erase(it) : std::next(it);
  }
  return std::make_shared<LiveConnection>(scene, client);
}

std::shared_ptr<LiveScene> LiveScenes::find(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.path == path; });
  return found == entries_.end() ? nullptr : found->scene;
}

}  // namespace patinate::studio
