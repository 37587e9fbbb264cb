// Every stage by hand, without a file in between: synthetic truth, a history in memory, control maps, a transfer with
// progress that can be canceled, and a lookup in which every texel has an age of its own.
//     03_full_control TEXTURE.png PICTURE.png
#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <stop_token>
#include <utility>

#include "patinate/atlas/dilate.h"
#include "patinate/controls/accessibility.h"
#include "patinate/controls/exposure.h"
#include "patinate/datasets/crackle.h"
#include "patinate/datasets/objects.h"
#include "patinate/history/memory_history.h"
#include "patinate/image/image_io.h"
#include "patinate/output/render.h"
#include "patinate/transfer/time_map.h"
#include "patinate/transfer/transfer.h"
#include "patinate/transfer/transfer_io.h"

using namespace patinate;

/// Paint that dries and cracks, with its thickness: a history that never is a file.
std::shared_ptr<const History> make_history(const RunControl& control) {
  datasets::CrackleOptions options;
  options.width = options.height = 192;
  options.num_frames = 6;
  const datasets::CrackleDataset plate = datasets::crackle(options, control);

  MemoryHistoryImages images{.name = "crackle",
                             .origin = "synthetic",
                             .texel_size_mm = options.texel_size_mm,
                             .time_unit = TimeUnit::Seconds,
                             .frames = {}};
  for (int i = 0; i < options.num_frames; ++i) {
    const double time = i * options.interval_s;
    images.frames.push_back({.time = time, .color = datasets::reflected(plate, time, control)});
  }
  MemoryControl thickness{
      .facts = {.name = "thickness", .low = options.thickness_min_mm, .high = options.thickness_max_mm, .unit = "mm"},
      .values = plate.thickness_mm};
  for (float& t : thickness.values.values()) {  // From 0 to 1 between the two.
    t = std::clamp(static_cast<float>((static_cast<double>(t) - options.thickness_min_mm) /
                                      (options.thickness_max_mm - options.thickness_min_mm)),
                   0.0f, 1.0f);
  }
  images.controls.push_back(std::move(thickness));
  return std::make_shared<const MemoryHistory>(std::move(images));
}

/// Paint lies thick where the surface faces up, and in crevices.
ImageF thickness(const TexelMap& map, const RunControl& control) {
  const ControlMap up = facing_map(map, {}, control);
  const ControlMap crevices = accessibility_map(map, {}, control);
  ImageF values(map.width(), map.height());
  for (std::int64_t i = 0; i < values.num_pixels(); ++i) {
    values.data()[i] = 0.7f * up.values.data()[i] + 0.3f * crevices.values.data()[i];
  }
  return values;
}

/// Every texel at its own age, `age` in [0, 1] of the history's time.
ImageF aged_by_map(const History& history, const ImageF& coordinates, const ImageF& age, const RunControl& control) {
  const double first = history.times().front(), span = history.times().back() - first;
  ImageF times = age;
  for (float& t : times.values()) t = static_cast<float>(first + static_cast<double>(t) * span);
  return transfer::gather_at_times(history, coordinates, times, Between::Blend, control);
}

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::fputs("usage: 03_full_control TEXTURE.png PICTURE.png\n", stderr);
    return 2;
  }
  std::stop_source
      stop;  // stop.request_stop() from any thread ends the work within 50 ms; nothing half-written is left.
  RunControl control;
  control.stop = stop.get_token();
  control.on_progress = [](double fraction) {
    if (fraction == 1.0) std::puts("a stage is finished");
  };
  control.num_threads = 2;  // Never changes a result.

  const std::shared_ptr<const History> history = make_history(control);
  const auto map = std::make_shared<TexelMap>(datasets::sculpture({.resolution = 48}), 384, 384, control);

  transfer::TransferControl guide;
  guide.source = "thickness";
  guide.destination = "0.7 facing + 0.3 accessibility";
  guide.values = thickness(*map, control);
  guide.mapping = transfer::ControlMapping::Rank;

  transfer::TransferOptions options;
  options.method = transfer::TransferMethod::Fast;
  options.quality = transfer::TransferQuality::Best;  // Where copied pieces meet, cracks are given more time.
  options.seed = 7;
  const transfer::TransferInput input{
      .history = history, .map = map, .texel_size_mm = map->median_texel_size_mm(), .controls = {guide}};
  const transfer::TransferResult result = transfer::transfer(input, options, control);
  std::printf("energy %.3f = texture %.3f and control %.3f; %.0f %% of neighbors stay neighbors\n",
              result.energy.energy, result.energy.coherence, result.energy.control_mismatch,
              100.0 * result.energy.coherent_share);

  const ImageF coordinates = transfer::coordinate_image(result, map->width(), map->height(), history->facts().width);
  ImageF texture = aged_by_map(*history, coordinates, guide.values, control);
  dilate(texture, map->coverage(), 8);  // Filtering must not bleed at the charts' borders.
  write_color(argv[1], texture);
  write_color(argv[2], render(map->mesh(), texture, {.width = 480, .height = 600}, control));
  return 0;
} catch (const Canceled&) {
  return 130;
} catch (const std::exception& e) {
  std::fprintf(stderr, "03_full_control: %s\n", e.what());
  return 1;
}
