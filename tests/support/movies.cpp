#include "tests/support/movies.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "libcommon/core/files.h"

namespace patinate::testing_support {

namespace {

/// Little-endian bytes.
std::string number(std::uint32_t value, int size) {
  std::string bytes;
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<char>(value >> (8 * i)));
  return bytes;
}
std::string u32(std::size_t value) { return number(static_cast<std::uint32_t>(value), 4); }
std::string u16(std::size_t value) { return number(static_cast<std::uint32_t>(value), 2); }

std::string chunk(const std::string& name, const std::string& data) { return name + u32(data.size()) + data; }
std::string list(const std::string& name, const std::string& data) { return chunk("LIST", name + data); }

/// One tag of a TIFF directory.
struct Tag {
  std::uint16_t id;
  std::uint16_t type;  ///< 1 byte, 2 text, 3 short, 4 long, 5 rational, 10 signed rational.
  std::uint32_t count;
  std::string data;
};

std::string rationals(const std::vector<double>& values) {
  std::string bytes;
  for (double v : values)
    bytes += number(static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(v * 1e6))), 4) + u32(1000000);
  return bytes;
}

/// A TIFF of one directory; `pixels` start where the data of tag 273 must say.
std::string tiff(std::vector<Tag> tags, const std::string& pixels) {
  std::sort(tags.begin(), tags.end(), [](const Tag& a, const Tag& b) { return a.id < b.id; });
  const std::size_t directory = 8, behind = directory + 2 + 12 * tags.size() + 4;
  std::string extra, entries = u16(tags.size());
  std::size_t extra_size = 0;
  for (const Tag& tag : tags) extra_size += tag.data.size() > 4 ? tag.data.size() + tag.data.size() % 2 : 0;
  for (Tag& tag : tags) {
    if (tag.id == 273) tag.data = u32(behind + extra_size);
    std::string field = tag.data;
    if (field.size() > 4) {
      field = u32(behind + extra.size());
      extra += tag.data + std::string(tag.data.size() % 2, '\0');
    }
    field.resize(4, '\0');
    entries += u16(tag.id) + u16(tag.type) + u32(tag.count) + field;
  }
  return "II" + u16(42) + u32(directory) + entries + u32(0) + extra + pixels;
}

}  // namespace

void write_avi(const std::filesystem::path& file, const std::vector<ImageU8>& frames, int frames_per_second) {
  const auto width = static_cast<std::size_t>(frames.front().width()),
             height = static_cast<std::size_t>(frames.front().height());
  const std::size_t size = 3 * width * height;
  const auto rate = static_cast<std::size_t>(frames_per_second);
  const std::string header = u32(1000000 / rate) + u32(size * rate) + u32(0) + u32(0x10) + u32(frames.size()) + u32(0) +
                             u32(1) + u32(size) + u32(width) + u32(height) + std::string(16, '\0');
  const std::string stream = "vidsDIB " + u32(0) + u32(0) + u32(0) + u32(1) + u32(rate) + u32(0) + u32(frames.size()) +
                             u32(size) + u32(0xffffffff) + u32(0) + u16(0) + u16(0) + u16(width) + u16(height);
  const std::string format =
      u32(40) + u32(width) + u32(height) + u16(1) + u16(24) + u32(0) + u32(size) + std::string(16, '\0');
  std::string movie, index;
  for (const ImageU8& frame : frames) {
    std::string pixels;  // Bottom row first, blue first.
    for (int y = frame.height() - 1; y >= 0; --y) {
      for (int x = 0; x < frame.width(); ++x) {
        for (int c = 2; c >= 0; --c) pixels.push_back(static_cast<char>(frame.at(x, y, c)));
      }
    }
    index += "00db" + u32(0x10) + u32(4 + movie.size()) + u32(size);
    movie += chunk("00db", pixels);
  }
  const std::string head =
      list("hdrl", chunk("avih", header) + list("strl", chunk("strh", stream) + chunk("strf", format)));
  write_atomically(file, chunk("RIFF", "AVI " + head + list("movi", movie) + chunk("idx1", index)));
}

bool write_animation(const std::filesystem::path& file, const std::vector<ImageU8>& frames) {
  const auto output = OIIO::ImageOutput::create(file.string());
  if (!output || !output->supports("multiimage")) return false;
  OIIO::ImageSpec spec(frames.front().width(), frames.front().height(), frames.front().channels(),
                       OIIO::TypeDesc::UINT8);
  const std::vector<OIIO::ImageSpec> specs(frames.size(), spec);
  if (!output->open(file.string(), static_cast<int>(specs.size()), specs.data())) return false;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i > 0 && !output->open(file.string(), spec, OIIO::ImageOutput::AppendSubimage)) return false;
    if (!output->write_image(OIIO::TypeDesc::UINT8, frames[i].data())) return false;
  }
  return output->close();
}

void write_dng(const std::filesystem::path& file, const ImageF& linear) {
  std::string mosaic;
  for (int y = 0; y < linear.height(); ++y) {
    for (int x = 0; x < linear.width(); ++x) {
      mosaic += u16(static_cast<std::size_t>(std::lround(65535.0f * linear.at(x, y, x % 2 + y % 2))));
    }
  }
  const auto width = static_cast<std::size_t>(linear.width()), height = static_cast<std::size_t>(linear.height());
  const std::string model("Test camera", 12);
  // Rec.709 RGB from XYZ [IEC 61966-2-1].
  const std::vector<double> matrix{3.2404542, -1.5371385, -0.4985314, -0.9692660, 1.8760108,
                                   0.0415560, 0.0556434,  -0.2040259, 1.0572252};
  write_atomically(file, tiff({{254, 4, 1, u32(0)},
                               {256, 4, 1, u32(width)},
                               {257, 4, 1, u32(height)},
                               {258, 3, 1, u16(16)},
                               {259, 3, 1, u16(1)},
                               {262, 3, 1, u16(32803)},
                               {271, 2, 5, std::string("Test", 5)},
                               {272, 2, 12, model},
                               {273, 4, 1, ""},
                               {274, 3, 1, u16(1)},
                               {277, 3, 1, u16(1)},
                               {278, 4, 1, u32(height)},
                               {279, 4, 1, u32(mosaic.size())},
                               {306, 2, 20, std::string("2024:05:06 07:08:09", 20)},
                               {33421, 3, 2, u16(2) + u16(2)},
                               {33422, 1, 4, std::string("\0\1\1\2", 4)},
                               {50706, 1, 4, std::string("\1\4\0\0", 4)},
                               {50708, 2, 12, model},
                               {50714, 3, 1, u16(0)},
                               {50717, 4, 1, u32(65535)},
                               {50721, 10, 9, rationals(matrix)},
                               {50728, 5, 3, rationals({0.5, 1.0, 0.7})},
                               {50778, 3, 1, u16(21)}},
                              mosaic));
}

}  // namespace patinate::testing_support
