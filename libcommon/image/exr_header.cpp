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

/// What a header says of how much there is to be read.
struct Extent {
  std::int64_t width = 0, height = 0;            ///< Of the data window; 0 = not said.
  std::int64_t tile_width = 0, tile_height = 0;  ///< 0 = rows.
  std::int64_t num_chunks = 0;
};

/// The value of an attribute. @returns false if it cannot be read.
bool read_extent(std::istream& in, const std::string& name, const std::string& type, std::uint32_t size,
                 Extent& extent) {
  const std::streampos begin = in.tellg();
  std::array<std::int64_t, 4> numbers{};
  const bool is_window = name == "dataWindow" && type == "box2i" && size == 16;
  const bool is_tiles = name == "tiles" && type == "tiledesc" && size >= 8;
  const bool is_count = name == "chunkCount" && type == "int" && size == 4;
  for (std::size_t i = 0; i < (is_window ? 4U : is_tiles ? 2U : is_count ? 1U : 0U); ++i) {
    const auto number = read_u32(in);
    if (!number) return false;
    numbers[i] = static_cast<std::int32_t>(*number);
  }
  if (is_window) {
    extent.width = numbers[2] - numbers[0] + 1;
    extent.height = numbers[3] - numbers[1] + 1;
  }
  if (is_tiles) {
    extent.tile_width = numbers[0];
    extent.tile_height = numbers[1];
    if (numbers[0] < 1 || numbers[1] < 1) return false;
  }
  if (is_count) extent.num_chunks = numbers[0];
  in.seekg(begin + static_cast<std::streamoff>(size));
  return static_cast<bool>(in);
}

/// Whether the table of places that OpenEXR makes is no larger than the file may hold.
bool is_small(const Extent& extent, std::int64_t file_size) {
  constexpr std::int64_t kPlace = 8;
  if (extent.width < 1 || extent.height < 1 || extent.width > kMaxImageSide || extent.height > kMaxImageSide)
    return false;
  const auto parts = [](std::int64_t all, std::int64_t part) { return (all + part - 1) / part; };
  const std::int64_t num_tiles =
      extent.tile_width == 0 ? 0 : parts(extent.width, extent.tile_width) * parts(extent.height, extent.tile_height);
  return num_tiles <= file_size / kPlace && extent.num_chunks >= 0 && extent.num_chunks <= file_size / kPlace;
}

/// One header up to the empty name behind it. @returns nothing if it cannot be read.
std::optional<Extent> read_header_extent(std::istream& in, std::string name) {
  Extent extent;
  while (!name.empty()) {
    const auto type = read_name(in);
    const auto size = read_u32(in);
    if (!type || !size || !read_extent(in, name, *type, *size, extent)) return std::nullopt;
    const auto next = read_name(in);
    if (!next) return std::nullopt;
    name = *next;
  }
  return extent;
}

}  // namespace

bool is_plain_exr(const std::filesystem::path& path) {
  constexpr std::uint32_t kMagic = 20000630, kVersion = 2, kVersionBits = 0xff, kTiled = 0x200, kLongNames = 0x400,
                          kMultiPart = 0x1000;
  std::ifstream in(path, std::ios::binary);
  in.seekg(0, std::ios::end);
  const std::int64_t file_size = in ? static_cast<std::int64_t>(in.tellg()) : 0;
  in.seekg(0);
  const auto magic = read_u32(in), version = read_u32(in);
  if (!version || *magic != kMagic || (*version & kVersionBits) != kVersion ||
      (*version & ~(kVersionBits | kTiled | kLongNames | kMultiPart)) != 0)
    return false;
  constexpr int kMostParts = 4096;
  for (int part = 0; part < kMostParts; ++part) {
    const auto name = read_name(in);
    if (!name) return false;
    if (name->empty()) return part > 0;  // Behind the last header of several.
    const auto extent = read_header_extent(in, *name);
    if (!extent || !is_small(*extent, file_size)) return false;
    if ((*version & kMultiPart) == 0) return true;
  }
  return false;
}

}  // namespace patinate
