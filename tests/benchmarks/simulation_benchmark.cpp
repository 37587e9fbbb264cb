// Cost of a simulation, part by part: simulation_benchmark [PART ...]; all without arguments.
#include <array>
#include <cstdio>
#include <string_view>

#include "tests/benchmarks/simulation_parts.h"

namespace {

struct Part {
  std::string_view name;
  void (*run)();
};

constexpr std::array kParts{Part{"rays", patinate::benchmarks::rays},
                            Part{"gammatons", patinate::benchmarks::gammatons},
                            Part{"exchange", patinate::benchmarks::exchange},
                            Part{"rules", patinate::benchmarks::rules},
                            Part{"composition", patinate::benchmarks::composition},
                            Part{"iteration", patinate::benchmarks::iteration},
                            Part{"iteration_on_devices", patinate::benchmarks::iteration_on_devices},
                            Part{"chest", patinate::benchmarks::chest},
                            Part{"mass_balance", patinate::benchmarks::mass_balance}};

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    bool is_known = false;
    for (const Part& part : kParts) is_known = is_known || part.name == argv[i];
    if (is_known) continue;
    std::fprintf(stderr, "simulation_benchmark: no part '%s'; there are", argv[i]);
    for (const Part& part : kParts) std::fprintf(stderr, " %s", part.name.data());
    std::fprintf(stderr, "\n");
    return 2;
  }
  for (const Part& part : kParts) {
    bool is_asked = argc == 1;
    for (int i = 1; i < argc; ++i) is_asked = is_asked || part.name == argv[i];
    if (!is_asked) continue;
    std::printf("-- %s\n", part.name.data());
    part.run();
  }
  return 0;
}
