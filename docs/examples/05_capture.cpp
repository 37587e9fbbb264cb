// Makes a material history of photographs in a folder, and says how much the surface changed.
//     05_capture FOLDER HISTORY
// Without a capture.json in FOLDER, photographs of synthetic paint that cracks are put there first.
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>

#include "patinate/capture/make_history.h"
#include "patinate/datasets/crackle.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"

using namespace patinate;

void photograph_crackle(const std::filesystem::path& folder) {
  const datasets::CrackleOptions options{.width = 96, .height = 96, .num_frames = 5};
  const datasets::CrackleDataset plate = datasets::crackle(options);
  std::filesystem::create_directories(folder / "frames");
  for (int i = 0; i < options.num_frames; ++i) {
    const ImageF light = datasets::reflected(plate, i * options.interval_s);
    write_codes(folder / "frames" / (std::to_string(i) + ".png"),
                datasets::photograph(light, options.noise, options.seed, i));
  }
  std::ofstream(folder / "capture.json") << R"({"format": "patinate.capture", "version": 1, "name": "paint",
  "kind": "fixed", "time_unit": "s", "frames": {"pattern": "frames/*.png", "interval": 7.5}})";
}

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::fputs("usage: 05_capture FOLDER HISTORY\n", stderr);
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  if (!std::filesystem::exists(folder / "capture.json")) photograph_crackle(folder);

  // Ended half-way, the same call resumes; on finished work it does nothing.
  capture::make_history(folder, argv[2], {.deflicker = true});

  const HistoryReader history(argv[2]);
  const ImageF first = history.sample(history.times().front()), last = history.sample(history.times().back());
  double sum = 0.0;
  for (std::size_t i = 0; i < first.values().size(); ++i) {
    sum += std::abs(static_cast<double>(last.values()[i]) - static_cast<double>(first.values()[i]));
  }
  std::printf("%s: %d frames of %d x %d, mean change of albedo %.4f\n", argv[2], history.num_frames(),
              history.facts().width, history.facts().height, sum / static_cast<double>(first.values().size()));
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "05_capture: %s\n", e.what());
  return 1;
}
