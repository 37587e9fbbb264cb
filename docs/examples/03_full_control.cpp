// Every stage by hand, without a file in between: synthetic truth, a history, control maps, a transfer with progress that can be
// cancelled, and a lookup in which every texel has an age of its own.
//     03_full_control FOLDER
#include <cstdio>
#include <exception>
#include <memory>
#include <stop_token>

#include "capture/ingest/ingest.h"
#include "datasets_synthetic/crackle_io.h"
#include "datasets_synthetic/sculpture.h"
#include "libcommon/atlas/dilate.h"
#include "libcommon/controls/accessibility.h"
#include "libcommon/controls/facing.h"
#include "libcommon/image/image_io.h"
#include "libcommon/output/render.h"
#include "transfer/lookup/transfer_reader.h"
#include "transfer/transfer.h"
#include "transfer/transfer_io.h"

using namespace patinate;
namespace fs = std::filesystem;

/// Photographs of drying paint whose thickness is known, made into a history.
fs::path make_history(const fs::path& folder, const RunControl& control) {
  CrackleOptions crackle;
  crackle.width = crackle.height = 192;
  crackle.num_frames = 6;
  run_job(plan_crackle(crackle, folder / "crackle"), {}, control);

  IngestOptions options;
  options.thickness.mode_filter.spatial_sigma_px = 12.0;
  run_job(plan_ingest(read_capture_project(folder / "crackle/capture.json"), options, folder / "history"), {}, control);
  return folder / "history";
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

/// Every texel at its own age, `age` in [0, 1] of the history's time. One frame in memory, however many there are.
ImageF aged_by_map(const HistoryReader& history, const ImageF& coordinates, const ImageF& age) {
  const double first = history.manifest().frames.front().time;
  const double span = history.manifest().frames.back().time - first;
  ImageF texture(age.width(), age.height(), 3);
  for (int i = 0; i < history.num_frames(); ++i) {
    const ImageF frame = gather(history.read_frame(i), coordinates);
    for (int y = 0; y < age.height(); ++y) {
      for (int x = 0; x < age.width(); ++x) {
        const TimePosition at = history.locate(first + static_cast<double>(age.at(x, y)) * span);
        const double weight = at.index == i ? 1.0 - at.fraction : at.index == i - 1 ? at.fraction : 0.0;
        for (int c = 0; c < 3; ++c) texture.at(x, y, c) += static_cast<float>(weight) * frame.at(x, y, c);
      }
    }
  }
  return texture;
}

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fputs("usage: 03_full_control FOLDER\n", stderr);
    return 2;
  }
  const fs::path folder = argv[1];
  fs::create_directories(folder);

  std::stop_source stop;  // stop.request_stop() from any thread ends the work within 50 ms; nothing half-written is left.
  RunControl control;
  control.stop = stop.get_token();
  control.on_progress = [](double fraction) {
    if (fraction == 1.0) std::puts("a stage is finished");
  };
  control.num_threads = 2;  // Never changes a result.

  const HistoryReader history(make_history(folder, control));
  const auto map = std::make_shared<TexelMap>(sculpture({.resolution = 48}), 384, 384, control);

  TransferControl guide;
  guide.source = "thickness";
  guide.destination = "0.7 facing + 0.3 accessibility";
  guide.values = thickness(*map, control);
  guide.mapping = ControlMapping::Rank;

  TransferOptions options;
  options.method = TransferMethod::Fast;
  options.coherence_share = 0.95;  // Cracks are large structures: texture weighs more than the control.
  options.multi_level.first_coherence = 0.9;
  options.multi_level.reuse_penalty = 0.1;
  options.seed = 7;
  const double texel_mm = map->median_texel_size_mm();
  const TransferResult result = transfer(history, map, texel_mm, {guide}, options, control);
  std::printf("energy %.3f = texture %.3f and control %.3f; %.0f %% of neighbours stay neighbours\n", result.energy.energy,
              result.energy.coherence, result.energy.control_mismatch, 100.0 * result.energy.coherent_share);

  const ImageF coordinates = coordinate_image(result.coordinates, map->width(), map->height(), history.manifest().width);
  ImageF texture = aged_by_map(history, coordinates, guide.values);
  dilate(texture, map->coverage(), 8);  // Filtering must not bleed at the charts' borders.
  write_color(folder / "texture.png", texture);
  write_color(folder / "picture.png", render(map->mesh(), texture, {.width = 480, .height = 600}, control));
  return 0;
} catch (const Cancelled&) {
  return 130;
} catch (const std::exception& e) {
  std::fprintf(stderr, "03_full_control: %s\n", e.what());
  return 1;
}
