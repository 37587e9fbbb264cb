#include "libcommon/image/exr_header.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>

#include "libcommon/image/image_decoder.h"

namespace patinate {

namespace {

std::optional<std::uint32_t> read_u32(std::istream& in) {
  std::array<unsigned char, 4> bytes{};
  if (!in.read(reinterpret_cast<char*>(bytes.data()), bytes.size())) return std::nullopt;
  return bytes[0] | std::uint32_t{bytes[1]} << 8 | std::uint32_t{bytes[2]} << 16 | std::uint32_t{bytes[3]} << 24;
}

std::optional<std::string> read_name(std::istream& in) {
  constexpr std::size_t kLongest = 255;
  std::string name;
  for (char c = 0; in.get(c);) {
    if (c == '\0') return name;
    name.push_back(c);
    if (name.size() > kLongest) return std::nullopt;
  }
  return std::nullopt;
}

bool is_small_window(std::istream& in) {
  std::array<std::int64_t, 4> window{};
  for (std::int64_t& side : window) {
    const auto number = read_u32(in);
    if (!number) return false;
    side = static_cast<std::int32_t>(*number);
  }
  const std::int64_t width = window[2] - window[0] + 1, height = window[3] - window[1] + 1;
  return width >= 1 && height >= 1 && width <= kMaxImageSide && height <= kMaxImageSide;
}

}  // namespace

bool is_plain_exr(const std::filesystem::path& path) {
  constexpr std::uint32_t kMagic = 20000630, kVersion = 2, kVersionBits = 0xff, kLongNames = 0x400;
  std::ifstream in(path, std::ios::binary);
  const auto magic = read_u32(in), version = read_u32(in);
  if (!version || *magic != kMagic || (*version & kVersionBits) != kVersion ||
      (*version & ~(kVersionBits | kLongNames)) != 0)
    return false;
  for (;;) {
    const auto name = read_name(in);
    if (!name || name->empty()) return false;  // Ends without the size.
    const auto type = read_name(in);
    const auto size = read_u32(in);
    if (!type || !size) return false;
    if (*name == "dataWindow") return *type == "box2i" && *size == 16 && is_small_window(in);
    in.ignore(*size);
  }
}

}  // namespace patinate
