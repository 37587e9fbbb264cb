// Prints how exact registration and unlighting are, from how far off scans find each other, and what all that takes; no
// test, no threshold.
//     build/release/bin/capture_benchmark [PART...]
#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>
#include <vector>

#include "tests/benchmarks/capture/capture_parts.h"

namespace {

struct Part {
  std::string_view name;
  void (*measure)();
};
constexpr std::array kParts{Part{"pair", patinate::benchmarks::measure_pair},
                            Part{"joint", patinate::benchmarks::measure_joint},
                            Part{"basin", patinate::benchmarks::measure_basin},
                            Part{"unlighting", patinate::benchmarks::measure_unlighting},
                            Part{"unlighting-time", patinate::benchmarks::measure_unlighting_time},
                            Part{"materials", patinate::benchmarks::measure_materials},
                            Part{"relit", patinate::benchmarks::measure_relit}};

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string_view> wanted(argv + 1, argv + argc);
  for (const std::string_view name : wanted) {
    if (std::none_of(kParts.begin(), kParts.end(), [&](const Part& part) { return part.name == name; })) {
      std::fputs("parts: pair, joint, basin, unlighting, unlighting-time, materials, relit\n", stderr);
      return 2;
    }
  }
  for (const Part& part : kParts) {
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), part.name) == wanted.end()) continue;
    std::printf("-- %.*s\n", static_cast<int>(part.name.size()), part.name.data());
    part.measure();
    std::fflush(stdout);
  }
}
