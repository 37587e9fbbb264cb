#include "tests/support/histories.h"

#include <cmath>
#include <utility>

#include "libcommon/core/random.h"
#include "patinate/image/image_io.h"

namespace patinate::testing_support {

void write_history(const std::filesystem::path& folder, int width, int height, int num_frames,
                   const std::function<float(int, int, int, int)>& color) {
  HistoryManifest manifest;
  manifest.name = "test";
  manifest.origin = "synthetic";
  manifest.width = width;
  manifest.height = height;
  manifest.key = "0123456789abcdef";
  std::filesystem::create_directories(folder / "frames");
  std::filesystem::create_directories(folder / "controls");
  HistoryWriter writer(folder, manifest);
  ImageF xs(width, height), ys(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      xs.at(x, y) = static_cast<float>(x);
      ys.at(x, y) = static_cast<float>(y);
    }
  }
  writer.write_control("x", xs, 0.0, width - 1.0, "px");
  writer.write_control("y", ys, 0.0, height - 1.0, "px");
  for (int f = 0; f < num_frames; ++f) {
    ImageF frame(width, height, 3);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) frame.at(x, y, c) = color(x, y, f, c);
      }
    }
    writer.write_frame(f, f, frame);
  }
  writer.finish();
}

MemoryHistoryImages half_images(int width, int height, int num_frames,
                                const std::function<float(int, int, int, int)>& color) {
  constexpr float kSteps = 1024.0f;  // A half float holds ten bits behind its first.
  MemoryHistoryImages images{.name = "test", .origin = "synthetic", .frames = {}};
  for (int f = 0; f < num_frames; ++f) {
    ImageF frame(width, height, 3);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) frame.at(x, y, c) = std::round(kSteps * color(x, y, f, c)) / kSteps;
      }
    }
    images.frames.push_back({.time = static_cast<double>(f) * f, .color = std::move(frame)});
  }
  ImageF xs(width, height), ys(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      xs.at(x, y) = static_cast<float>(x) / static_cast<float>(width - 1);
      ys.at(x, y) = static_cast<float>(y) / static_cast<float>(height - 1);
    }
  }
  images.controls = {{{.name = "x", .unit = "relative"}, xs}, {{.name = "y", .unit = "relative"}, ys}};
  return images;
}

namespace {

/// Smooth value noise in [0, 1].
double noise(double x, double y, std::uint32_t octave) {
  const auto corner = [&](double i, double j) {
    return RandomStream(5,
                        static_cast<std::uint64_t>(static_cast<std::int64_t>(i) * 4096 + static_cast<std::int64_t>(j)),
                        octave)
        .uniform();
  };
  const double i = std::floor(x), j = std::floor(y), u = x - i, v = y - j;
  const double su = u * u * (3 - 2 * u), sv = v * v * (3 - 2 * v);
  return (1 - sv) * ((1 - su) * corner(i, j) + su * corner(i + 1, j)) +
         sv * ((1 - su) * corner(i, j + 1) + su * corner(i + 1, j + 1));
}

}  // namespace

float blotches(int x, int y, int frame, int channel) {
  const double texture = 0.6 * noise(x / 9.0, y / 5.0, 1) + 0.4 * noise(x / 2.5, y / 2.0, 2);
  const double age = std::min(1.0, frame * (0.1 + 0.3 * texture + x / 400.0));
  const double fresh[3] = {0.6, 0.35, 0.25}, old[3] = {0.15, 0.4, 0.35};
  return static_cast<float>((0.6 + 0.4 * texture) * ((1 - age) * fresh[channel] + age * old[channel]));
}

}  // namespace patinate::testing_support
