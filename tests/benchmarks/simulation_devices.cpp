// Whole iterations on every device: nothing is waited for but the end, and what is seen is read in rows of its own.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "libcommon/device/device.h"
#include "simulation/device/simulation_device.h"
#include "simulation/tracing/gammatons.h"
#include "tests/benchmarks/device_share.h"
#include "tests/benchmarks/simulation_parts.h"
#include "tests/benchmarks/timing.h"
#include "tests/benchmarks/wall_scene.h"
#include "tests/support/threads.h"

namespace patinate::benchmarks {

namespace {

constexpr int kIterations = 64;  // Whole epochs.

simulation::SimulationOptions on(const device::Device& device) {
  simulation::SimulationOptions options;
  options.device = std::make_shared<const simulation::SimulationDevice>(device);
  return options;
}

void iterations(const device::Device& device, int resolution, const char* goal_ms) {
  const RunControl control = testing_support::with_threads(2);
  simulation::Simulation simulation(slow_wall(resolution), on(device), control);
  make_wet(simulation, 0.5);
  for (int i = 0; i < 24; ++i) simulation.step(control);
  (void)simulation.compose(control);
  const double wet = wet_share(simulation);
  const auto each_ms = [&](const auto& work) {
    for (int i = 0; i < 8; ++i) work();
    device.finish();
    return 1e3 / kIterations * seconds([&] {
             for (int i = 0; i < kIterations; ++i) work();
             device.finish();
           });
  };
  const DeviceShare share(device);
  const double bare = each_ms([&] { simulation.step(control); });
  const double composed = each_ms([&] {
    simulation.step(control);
    (void)simulation.compose(control);
  });
  const std::string kernels = share.text(2 * (kIterations + 8));
  std::size_t num_tiles = 0;
  const double seen = each_ms([&] {
    simulation.step(control);
    num_tiles += simulation.compose(control).codes().empty() ? 0 : simulation.composed_tiles().size();
  });
  std::printf("  %5d %5.0f %% wet %9.3f %9.3f %9.3f %9s   %.0f tiles read\n        %s\n", resolution, 100.0 * wet, bare,
              composed, seen, goal_ms, static_cast<double>(num_tiles) / (kIterations + 8), kernels.c_str());
}

/// Everything composed anew, by the device's clock.
void composition(const device::Device& device, int resolution) {
  const RunControl control = testing_support::with_threads(2);
  simulation::Simulation simulation(wall(resolution), on(device), control);
  (void)simulation.compose(control);
  make_wet(simulation, 1.0);
  simulation.step(control);
  device.finish();
  const DeviceShare share(device);
  (void)simulation.compose(control);
  device.finish();
  std::printf("  %5d: all composed and its normals, once: %s\n", resolution, share.text(1).c_str());
}

void many_gammatons(const device::Device& device, std::int64_t num) {
  const RunControl control = testing_support::with_threads(2);
  simulation::Scene scene = wall(1024);
  scene.emitters[0].gammatons = num * 4 / 5;
  scene.emitters[1].gammatons = num / 5;
  simulation::Simulation simulation(scene, on(device), control);
  for (int i = 0; i < 20; ++i) simulation.step(control);
  const std::int64_t begin = simulation.counters().segments;
  simulation.step(control);
  device.finish();
  const DeviceShare share(device);
  const double time = seconds([&] {
    for (int i = 0; i < kIterations; ++i) simulation.step(control);
    device.finish();
  });
  const std::string kernels = share.text(kIterations);
  const double segments = static_cast<double>(simulation.counters().segments - begin) * kIterations / (kIterations + 1);
  std::printf("  %8lld gammatons: %.1f M segments/s, all in (goal 300 at a million)\n        %s\n",
              static_cast<long long>(num), 1e-6 * segments / time, kernels.c_str());
}

}  // namespace

void iteration_on_devices() {
  for (const device::DeviceInfo& info : device::list_devices()) {
    std::printf(
        "  on %s; ms an iteration: without composition, with it, and with what has changed read back; goals of an "
        "H200-class card\n",
        info.name.c_str());
    const device::Device device(info);
    iterations(device, 1024, "0.15");
    iterations(device, 2048, "0.25");
    iterations(device, 4096, "0.6");
    iterations(device, 8192, "2");
    composition(device, 4096);
    for (const std::int64_t num : {std::int64_t{5'000}, std::int64_t{100'000}, std::int64_t{1'000'000}})
      many_gammatons(device, num);
  }
}

}  // namespace patinate::benchmarks
