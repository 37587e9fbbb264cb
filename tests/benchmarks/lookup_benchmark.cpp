// Lookups of a 4k atlas, at one time and with a time of its own at every texel, against copies and plain gathers of the
// same bytes; and a 16k atlas written in strips, with the memory that took. `lookup_benchmark --write TRANSFER IMAGE`
// is what the last part runs.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "libcommon/core/parallel.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/time_map.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/benchmarks/patch_transfer.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"
#include "tests/support/threads.h"
#include "transfer/lookup/texture_files.h"

namespace patinate {
namespace {

constexpr int kAtlas = 4096, kSource = benchmarks::kPatchSource;
constexpr float kDegree = 0.0174532925f;  // Radians.
constexpr double kTexels = 1.0 * kAtlas * kAtlas;

/// A gather with nothing around it. @param out  Of texels x channels.
template <class T>
void plain_gather(const Image<T>& source, const transfer::PackedCoordinates& indices, Image<T>& out,
                  const RunControl& control) {
  parallel_for(out.height(), 64, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      const auto row = indices.row(y);
      T* to = out.row(y).data();
      for (std::size_t x = 0; x < row.size(); ++x, to += 3) {
        const T* from = source.data() + 3 * std::size_t{row[x]};
        to[0] = from[0];
        to[1] = from[1];
        to[2] = from[2];
      }
    }
  });
}

template <class T>
void compare_gathers(const char* name, const Image<T>& source, const transfer::PackedCoordinates& indices) {
  Image<T> out(kAtlas, kAtlas, 3), copy(kAtlas, kAtlas, 3);  // Touched already, as the plain loops need it.
  for (int threads : {1, 2}) {
    const RunControl control = testing_support::with_threads(threads);
    const double copied = benchmarks::median_of_five([&] {
      parallel_for(out.height(), 64, control, [&](std::int64_t begin, std::int64_t end) {
        std::memcpy(copy.row(static_cast<int>(begin)).data(), out.row(static_cast<int>(begin)).data(),
                    static_cast<std::size_t>(end - begin) * out.row(0).size_bytes());
      });
    });
    const double plain = benchmarks::median_of_five([&] { plain_gather(source, indices, out, control); });
    const double lookup = benchmarks::median_of_five([&] {
      parallel_for(out.height(), 64, control, [&](std::int64_t begin, std::int64_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
          transfer::gather_packed(source, indices.row(y), T{}, out.row(y));
      });
    });
    std::printf("4k, %s, %d thread%s, G texels/s: copy %.2f, plain gather %.2f, lookup %.2f (%.0f ms)\n", name, threads,
                threads == 1 ? "" : "s", 1e-9 * kTexels / copied, 1e-9 * kTexels / plain, 1e-9 * kTexels / lookup,
                1e3 * lookup);
  }
}

/// Patches of 32 x 32 texels, each a square of the source turned by 30 degrees.
ImageF turned_coordinates() {
  constexpr int kPatch = 32;
  ImageF coordinates(kAtlas, kAtlas, 2);
  const float cosine = std::cos(kDegree * 30.0f), sine = std::sin(kDegree * 30.0f);
  for (int y = 0; y < kAtlas; ++y) {
    for (int x = 0; x < kAtlas; ++x) {
      const auto patch = static_cast<std::uint32_t>(y / kPatch * kAtlas + x / kPatch) * 2654435761u;  // Knuth's hash.
      const auto u = static_cast<float>(x % kPatch), v = static_cast<float>(y % kPatch);
      const auto corner = [](std::uint32_t bits) { return static_cast<float>(bits % (kSource - 3 * kPatch) + kPatch); };
      coordinates.at(x, y, 0) = corner(patch & 0xFFFFu) + cosine * u - sine * v;
      coordinates.at(x, y, 1) = corner(patch >> 16u) + sine * u + cosine * v;
    }
  }
  return coordinates;
}

/// Lookups between pixels, against the nearest pixels of the same places.
void compare_between_pixels(const ImageF& frame) {
  const transfer::PackedPlaces places = transfer::pack_coordinates(turned_coordinates(), kSource, kSource);
  ImageF out(kAtlas, kAtlas, 3);
  for (int threads : {1, 2}) {
    const RunControl control = testing_support::with_threads(threads);
    const double nearest =
        benchmarks::median_of_five([&] { out = transfer::gather_packed(frame, places.pixels, 0.0f, control); });
    const double between =
        benchmarks::median_of_five([&] { out = transfer::gather_packed(frame, places, 0.0f, control); });
    std::printf("4k, patches turned by 30 degrees, %d thread%s: nearest pixel %.0f ms, between pixels %.0f ms (%.1f)\n",
                threads, threads == 1 ? "" : "s", 1e3 * nearest, 1e3 * between, between / nearest);
  }
}

void compare_time_maps(const HistoryReader& history, const transfer::PackedCoordinates& indices) {
  ImageF times(kAtlas, kAtlas);
  for (std::size_t i = 0; i < times.values().size(); ++i)
    times.data()[i] = static_cast<float>(3.0 * static_cast<double>(i) / kTexels);
  transfer::TimeMapLookup lookup(history, Between::Blend);
  ImageF out(kAtlas, kAtlas, 3);
  const double mapped = benchmarks::median_of_five([&] {
    lookup.look_up({indices.values(), {}}, times.values(), 0, out);
  });
  std::printf("4k, time map over 4 frames %.0f ms\n", 1e3 * mapped);
}

void compare_speed() {
  const testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), kSource, kSource, 32, testing_support::blotches);
  const HistoryReader history(folder.path());
  const ImageF coordinates = benchmarks::patch_coordinates(kAtlas, false), frame = history.read_frame(0),
               next = history.read_frame(1);
  const transfer::PackedCoordinates indices = transfer::pack_coordinates(coordinates, kSource, kSource).pixels;
  compare_gathers("8-bit RGB", srgb8_from_linear(frame), indices);
  compare_gathers("float RGB", frame, indices);
  compare_between_pixels(frame);
  compare_time_maps(history, indices);
  ImageF out;
  for (int threads : {1, 2}) {
    const RunControl control = testing_support::with_threads(threads);
    const double simple =
        benchmarks::median_of_five([&] { out = transfer::gather(frame, coordinates, 0.0f, control); });
    const double image =
        benchmarks::median_of_five([&] { out = transfer::gather_packed(frame, indices, 0.0f, control); });
    const double blended = benchmarks::median_of_five([&] {
      ImageF between = frame;
      for (std::size_t i = 0; i < between.values().size(); ++i)
        between.data()[i] = 0.7f * between.data()[i] + 0.3f * next.data()[i];
      const ImageU8 texture = transfer::gather_packed(srgb8_from_linear(between), indices, 0, control);
    });
    std::printf(
        "4k, %d thread%s, into a new image: from float coordinates %.0f ms, packed %.0f ms; between two frames as "
        "8-bit codes %.0f ms (%.2f G texels/s)\n",
        threads, threads == 1 ? "" : "s", 1e3 * simple, 1e3 * image, 1e3 * blended, 1e-9 * kTexels / blended);
    for (int num_frames : {4, 32}) {
      ImageF times(kAtlas, kAtlas);
      for (int y = 0; y < kAtlas; ++y) {
        for (int x = 0; x < kAtlas; ++x)
          times.at(x, y) = static_cast<float>((num_frames - 1.0) * (x + y) / (2.0 * kAtlas));
      }
      const double mapped = benchmarks::median_of_five([&] {
        out = transfer::gather_at_times(history, transfer::PackedPlaces{indices, {}}, times, Between::Blend, control);
      });
      const double frames = benchmarks::median_of_five([&] {
        for (int f = 0; f < num_frames; ++f) (void)history.read_frame(f);
      });
      std::printf(
          "4k, %d thread%s, time map over %d frames: %.0f ms, of which reading frames %.0f ms; speed without it %.2f "
          "of a plain lookup into a new image\n",
          threads, threads == 1 ? "" : "s", num_frames, 1e3 * mapped, 1e3 * frames, simple / (mapped - frames));
    }
  }
}

/// Peak of this program alone: what getrusage() says begins with the memory of the one that started it.
double peak_mb() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0.0;
    if (word == "VmHWM:" && status >> kilobytes) return kilobytes / 1024.0;
  }
  return 0.0;
}

int write_image(const std::filesystem::path& transfer_path, const std::filesystem::path& image) {
  const double before = peak_mb();
  const transfer::TransferFolder transfer(transfer_path);
  const std::vector<transfer::TextureFile> textures{{{image}, transfer.history().sample(0.5)}};
  const double seconds = benchmarks::seconds([&] { transfer::TextureWriter(transfer).write(textures); });
  std::printf("%s: %.1f s, at most %.0f MB in memory, %.0f of them the program before it began\n",
              image.filename().c_str(), seconds, peak_mb(), before);
  return 0;
}

void compare_memory(const char* program) {
  for (int side : {4096, 16384}) {
    const testing_support::TempFolder folder;
    benchmarks::write_patch_transfer(folder.path(), side);
    for (const char* extension : {".png", ".exr"}) {
      const std::string image = (folder / ("texture_" + std::to_string(side) + extension)).string();
      const std::string command = std::string(program) + " --write " + (folder / "transfer").string() + " " + image;
      std::fflush(stdout);
      if (std::system(command.c_str()) != 0) std::printf("%s failed\n", command.c_str());
      std::filesystem::remove(image);
    }
  }
}

}  // namespace
}  // namespace patinate

int main(int argc, char** argv) {
  if (argc == 4 && std::string(argv[1]) == "--write") return patinate::write_image(argv[2], argv[3]);
  if (argc == 1) patinate::compare_speed();
  patinate::compare_memory(argv[0]);  // Alone with --memory.
}
