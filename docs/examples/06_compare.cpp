// Compares how two surfaces age, and prints every figure with its 95 % interval.
//     06_compare A B        histories
//     06_compare            two synthetic plates of cracking paint that differ by their seed
#include <cstdio>
#include <exception>
#include <memory>

#include "patinate/analysis/comparison.h"
#include "patinate/datasets/crackle.h"
#include "patinate/history/memory_history.h"

using namespace patinate;

std::shared_ptr<const History> cracking_paint(const char* name, std::int64_t seed) {
  const datasets::CrackleOptions options{.width = 96, .height = 96, .num_frames = 5, .seed = seed};
  const datasets::CrackleDataset plate = datasets::crackle(options);
  MemoryHistoryImages images{.name = name, .origin = "synthetic", .texel_size_mm = options.texel_size_mm, .frames = {}};
  for (int i = 0; i < options.num_frames; ++i) {
    images.frames.push_back({.time = i * options.interval_s, .color = reflected(plate, i * options.interval_s)});
  }
  return std::make_shared<const MemoryHistory>(std::move(images));
}

int main(int argc, char** argv) try {
  if (argc != 1 && argc != 3) {
    std::fputs("usage: 06_compare [A B]\n", stderr);
    return 2;
  }
  const bool given = argc == 3;
  using Shared = std::shared_ptr<const History>;
  const Shared a = given ? Shared(std::make_shared<const HistoryReader>(argv[1])) : cracking_paint("seed 1", 1);
  const Shared b = given ? Shared(std::make_shared<const HistoryReader>(argv[2])) : cracking_paint("seed 2", 2);

  analysis::CompareOptions options;
  options.num_resamples = 50;                // For the intervals.
  options.places = analysis::Places::Never;  // Equal pixels show different places of the two plates.
  for (const analysis::Section& section :
       analysis::compare(analysis::TextureSeries(a), analysis::TextureSeries(b), options)) {
    std::printf("%s\n", section.title.c_str());
    for (const analysis::Figure& figure : section.figures) {
      if (!figure.value) {
        std::printf("  %s: %s\n", figure.title.c_str(), figure.undefined.c_str());
      } else if (figure.low && figure.high) {
        std::printf("  %s: %.4g [%.4g, %.4g] %s\n", figure.title.c_str(), *figure.value, *figure.low, *figure.high,
                    figure.unit.c_str());
      } else {
        std::printf("  %s: %.4g %s\n", figure.title.c_str(), *figure.value, figure.unit.c_str());
      }
    }
  }
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "06_compare: %s\n", e.what());
  return 1;
}
