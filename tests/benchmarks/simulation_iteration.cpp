// Whole iterations of the engine, by atlas size and wetness, in the rows of the paper's Table 2; and an aged look from nothing.
#include <cstdio>
#include <filesystem>

#include "datasets_synthetic/ledge.h"
#include "libcommon/core/files.h"
#include "libcommon/geometry/mesh_io.h"
#include "simulation/engine.h"
#include "simulation/scene/scene_io.h"
#include "tests/benchmarks/simulation_parts.h"
#include "tests/benchmarks/timing.h"

namespace patinate::benchmarks {

namespace {

/// The wall with sills, 5,000 gammatons. @param is_wet  Slow evaporation: most of the wall stays wet.
Scene wall(int resolution, bool is_wet) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "patinate_simulation_benchmark";
  std::filesystem::create_directories(folder);
  write_obj(folder / "mesh.obj", ledge());
  write_atomically(folder / "scene.json", ledge_scene({}, "mesh.obj"));
  Scene scene = read_scene(folder / "scene.json").scene;
  std::filesystem::remove_all(folder);
  scene.resolution = resolution;
  scene.emitters[0].gammatons = 4000;
  scene.emitters[1].gammatons = 1000;
  scene.rules[0].alpha = is_wet ? 0.0 : 4.0;
  return scene;
}

void one(int resolution, bool is_wet, double goal_ms, const char* paper_ms) {
  RunControl control;
  control.num_threads = 2;
  Simulation simulation(wall(resolution, is_wet), {}, control);
  for (int i = 0; i < (is_wet ? 400 : 100); ++i) simulation.step(control);
  (void)simulation.compose(control);
  std::int64_t wet = 0, covered = 0;
  for (TexelIndex t = 0; t < simulation.atlas().surface().grid().num_texels(); ++t) {
    if (!simulation.atlas().surface().is_covered(t)) continue;
    ++covered;
    if (simulation.atlas().amount(0, t) > 0) ++wet;
  }
  const SimulationTimes before = simulation.times();
  constexpr int kIterations = 50;
  const double total = seconds([&] {
    for (int i = 0; i < kIterations; ++i) {
      simulation.step(control);
      (void)simulation.compose(control);
    }
  });
  const SimulationTimes after = simulation.times();
  const auto ms = [&](double SimulationTimes::* row) { return 1e3 * (after.*row - before.*row) / kIterations; };
  std::printf("  %5d %5.0f %% wet %9.2f %9.2f %9.2f %9.2f %9.2f %9.2f %9.1f %9s %8.0f MB\n", resolution,
              100.0 * static_cast<double>(wet) / static_cast<double>(covered), ms(&SimulationTimes::trace) + ms(&SimulationTimes::respond),
              ms(&SimulationTimes::exchange), ms(&SimulationTimes::rules), ms(&SimulationTimes::compose), 1e3 * total / kIterations,
              1e3 * total / kIterations / goal_ms, goal_ms, paper_ms, static_cast<double>(simulation.memory()) / 1e6);
}

}  // namespace

void iteration() {
  std::printf("  5,000 gammatons, 2 threads, ms an iteration with composition (exchange = the paper's surface and gammaton update)\n");
  std::printf("  %5s %10s %9s %9s %9s %9s %9s %9s %9s %9s %11s\n", "atlas", "", "trace", "exchange", "rules", "compose", "total", "of goal", "goal", "paper", "memory");
  one(1024, false, 1.5, "8.98");
  one(2048, false, 3.0, "28");
  one(4096, false, 7.0, "103");
  one(1024, true, 2.5, "8.98");
  one(2048, true, 6.0, "28");
  one(4096, true, 16.0, "103");
  RunControl control;
  control.num_threads = 2;
  const double look = seconds([&] {
    Simulation simulation(wall(1024, false), {}, control);
    for (int i = 0; i < 1000; ++i) simulation.step(control);
    (void)simulation.compose(control);
  });
  std::printf("  an aged look, 1,000 iterations at 1k with set-up: %.2f s (goal 3 s)\n", look);
  for (const std::int64_t n : {std::int64_t{5'000}, std::int64_t{100'000}, std::int64_t{1'000'000}}) {
    Scene scene = wall(1024, false);
    scene.emitters[0].gammatons = n * 4 / 5;
    scene.emitters[1].gammatons = n / 5;
    Simulation simulation(scene, {}, control);
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
