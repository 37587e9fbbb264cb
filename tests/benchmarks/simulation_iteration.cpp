// Whole iterations of the engine, by atlas size and wetness, in the rows of the paper's Table 2; and an aged look from
// nothing.
#include <cstdio>
#include <ctime>
#include <memory>

#include "patinate/simulation/engine.h"
#include "simulation/tracing/gammatons.h"
#include "tests/benchmarks/simulation_parts.h"
#include "tests/benchmarks/timing.h"
#include "tests/benchmarks/wall_scene.h"

namespace patinate::benchmarks {

namespace {

struct Row {
  int resolution;
  double share;
  const char* goal_ms;
  const char* paper_ms;
};

void one(const Row& row) {
  RunControl control;
  control.num_threads = 2;
  simulation::Scene scene = slow_wall(row.resolution);
  simulation::SimulationOptions options;
  std::unique_ptr<simulation::Simulation> simulation;
  const double set_up =
      seconds([&] { simulation = std::make_unique<simulation::Simulation>(scene, options, control); });
  make_wet(*simulation, row.share);
  for (int i = 0; i < 24; ++i) simulation->step(control);
  (void)simulation->compose(control);
  const double wet = wet_share(*simulation);
  const simulation::SimulationTimes before = simulation->times();
  constexpr int kIterations = 48;  // whole epochs
  const std::clock_t cpu_before = std::clock();
  const double total = seconds([&] {
    for (int i = 0; i < kIterations; ++i) {
      simulation->step(control);
      (void)simulation->compose(control);
    }
  });
  const double cpu = static_cast<double>(std::clock() - cpu_before) /
                     CLOCKS_PER_SEC;  // of both threads: what a busy machine leaves comparable
  const simulation::SimulationTimes after = simulation->times();
  const auto ms = [&](double simulation::SimulationTimes::*part) {
    return 1e3 * (after.*part - before.*part) / kIterations;
  };
  std::printf("  %5d %5.0f %% wet %9.2f %9.2f %9.2f %9.2f %9.2f %9.2f %9s %9s %8.0f MB %8.2f s\n", row.resolution,
              100.0 * wet, ms(&simulation::SimulationTimes::trace) + ms(&simulation::SimulationTimes::respond),
              ms(&simulation::SimulationTimes::exchange), ms(&simulation::SimulationTimes::rules),
              ms(&simulation::SimulationTimes::compose), 1e3 * total / kIterations, 1e3 * cpu / kIterations,
              row.goal_ms, row.paper_ms, static_cast<double>(simulation->memory()) / 1e6, set_up);
}

void print_heads() {
  std::printf(
      "  5,000 gammatons, 2 threads, ms an iteration with composition; exchange = the paper's surface update and "
      "gammaton update. Of the paper's\n"
      "  8.98 ms at 1k, composition is 5.9. Its atlas takes 1,024 MB at 4k (Table 1). cpu: processor time of both "
      "threads.\n");
  std::printf("  %5s %10s %9s %9s %9s %9s %9s %9s %9s %9s %11s %10s\n", "atlas", "", "trace", "exchange", "rules",
              "compose", "total", "cpu", "goal", "paper", "memory", "set-up");
}

}  // namespace

void iteration() {
  print_heads();
  for (const Row& row : {Row{1024, 0.5, "1.5", "8.98"},
                         {2048, 0.5, "3", "28"},
                         {4096, 0.5, "7", "103"},
                         {8192, 0.5, "15", "-"},
                         {1024, 0.8, "2.5", "8.98"},
                         {2048, 0.8, "6", "28"},
                         {4096, 0.8, "16", "103"}}) {
    one(row);
  }
  RunControl control;
  control.num_threads = 2;
  const double look = seconds([&] {
    simulation::Simulation simulation(wall(1024), {}, control);
    for (int i = 0; i < 1000; ++i) simulation.step(control);
    (void)simulation.compose(control);
  });
  std::printf("  an aged look, 1,000 iterations at 1k with set-up: %.2f s (goal 3 s)\n", look);
  for (const std::int64_t n :
       {std::int64_t{5'000}, std::int64_t{50'000}, std::int64_t{200'000}, std::int64_t{1'000'000}}) {
    simulation::Scene scene = wall(1024);
    scene.emitters[0].gammatons = n * 4 / 5;
    scene.emitters[1].gammatons = n / 5;
    simulation::Simulation simulation(scene, {}, control);
    for (int i = 0; i < 20; ++i) simulation.step(control);
    const std::int64_t begin = simulation.counters().segments;
    const double time = seconds([&] {
      for (int i = 0; i < 20; ++i) simulation.step(control);
    });
    std::printf("  %8lld gammatons: %6.2f M segments/s, all in (goal 25 at a million)\n", static_cast<long long>(n),
                1e-6 * static_cast<double>(simulation.counters().segments - begin) / time);
  }
}

}  // namespace patinate::benchmarks
