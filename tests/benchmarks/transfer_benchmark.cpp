// Prints what transfer costs and how its methods compare; no test, no threshold. Run it in a release build on a quiet
// machine:
//     build/release/bin/transfer_benchmark            (--files: the last row alone)
// Medians of five runs; figures are ratios wherever there are two ways of doing the same work.
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <tuple>
#include <vector>

#include "patinate/history/history.h"
#include "patinate/transfer/transfer.h"
#include "patinate/transfer/transfer_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/benchmarks/patch_transfer.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/exemplar/appearance_cache.h"
#include "transfer/lookup/packed_lookup.h"

namespace patinate {
namespace {

using benchmarks::median_of_five;
using benchmarks::seconds;

struct Setting {
  testing_support::TempFolder folder;
  std::shared_ptr<const HistoryReader> history;
  std::shared_ptr<const TexelMap> map;
  std::vector<transfer::TransferControl> controls;

  Setting(int source_size, int num_frames, int atlas) {
    testing_support::write_history(folder.path(), source_size, source_size, num_frames, testing_support::blotches);
    history = std::make_shared<const HistoryReader>(folder.path());
    map = std::make_shared<TexelMap>(testing_support::cut_plane(atlas), atlas, atlas);
    ImageF guide(atlas, atlas);
    for (TexelId t = 0; t < map->num_texels(); ++t) {
      if (map->is_covered(t)) guide.data()[t] = static_cast<float>(map->position_mm(t).x() / atlas);
    }
    controls.push_back({"x", "gradient", guide, {}, 1.0, transfer::ControlMapping::Rank});
  }
  [[nodiscard]] transfer::TransferResult run(transfer::TransferMethod method,
                                             const transfer::AppearanceSource& appearance = {}) const {
    transfer::TransferOptions options;
    options.method = method;
    return transfer::transfer({.history = history,
                               .map = map,
                               .texel_size_mm = map->median_texel_size_mm(),
                               .controls = controls,
                               .appearance = appearance},
                              options);
  }
  void forget() const { std::filesystem::remove_all(folder / transfer::kCacheFolder); }
};

void compare_methods() {
  const Setting setting(256, 12, 384);
  transfer::TransferResult reference, fast;
  const double reference_s = seconds([&] { reference = setting.run(transfer::TransferMethod::Reference); });
  const double fast_s = median_of_five([&] { fast = setting.run(transfer::TransferMethod::Fast); });
  std::printf("384 x 384 atlas, 256 x 256 x 12 history (%lld texels)\n",
              static_cast<long long>(setting.map->num_covered()));
  for (const auto& [name, result, s] : {std::tuple{"reference", &reference, reference_s}, {"fast", &fast, fast_s}}) {
    std::printf("  %-10s %8.2f s  energy %.5f  control error %.4f  coherent pairs %.3f  source used %.3f\n", name, s,
                result->energy.energy, result->energy.control_error_mean, result->energy.coherent_share,
                result->energy.used_share);
  }
  std::printf("  fast / reference: energy %.3f, time 1 / %.1f\n", fast.energy.energy / reference.energy.energy,
              reference_s / fast_s);
}

void long_history() {
  const Setting setting(512, 100, 1024);
  transfer::TransferResult result;
  const double s = seconds([&] { result = setting.run(transfer::TransferMethod::Fast); });
  std::printf("1k atlas, 512 x 512 x 100 history (%lld texels): fast %.1f s, energy %.5f\n",
              static_cast<long long>(setting.map->num_covered()), s, result.energy.energy);
}

/// One photograph, texels as large as its pixels; what does not depend on the atlas is told apart by one of 64 x 64.
void photograph() {
  const Setting small(512, 1, 64), large(512, 1, 1448);  // 1448^2 / 2 of them are covered: about 2^20.
  const double source_s = median_of_five([&] { (void)small.run(transfer::TransferMethod::Fast); });
  const double s = median_of_five([&] { (void)large.run(transfer::TransferMethod::Fast); });
  const auto texels = static_cast<double>(large.map->num_covered());
  std::printf(
      "one 512 x 512 photograph onto %.0f texels: fast %.2f s, %.2f of them reading and analyzing the photograph; %.0f "
      "k texels/s, %.0f k without that\n",
      texels, s, source_s, 1e-3 * texels / s, 1e-3 * texels / (s - source_s));
}

/// Measures what the analysis kept beside a history saves: by itself, and of a whole transfer onto few texels.
void kept_analysis(int num_frames) {
  constexpr int kLevels = 5;
  const Setting setting(512, num_frames, 512);
  const auto first = [&](const std::function<void()>& work) {
    return median_of_five([&] {
      setting.forget();
      work();
    });
  };
  const auto analyze = [&] { (void)transfer::cached_appearance_space(*setting.history, kLevels); };
  const auto run = [&] {
    (void)setting.run(transfer::TransferMethod::Fast, transfer::appearance_source(*setting.history, {.cache = true}));
  };
  const double without_s = median_of_five([&] { (void)transfer::build_appearance_space(*setting.history, kLevels); });
  const double first_s = first(analyze), second_s = median_of_five(analyze);
  const double first_transfer_s = first(run), second_transfer_s = median_of_five(run);
  std::printf(
      "512 x 512 x %d: analysis %.0f ms without a cache, %.0f the first time, %.0f the second (ratio %.3f); transfer "
      "onto %lld texels %.2f s, then %.2f s (ratio %.2f)\n",
      num_frames, 1e3 * without_s, 1e3 * first_s, 1e3 * second_s, second_s / first_s,
      static_cast<long long>(setting.map->num_covered()), first_transfer_s, second_transfer_s,
      second_transfer_s / first_transfer_s);
}

void lookup_against_copy() {
  const Setting setting(512, 1, 2048);
  const ImageF frame = setting.history->read_frame(0);
  const ImageF coordinates = transfer::coordinate_image(setting.run(transfer::TransferMethod::Fast), 2048, 2048, 512);
  ImageF copy(2048, 2048, 3);
  const ImageF original(2048, 2048, 3, 0.5f);
  const double copy_s =
      median_of_five([&] { std::memcpy(copy.data(), original.data(), original.values().size_bytes()); });
  const double gather_s = median_of_five([&] { copy = transfer::gather(frame, coordinates); });
  std::printf("2k lookup: %.1f ms; a plain copy of the same bytes: %.1f ms; ratio %.2f\n", 1e3 * gather_s, 1e3 * copy_s,
              gather_s / copy_s);
}

/// Coordinates and a control of a 4k atlas, whose pieces are 32 x 32: most of the time is compressing them.
void write_files() {
  constexpr int kAtlas = 4096;
  const Setting setting(benchmarks::kPatchSource, 1, kAtlas);
  transfer::TransferTask task;
  task.history = setting.history;
  task.input = {.history = setting.history, .map = setting.map, .controls = setting.controls};
  const transfer::PackedCoordinates pieces =
      transfer::pack_coordinates(benchmarks::patch_coordinates(kAtlas, true), benchmarks::kPatchSource,
                                 benchmarks::kPatchSource)
          .pixels;
  transfer::TransferResult result;
  for (const std::uint32_t pixel : pieces.values())
    result.coordinates.push_back(pixel == kNoValue ? -1 : static_cast<std::int32_t>(pixel));
  const testing_support::TempFolder folder;
  for (const int threads : {1, 2, 4}) {
    const RunControl run{.on_progress = {}, .stop = {}, .num_threads = threads};
    std::printf("files of a 4k transfer, %d thread%s: %.2f s\n", threads, threads == 1 ? "" : "s",
                median_of_five([&] { transfer::write_transfer_files(folder.path(), task, result, run); }));
  }
}

}  // namespace
}  // namespace patinate

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--files") == 0) {
    patinate::write_files();
    return 0;
  }
  patinate::compare_methods();
  patinate::long_history();
  patinate::photograph();
  patinate::kept_analysis(1);
  patinate::kept_analysis(100);
  patinate::lookup_against_copy();
  patinate::write_files();
}
