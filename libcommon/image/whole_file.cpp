#include "libcommon/image/whole_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

namespace patinate {

namespace {

using std::string_view_literals::operator""sv;

/// Bytes of a file at any place; fewer than asked for at its end.
class Bytes {
 public:
  explicit Bytes(const std::filesystem::path& path) : in_(path, std::ios::binary) {
    in_.seekg(0, std::ios::end);
    size_ = in_ ? static_cast<std::int64_t>(in_.tellg()) : 0;
  }
  [[nodiscard]] std::int64_t size() const { return size_; }
  [[nodiscard]] std::string at(std::int64_t offset, std::int64_t count) {
    if (offset < 0 || offset >= size_) return "";
    std::string out(static_cast<std::size_t>(std::min(count, size_ - offset)), '\0');
    in_.clear();
    in_.seekg(offset);
    in_.read(out.data(), static_cast<std::streamsize>(out.size()));
    out.resize(std::max<std::streamsize>(0, in_.gcount()));
    return out;
  }

 private:
  std::ifstream in_;
  std::int64_t size_ = 0;
};

std::int64_t big_endian(std::string_view bytes) {
  std::int64_t value = 0;
  for (const char c : bytes) value = 256 * value + static_cast<unsigned char>(c);
  return value;
}

constexpr int kMostParts = 1'000'000;  ///< Most parts of a file that is followed from part to part.

/// Length, type, data and check sum of each chunk; the last one is IEND.
bool is_png_cut(Bytes& file) {
  constexpr std::int64_t kSignature = 8, kAround = 12;
  std::int64_t at = kSignature;
  for (int i = 0; i < kMostParts; ++i) {
    const std::string head = file.at(at, 8);
    if (head.size() < 8) return true;
    at += kAround + big_endian(std::string_view(head).substr(0, 4));
    if (at > file.size()) return true;
    if (std::string_view(head).substr(4) == "IEND"sv) return false;
  }
  return false;
}

/// Segments with their lengths up to the picture, which ends with FF D9 and cannot hold it. A thumbnail in front of the
/// picture has an end of its own.
bool is_jpeg_cut(Bytes& file) {
  constexpr std::int64_t kBlock = 1 << 20;
  constexpr auto kEnd = "\xff\xd9"sv;
  constexpr unsigned char kScan = 0xda;
  if (file.at(file.size() - 2, 2) == kEnd) return false;
  std::int64_t at = 2;
  for (int i = 0; i < kMostParts; ++i) {
    const std::string head = file.at(at, 4);
    if (head.size() < 4 || static_cast<unsigned char>(head[0]) != 0xff) return head.size() < 4;
    if (head[1] == '\xff') {  // Filled up.
      ++at;
      continue;
    }
    if (static_cast<unsigned char>(head[1]) == kScan) break;
    at += 2 + big_endian(std::string_view(head).substr(2));
  }
  for (; at < file.size(); at += kBlock) {
    if (file.at(at, kBlock + 1).find(kEnd) != std::string::npos) return false;
  }
  return true;
}

}  // namespace

bool is_cut_off(const std::filesystem::path& path) {
  Bytes file(path);
  const std::string begin = file.at(0, 8);
  if (begin == "\x89PNG\r\n\x1a\n"sv) return is_png_cut(file);
  if (begin.starts_with("\xff\xd8\xff"sv)) return is_jpeg_cut(file);
  return false;
}

}  // namespace patinate
