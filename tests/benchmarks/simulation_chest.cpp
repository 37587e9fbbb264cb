// The paper's Tables 2 and 3 on a scene of several objects: what each part of an iteration costs, by atlas size and by
// number of gammatons.
#include <cstdio>
#include <ctime>

#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"
#include "tests/benchmarks/simulation_parts.h"
#include "tests/benchmarks/timing.h"

namespace patinate::benchmarks {

namespace {

constexpr int kWarmUp = 200, kIterations = 96;  // whole epochs

void row(simulation::Scene scene, int resolution, std::int64_t gammatons) {
  RunControl control;
  control.num_threads = 2;
  scene.resolution = resolution;
  scene.emitters[0].gammatons = gammatons;
  simulation::Simulation simulation(scene, {}, control);
  for (int i = 0; i < kWarmUp; ++i) simulation.step(control);
  (void)simulation.compose(control);
  const simulation::SimulationTimes before = simulation.times();
  const std::clock_t cpu_before = std::clock();
  const double total = seconds([&] {
    for (int i = 0; i < kIterations; ++i) {
      simulation.step(control);
      (void)simulation.compose(control);
    }
  });
  const double cpu = static_cast<double>(std::clock() - cpu_before) / CLOCKS_PER_SEC;
  const simulation::SimulationTimes after = simulation.times();
  const auto ms = [&](double simulation::SimulationTimes::*part) {
    return 1e3 * (after.*part - before.*part) / kIterations;
  };
  std::printf("  %6d %10lld %9.2f %9.2f %9.2f %9.2f %9.2f %9.2f %9.2f %9.0f MB\n", resolution,
              static_cast<long long>(gammatons), ms(&simulation::SimulationTimes::trace),
              ms(&simulation::SimulationTimes::exchange), ms(&simulation::SimulationTimes::respond),
              ms(&simulation::SimulationTimes::rules), ms(&simulation::SimulationTimes::compose),
              1e3 * total / kIterations, 1e3 * cpu / kIterations, static_cast<double>(simulation.memory()) / 1e6);
  std::fflush(stdout);
}

}  // namespace

void chest() {
  std::printf(
      "  The chest of docs/examples, 2 threads, ms an iteration with composition. exchange: the paper's surface update "
      "and gammaton update,\n"
      "  which are one pass here; respond: where gammatons go next. cpu: processor time of both threads.\n");
  std::printf("  %6s %10s %9s %9s %9s %9s %9s %9s %9s %12s\n", "atlas", "gammatons", "trace", "exchange", "respond",
              "rules", "compose", "total", "cpu", "memory");
  std::fflush(stdout);
  // Unwrapping takes longer than all that is measured: once, for the file's own resolution.
  const simulation::Scene scene = simulation::read_scene(PATINATE_SCENES "/chest/chest.json").scene;
  for (const int resolution : {1024, 2048, 4096}) row(scene, resolution, 5000);
  for (const std::int64_t gammatons : {std::int64_t{1000}, std::int64_t{20000}, std::int64_t{80000}})
    row(scene, 1024, gammatons);
}

}  // namespace patinate::benchmarks
