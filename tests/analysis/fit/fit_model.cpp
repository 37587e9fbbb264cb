#include "tests/analysis/fit/fit_model.h"

#include <cmath>
#include <mutex>

#include "libcommon/core/files.h"
#include "libcommon/core/random.h"
#include "libcommon/core/text.h"

namespace patinate::testing_support {

namespace {

constexpr int kWidth = 24, kHeight = 16, kLastDay = 8;

}  // namespace

analysis::AgedSurface green_plate(const std::vector<double>& values) {
  analysis::AgedSurface frames{.name = "plate",
                               .time_unit = TimeUnit::Days,
                               .texel_size_mm = 1.0,
                               .times = {},
                               .colors = {},
                               .mask = ImageU8(kWidth, kHeight),
                               .controls = {}};
  for (std::uint8_t& v : frames.mask.values()) v = 255;
  analysis::SurfaceControl x{.parameter = {.name = "x", .low = 0.0, .high = kWidth - 1.0, .unit = "px"},
                             .values = ImageF(kWidth, kHeight)};
  for (int day = 0; day <= kLastDay; ++day) {
    frames.times.push_back(day);
    ImageF color(kWidth, kHeight, 3);
    for (int py = 0; py < kHeight; ++py) {
      for (int px = 0; px < kWidth; ++px) {
        x.values.at(px, py) = static_cast<float>(px) / (kWidth - 1);
        const double share = values[1] * (1.0 - std::exp(-values[0] * day * (0.5 + px / (kWidth - 1.0))));
        const double brown[3]{0.3, 0.12, 0.06}, green[3]{0.1, 0.35, 0.28};
        for (int c = 0; c < 3; ++c) color.at(px, py, c) = static_cast<float>(brown[c] + share * (green[c] - brown[c]));
      }
    }
    frames.colors.push_back(std::move(color));
  }
  frames.controls.push_back(std::move(x));
  return frames;
}

analysis::FitTask green_task(const std::filesystem::path& history, double chance, int* num_agings) {
  analysis::FitTask task;
  analysis::FitCapture& capture = task.captures.emplace_back();
  capture.history = history;
  task.model_name = "green plate";
  task.parameters = {{.range = {.name = "/rate", .low = 0.02, .high = 2.0, .scale = analysis::FitScale::Log},
                      .start = 0.1,
                      .is_whole = false,
                      .is_appearance = false},
                     {.range = {.name = "/strength", .low = 0.0, .high = 1.0, .scale = analysis::FitScale::Linear},
                      .start = 0.3,
                      .is_whole = false,
                      .is_appearance = true},
                     {.range = {.name = "/idle", .low = 0.0, .high = 10.0, .scale = analysis::FitScale::Linear},
                      .start = 5.0,
                      .is_whole = false,
                      .is_appearance = false}};
  const analysis::AgedSurface start = green_plate({0.1, 0.3, 5.0});
  capture.outline = {.name = "plate",
                     .width = kWidth,
                     .height = kHeight,
                     .time_unit = TimeUnit::Days,
                     .times = start.times,
                     .control_names = {"x"}};
  const auto mutex = std::make_shared<std::mutex>();
  capture.age = [chance, num_agings, mutex](const std::vector<double>& values, std::uint64_t seed_shift,
                                            const RunControl&) -> analysis::ComposeWith {
    if (num_agings) {
      const std::scoped_lock lock(*mutex);
      ++*num_agings;
    }
    const double rate = values[0] * (1.0 + chance * RandomStream(5, seed_shift).normal());
    return [rate](const std::vector<double>& look, const RunControl&) { return green_plate({rate, look[1], look[2]}); };
  };
  task.terms = {{}};
  task.add_inputs = [](JobInputs& inputs) { inputs.add_value("model", "green plate"); };
  capture.write_model = [](const std::filesystem::path& folder, const std::string& file,
                           const std::vector<double>& values) {
    write_atomically(folder / (file + ".txt"), number_text(values[0]));
  };
  task.command = "fit";
  return task;
}

}  // namespace patinate::testing_support
