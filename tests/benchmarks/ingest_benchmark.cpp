// Prints what ingest costs: time and peak memory for 100 and for 400 photographs of 1024 x 1024; no test, no threshold.
//     build/release/bin/ingest_benchmark
// Each ingest runs in a process of its own, so that its peak memory is its own.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "capture/timelapse/ingest.h"
#include "libcommon/core/files.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "tests/benchmarks/child_cost.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;
constexpr int kSide = 1024;

/// Photographs that darken from the left, with grain that PNG cannot pack away.
void write_photographs(const fs::path& folder, int count) {
  fs::create_directories(folder / "frames");
  ImageU8 photo(kSide, kSide, 3);
  for (int i = 0; i < count; ++i) {
    const double age = static_cast<double>(i) / count;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const auto grain =
            static_cast<int>((static_cast<unsigned>(x) * 73856093u ^ static_cast<unsigned>(y) * 19349663u) >> 8 & 31u);
        const double aged = 1.0 / (1.0 + std::exp(40.0 * (static_cast<double>(x) / kSide - age)));
        for (int c = 0; c < 3; ++c)
          photo.at(x, y, c) = static_cast<std::uint8_t>(200 - 30 * c - static_cast<int>(90.0 * aged) + grain / 2);
      }
    }
    char name[32];
    std::snprintf(name, sizeof(name), "%04d.png", i);
    write_codes(folder / "frames" / name, photo);
  }
  save_json(folder / "capture.json", Json{{"format", "patinate.capture"},
                                          {"version", 1},
                                          {"name", "benchmark"},
                                          {"kind", "fixed"},
                                          {"frames", {{"pattern", "frames/*.png"}, {"interval", 1}}}});
}

void ingest(const fs::path& folder) {
  run_job(capture::plan_ingest(capture::read_capture_project(folder / "capture.json"), {}, folder / "history"), {}, {});
}

}  // namespace
}  // namespace patinate

int main() {
  using namespace patinate;
  double first_rate = 0.0, first_peak = 0.0;
  for (int count : {100, 400}) {
    const testing_support::TempFolder folder;
    write_photographs(folder.path(), count);
    double peak = 0.0;
    const double s =
        benchmarks::seconds([&] { peak = benchmarks::cost_in_child([&] { ingest(folder.path()); }).peak_mb; });
    std::printf("ingest of %d photographs of 1024 x 1024: %.1f s, %.1f ms each; peak memory %.0f MB", count, s,
                1e3 * s / count, peak);
    if (first_rate > 0.0)
      std::printf("; against 100: time each %.2f, memory %.2f", s / count / first_rate, peak / first_peak);
    std::printf("\n");
    std::fflush(stdout);
    first_rate = s / count;
    first_peak = peak;
  }
}
