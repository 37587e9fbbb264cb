// The mass ledger after a million iterations, for several ratios and rates.
#include <cstdio>

#include "patinate/simulation/engine.h"
#include "simulation/tracing/gammatons.h"
#include "tests/benchmarks/simulation_parts.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/long_scene.h"

namespace patinate::benchmarks {

void mass_balance() {
  constexpr int kIterations = 1'000'000;
  RunControl control;
  control.num_threads = 1;
  std::printf("  four materials with rates 0.4, 1/4096, 0.02 and 1, two rules, %d iterations\n", kIterations);
  for (const double ratio : {0.0, 0.37, 0.5, 1.0}) {
    simulation::Simulation simulation(testing_support::long_scene(ratio), {}, control);
    const double time = seconds([&] {
      for (int i = 0; i < kIterations; ++i) simulation.step(control);
    });
    const std::string wrong =
        simulation.ledger().balances() ? simulation.audit(control) : "the ledger does not balance";
    std::printf("  ratio %.2f: %lld contacts, %.0f s: %s\n", ratio,
                static_cast<long long>(simulation.counters().contacts), time,
                wrong.empty() ? "0 quanta lost" : wrong.c_str());
  }
}

}  // namespace patinate::benchmarks
