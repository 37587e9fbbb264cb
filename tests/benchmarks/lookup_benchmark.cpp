// Lookups of a 4k atlas, at one time and with a time of its own at every texel, against a plain gather of the same bytes.
#include <cstdio>
#include <filesystem>

#include "tests/benchmarks/timing.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"
#include "transfer/lookup/time_map.h"
#include "transfer/lookup/transfer_reader.h"

namespace patinate {
namespace {

constexpr int kAtlas = 4096, kSource = 512;

/// Patches of 32 x 32 texels, each a piece of the source in its order, as transfers are.
ImageF patches() {
  ImageF coordinates(kAtlas, kAtlas, 2);
  for (int y = 0; y < kAtlas; ++y) {
    for (int x = 0; x < kAtlas; ++x) {
      const int patch = x / 32 * 131 + y / 32 * 197;
      coordinates.at(x, y, 0) = static_cast<float>((x + patch * 37) % kSource);
      coordinates.at(x, y, 1) = static_cast<float>((y + patch * 53) % kSource);
    }
  }
  return coordinates;
}

/// A gather with nothing around it, into memory of its own as the others.
ImageF plain_gather(const ImageF& source, const ImageF& coordinates) {
  ImageF out(kAtlas, kAtlas, 3);
  const float* s = coordinates.data();
  float* to = out.data();
  for (std::int64_t i = 0; i < coordinates.num_pixels(); ++i) {
    const float* from = source.data() + 3 * (static_cast<std::int64_t>(s[2 * i + 1]) * source.width() + static_cast<std::int64_t>(s[2 * i]));
    to[3 * i] = from[0];
    to[3 * i + 1] = from[1];
    to[3 * i + 2] = from[2];
  }
  return out;
}

void compare(int num_frames) {
  const testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), kSource, kSource, num_frames, testing_support::blotches);
  const HistoryReader history(folder.path());
  const ImageF coordinates = patches(), frame = history.read_frame(0);
  ImageF times(kAtlas, kAtlas), out(kAtlas, kAtlas, 3);
  for (int y = 0; y < kAtlas; ++y) {
    for (int x = 0; x < kAtlas; ++x) times.at(x, y) = static_cast<float>((num_frames - 1.0) * (x + y) / (2.0 * kAtlas));
  }
  RunControl one;
  one.num_threads = 1;
  const double plain = benchmarks::median_of_five([&] { out = plain_gather(frame, coordinates); });
  const double lookup = benchmarks::median_of_five([&] { out = gather(frame, coordinates, 0.0f, one); });
  const double mapped = benchmarks::median_of_five([&] { out = gather_at_times(history, coordinates, times, Between::Blend, one); });
  const double frames = benchmarks::median_of_five([&] {
    for (int f = 0; f < num_frames; ++f) (void)history.read_frame(f);
  });
  std::printf("4k, %d frames, one thread: plain gather %.0f ms; lookup %.0f ms, speed %.2f; time map %.0f ms, of which reading frames %.0f ms, speed without it %.2f\n",
              num_frames, 1e3 * plain, 1e3 * lookup, plain / lookup, 1e3 * mapped, 1e3 * frames, plain / (mapped - frames));
}

}  // namespace
}  // namespace patinate

int main() {
  patinate::compare(4);
  patinate::compare(32);
}
