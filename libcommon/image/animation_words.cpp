// Durations of the pictures of animated GIF and WebP.
#include "libcommon/image/file_words.h"

namespace patinate {

namespace {

constexpr std::size_t kMaxPictures = 100'000;

/// When pictures begin that are shown one after the other. Empty where one is shown for no time, which viewers take for
/// a rate of their own.
std::vector<double> beginnings(const std::vector<double>& durations_s) {
  std::vector<double> times;
  double time = 0.0;
  for (std::size_t i = 0; i < durations_s.size(); ++i) {
    if (durations_s[i] <= 0.0 && i + 1 < durations_s.size()) return {};
    times.push_back(time);
    time += durations_s[i];
  }
  return times;
}

/// Behind the blocks of data, each with its size, that end with an empty one.
std::uint64_t after_blocks(const FileBytes& file, std::uint64_t at) {
  while (file.number(at, 1) != 0) at += 1 + file.number(at, 1);
  return at + 1;
}

/// Bytes of a table of colors. @param packed  Of the screen or of a picture.
std::uint64_t table_size(std::uint64_t packed) { return (packed & 0x80) == 0 ? 0 : std::uint64_t{6} << (packed & 7); }

}  // namespace

void read_gif_words(const FileBytes& file, FileWords& words) {
  constexpr std::uint64_t kScreen = 6, kScreenSize = 7, kExtension = 0x21, kPicture = 0x2c, kControl = 0xf9;
  constexpr double kHundredth = 0.01;
  const FileBytes little(file.part(0, file.size()), true);
  std::vector<double> durations_s;
  double duration_s = 0.0;
  std::uint64_t at = kScreen + kScreenSize + table_size(little.number(kScreen + 4, 1));
  while (durations_s.size() < kMaxPictures) {
    const std::uint64_t kind = little.number(at, 1);
    if (kind == kExtension) {
      if (little.number(at + 1, 1) == kControl) duration_s = kHundredth * static_cast<double>(little.number(at + 4, 2));
      at = after_blocks(little, at + 2);
    } else if (kind == kPicture) {
      durations_s.push_back(duration_s);
      duration_s = 0.0;
      at = after_blocks(little, at + 11 + table_size(little.number(at + 9, 1)));  // Behind the least size of codes.
    } else {
      break;
    }
  }
  words.frame_times_s = beginnings(durations_s);
}

void read_webp_animation(const FileBytes& little, FileWords& words) {
  constexpr std::uint64_t kHead = 8, kFirst = 12, kDuration = 12;
  constexpr double kThousandth = 1e-3;
  std::vector<double> durations_s;
  for (std::uint64_t at = kFirst; little.holds(at, kHead) && durations_s.size() < kMaxPictures;) {
    const std::uint64_t size = little.number(at + 4, 4);
    if (little.text(at, 4) == "ANMF")
      durations_s.push_back(kThousandth * static_cast<double>(little.number(at + kHead + kDuration, 3)));
    at += kHead + size + size % 2;
  }
  words.frame_times_s = beginnings(durations_s);
}

}  // namespace patinate
