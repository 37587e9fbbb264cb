// Prints the mode filter's time for several windows, beside a Gaussian blur of the same window; no test, no threshold.
//     build/release/bin/mode_filter_benchmark
#include <cstdio>

#include "libcommon/image/filters.h"
#include "patinate/capture/thickness.h"
#include "patinate/datasets/crackle.h"
#include "tests/benchmarks/timing.h"

int main() {
  using namespace patinate;
  datasets::CrackleOptions options;
  options.width = options.height = 1024;
  options.num_frames = 2;
  const datasets::CrackleDataset plate = datasets::crackle(options);
  const ImageF photo = plate.thickness_mm;  // Its values do not matter, only their number and spread.
  double first = 0.0;
  for (double sigma : {5.0, 10.0, 20.0, 40.0, 80.0}) {
    capture::ModeFilterOptions filter;
    filter.spatial_sigma_px = sigma;
    ImageF out;
    const double mode_s = benchmarks::median_of_five([&] { out = capture::mode_filter(photo, {}, filter); });
    const double blur_s = benchmarks::median_of_five([&] { out = gaussian_blur(photo, sigma); });
    if (first == 0.0) first = mode_s;
    std::printf("mode filter, 1 Mpx, sigma %2.0f px: %4.0f ms; %.2f of sigma 5; %.1f times a Gaussian blur\n", sigma,
                1e3 * mode_s, mode_s / first, mode_s / blur_s);
  }
}
