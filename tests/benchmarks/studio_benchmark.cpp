// What the studio's server costs: updates/s from simulation step to message, and memory, by atlas size. A client that
// acknowledges at once.
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "patinate/datasets/objects.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/support/temp_folder.h"
#include "tools/studio/live_engine.h"

namespace patinate {
namespace {

constexpr double kSeconds = 5.0;

/// Takes what is sent; the last update waits for its acknowledgement.
class CountingPeer : public studio::WebSocketPeer {
 public:
  void send_text(std::string) override {}
  void send_binary(std::string message) override {
    std::uint32_t size = 0;
    std::memcpy(&size, message.data(), sizeof(size));
    const Json header = Json::parse(message.substr(sizeof(size), size));
    num_bytes += message.size();
    num_tiles += header["count"].get<std::size_t>();
    if (!header["last"].get<bool>()) return;
    ++num_updates;
    update = header["update"].get<std::int64_t>();
  }
  [[nodiscard]] std::size_t num_waiting_bytes() const override { return 0; }
  void close() override {}
  void refuse(const std::string&) override {}

  std::size_t num_bytes = 0, num_tiles = 0, num_updates = 0;
  std::int64_t update = 0;
};

double resident_mb() {
  std::ifstream in("/proc/self/statm");
  double total = 0.0, resident = 0.0;
  in >> total >> resident;
  return resident * 4096.0 / 1e6;
}

void run(int resolution, int num_gammatons) {
  const testing_support::TempFolder temp;
  write_obj(temp / "mesh.obj", datasets::ledge());
  Json scene = Json::parse(datasets::ledge_scene({}, "mesh.obj"));
  scene["atlas"]["resolution"] = resolution;
  for (Json& emitter : scene["emitters"]) emitter["gammatons"] = num_gammatons / 2;
  save_json(temp / "scene.json", scene);
  const studio::ServedFolder folder(temp.path());
  studio::LiveOptions options;
  options.most_updates_s = 1e9;
  studio::LiveEngine engine(simulation::read_scene(temp / "scene.json"), folder, options, {});
  const auto peer = std::make_shared<CountingPeer>();
  engine.join(1, peer);
  const auto round = [&] {
    (void)engine.advance({});
    engine.receive(1, R"({"op": "ack", "update": )" + std::to_string(peer->update) + "}");
  };
  engine.receive(1, R"({"op": "run"})");
  for (int i = 0; i < 200; ++i) round();  // until rain has reached the ground
  const std::size_t updates = peer->num_updates, bytes = peer->num_bytes, tiles = peer->num_tiles;
  const std::int64_t iterations = engine.simulation().iteration();
  const simulation::SimulationTimes before = engine.simulation().times();
  const auto begin = std::chrono::steady_clock::now();
  double seconds = 0.0;
  while (seconds < kSeconds) {
    round();
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  const simulation::SimulationTimes& after = engine.simulation().times();
  const double stepping = after.trace + after.exchange + after.respond + after.rules - before.trace - before.exchange -
                          before.respond - before.rules;
  const double n = static_cast<double>(peer->num_updates - updates);
  const double all_tiles = static_cast<double>(resolution) * resolution / 64.0;
  std::printf(
      "%5d^2 %6d gammatons: %6.1f updates/s (%6.1f iterations/s), %4.1f %% of tiles each, %5.1f MB/s; step %5.2f ms, "
      "compose and send %5.2f ms; %4.0f MB\n",
      resolution, num_gammatons, n / seconds,
      static_cast<double>(engine.simulation().iteration() - iterations) / seconds,
      100.0 * static_cast<double>(peer->num_tiles - tiles) / n / all_tiles,
      static_cast<double>(peer->num_bytes - bytes) / seconds / 1e6, 1e3 * stepping / n, 1e3 * (seconds - stepping) / n,
      resident_mb());
}

}  // namespace
}  // namespace patinate

int main() {
  for (const auto& [resolution, num_gammatons] : {std::pair{1024, 2000}, {1024, 5000}, {2048, 5000}, {2048, 20000}})
    patinate::run(resolution, num_gammatons);
}
