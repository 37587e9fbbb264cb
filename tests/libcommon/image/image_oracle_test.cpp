// PNG and EXR are read and written by libpng and OpenEXR (libcommon/image/png_*.cpp, exr_*.cpp). OpenImageIO, which
// reads and writes all else, is the truth: the same bytes are written, and the same is read from any file.
#include <OpenEXR/ImfThreading.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/random.h"
#include "libcommon/image/image_decoder.h"
#include "libcommon/image/image_source.h"
#include "libcommon/image/media_module.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::TempFolder;

/// Values with plain places, noise and repetition, so that compression finds something.
template <class T>
std::vector<T> values_of(const EncodedFormat& format, double low, double high) {
  std::vector<T> values(static_cast<std::size_t>(format.width) * static_cast<std::size_t>(format.height) *
                        format.channels.size());
  RandomStream random(7, values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double at = i % 97 < 40 ? static_cast<double>(i % 61) / 61.0 : random.uniform();
    values[i] = static_cast<T>(low + (high - low) * (i % 389 < 100 ? 0.25 : at));
  }
  return values;
}

/// Bytes that `encoder` makes of rows that come in pieces of `step`.
std::string encoded_by(ImageEncoder& encoder, MemorySink& sink, const EncodedFormat& format, const void* values,
                       int step) {
  const std::size_t row = static_cast<std::size_t>(format.width) * format.channels.size() *
                          (format.values == EncodedFormat::Values::Codes ? 1 : sizeof(float));
  for (int y = 0; y < format.height; y += step) {
    encoder.write(std::min(step, format.height - y),
                  static_cast<const std::byte*>(values) + static_cast<std::size_t>(y) * row);
  }
  encoder.finish();
  return sink.bytes;
}

void expect_equal_bytes(const EncodedFormat& format, const void* values) {
  MemorySink truth_sink;
  const std::string truth =
      encoded_by(*media_module().create_encoder(format, truth_sink), truth_sink, format, values, format.height);
  for (int step : {format.height, 16, 5, 1}) {
    MemorySink sink;
    const std::string ours = encoded_by(*create_encoder(format, sink), sink, format, values, step);
    EXPECT_TRUE(ours == truth) << format.name << ' ' << format.width << " x " << format.height << " x "
                               << format.channels.size() << " key `" << format.key << "` by " << step << ": "
                               << ours.size() << " and " << truth.size() << " bytes";
  }
}

constexpr std::array<std::array<int, 2>, 6> kSizes{{{1, 1}, {7, 5}, {33, 17}, {64, 64}, {300, 211}, {1030, 40}}};

TEST(ImageOracle, PngsHaveTheBytesOfOpenImageIo) {
  for (const auto& [width, height] : kSizes) {
    for (std::size_t channels : {1u, 2u, 3u, 4u}) {
      EncodedFormat format{
          .name = "a.png", .width = width, .height = height, .channels = std::vector<std::string>(channels)};
      const std::vector<std::uint8_t> codes = values_of<std::uint8_t>(format, 0, 255);
      for (const char* key : {"", "0123abcd"}) {
        format.key = key;
        expect_equal_bytes(format, codes.data());
      }
      format.has_facts = false;  // Textures of a GLB, and of the studio.
      for (int level : {6, 4}) {
        for (bool is_srgb : {false, true}) {
          format.png_level = level;
          format.is_srgb = is_srgb;
          expect_equal_bytes(format, codes.data());
        }
      }
    }
  }
}

TEST(ImageOracle, ExrsHaveTheBytesOfOpenImageIo) {
  const std::vector<std::vector<std::string>> names{{"Y"},
                                                    {"R", "G", "B"},
                                                    {"R", "G", "B", "A"},
                                                    {"source.x", "source.y", "angle"},
                                                    {"b", "a", "Z", "X", "gain.R", "gain.G", "a.b.c"}};
  for (const auto& [width, height] : kSizes) {
    for (const std::vector<std::string>& channels : names) {
      for (const auto kind : {EncodedFormat::Values::Half, EncodedFormat::Values::Float}) {
        for (const char* key : {"", "0123abcd"}) {
          const EncodedFormat format{
              .name = "a.exr", .width = width, .height = height, .channels = channels, .values = kind, .key = key};
          const std::vector<float> values = values_of<float>(format, -3.0, 700.0);
          expect_equal_bytes(format, values.data());
        }
      }
    }
  }
}

/// Content that OpenImageIO reads of a file, or its error, against what we do.
struct Read {
  ImageInfo info;
  CodedImage image;
  std::string error;
};

template <class Open>
Read read_by(const Open& open) {
  Read result;
  try {
    const std::unique_ptr<ImageSource> source = open();
    if (!source) return {.info = {}, .image = {}, .error = "not ours"};
    result.info = source->first_info();
    // What image_decoder.cpp refuses before any pixel is read.
    if (std::max(result.info.width, result.info.height) > kMaxImageSide) throw InvalidInput("an unusable size");
    result.info.num_frames = source->count_frames();
    result.image = source->read(0);
  } catch (const Error& e) {
    result.error = e.what();
  }
  return result;
}

std::unique_ptr<ImageSource> open_ours(const std::filesystem::path& path) {
  auto source = open_png(path);
  return source ? std::move(source) : open_exr(path);
}

/// Compares bytes, but for which of the NaNs it is: those are refused later.
bool hold_equal_values(const CodedImage& a, const CodedImage& b) {
  if (a.type != CodedImage::Type::Float || a.bytes.size() != b.bytes.size()) return a.bytes == b.bytes;
  for (std::size_t at = 0; at < a.bytes.size(); at += sizeof(float)) {
    float x = 0, y = 0;
    std::memcpy(&x, &a.bytes[at], sizeof x);
    std::memcpy(&y, &b.bytes[at], sizeof y);
    if (std::memcmp(&x, &y, sizeof x) != 0 && !(std::isnan(x) && std::isnan(y))) return false;
  }
  return true;
}

/// @returns whether libpng or OpenEXR read it.
bool expect_equal_reading(const std::filesystem::path& path) {
  const Read ours = read_by([&] { return open_ours(path); });
  // OpenImageIO gives the data window.
  if (ours.error == "not ours" || !ours.info.facts.window.empty()) return false;
  const Read truth = read_by([&] { return media_module().open_image(path, path, false); });
  EXPECT_EQ(ours.error.empty(), truth.error.empty()) << path << ": `" << ours.error << "`, `" << truth.error << "`";
  EXPECT_EQ(ours.error.find('\n'), std::string::npos);
  EXPECT_EQ(ours.info.width, truth.info.width) << path;
  EXPECT_EQ(ours.info.height, truth.info.height) << path;
  EXPECT_EQ(ours.info.channels, truth.info.channels) << path;
  EXPECT_EQ(ours.info.is_integer, truth.info.is_integer) << path;
  EXPECT_EQ(ours.info.is_raw, truth.info.is_raw) << path;
  EXPECT_EQ(ours.info.num_frames, truth.info.num_frames) << path;
  EXPECT_EQ(ours.info.frame_rate, truth.info.frame_rate) << path;
  EXPECT_EQ(ours.info.date_time, truth.info.date_time) << path;
  EXPECT_EQ(ours.info.key, truth.info.key) << path;
  EXPECT_EQ(ours.image.type, truth.image.type) << path;
  // OpenImageIO knows no alpha by other names than "A", and none in layers: there it stands where its name does.
  const std::vector<std::string>& channels = ours.info.channels;
  const auto& alpha = ours.image.associated_alpha;
  const bool is_plain = std::find(channels.begin(), channels.end(), "A") != channels.end();
  if (is_plain || alpha < 0) {
    EXPECT_EQ(alpha, truth.image.associated_alpha) << path;
  } else {
    const std::string name = channels.at(static_cast<std::size_t>(alpha)).substr(ours.info.color_layer.size());
    EXPECT_TRUE(name == "A" || name == "a" || name == "alpha" || name == "Alpha") << path << ": " << name;
  }
  EXPECT_TRUE(hold_equal_values(ours.image, truth.image)) << path;
  return true;
}

TEST(ImageOracle, WhatWeWriteIsReadAsOpenImageIoReadsIt) {
  const TempFolder folder;
  for (std::size_t channels : {1u, 2u, 3u, 4u}) {
    for (const char* key : {"", "0123abcd"}) {
      EncodedFormat format{
          .name = "a.png", .width = 37, .height = 20, .channels = std::vector<std::string>(channels), .key = key};
      write_atomically(folder / "a.png", encoded(format, values_of<std::uint8_t>(format, 0, 255).data()));
      EXPECT_TRUE(expect_equal_reading(folder / "a.png"));
      format.channels = std::vector<std::string>{"R", "G", "B", "A"};
      format.channels.resize(channels);
      format.name = "a.exr";
      for (const auto kind : {EncodedFormat::Values::Half, EncodedFormat::Values::Float}) {
        format.values = kind;
        write_atomically(folder / "a.exr", encoded(format, values_of<float>(format, -2, 9).data()));
        EXPECT_TRUE(expect_equal_reading(folder / "a.exr"));
      }
    }
  }
}

// Layers, places, colors, and names that differ in case only.
TEST(ImageOracle, ChannelsStandInTheOrderOfOpenImageIo) {
  const TempFolder folder;
  const std::vector<std::vector<std::string>> names{
      {"X", "Y", "Z"},
      {"Z", "Y"},
      {"A", "B", "G", "R", "Z"},
      {"Depth", "alpha", "blue", "green", "red"},
      {"r", "R", "b", "a", "A"},
      {"n.X", "n.Y", "n.Z", "n.A", "R", "G", "B"},
      {"normal.z", "normal.y", "normal.x", "albedo.B", "albedo.G", "albedo.R"},
      {"Zback", "AR", "RA", "GA", "AG", "AB", "BA", "real", "imag"},
      {"k.10", "k.9", "a.b.R", "a.R", "a.", ".R"}};
  for (const std::vector<std::string>& channels : names) {
    const EncodedFormat format{
        .name = "a.exr", .width = 5, .height = 3, .channels = channels, .values = EncodedFormat::Values::Float};
    write_atomically(folder / "a.exr", encoded(format, values_of<float>(format, 0, 1).data()));
    EXPECT_TRUE(expect_equal_reading(folder / "a.exr"));
  }
}

TEST(ImageOracle, BackwardsAndInPiecesTheSameRowsAreRead) {
  const TempFolder folder;
  EncodedFormat format{.name = "a.png", .width = 40, .height = 90, .channels = std::vector<std::string>(3)};
  write_atomically(folder / "a.png", encoded(format, values_of<std::uint8_t>(format, 0, 255).data()));
  format.name = "a.exr";
  format.channels = {"R", "G", "B"};
  format.values = EncodedFormat::Values::Half;
  write_atomically(folder / "a.exr", encoded(format, values_of<float>(format, 0, 1).data()));
  for (const char* name : {"a.png", "a.exr"}) {
    const auto source = open_ours(folder / name);
    ASSERT_TRUE(source);
    const CodedImage whole = source->read(0);
    for (const auto& [begin, end] : {std::array{60, 61}, {2, 40}, {89, 90}, {0, 90}}) {
      const CodedImage rows = source->read_rows(begin, end);
      const std::size_t row = whole.bytes.size() / 90;
      EXPECT_TRUE(std::equal(rows.bytes.begin(), rows.bytes.end(),
                             whole.bytes.begin() + static_cast<std::ptrdiff_t>(row) * begin))
          << name << ' ' << begin;
    }
    EXPECT_THROW((void)source->read(1), IoError) << name;
  }
}

// A damaged file is refused by both or read the same by both. Where libpng or OpenEXR are not asked, OpenImageIO is.
/// OpenEXR takes a damaged block that decodes to too little without an error, and hands out what its buffers held
/// before. So that both readers get the same of it: new memory is filled with one value, and no other thread's turn
/// decides which buffer it is.
void make_leftovers_equal() {
  ::mallopt(M_PERTURB, 0x5a);
  OIIO::attribute("exr_threads", -1);
  Imf::setGlobalThreadCount(0);
}

TEST(ImageOracle, DamagedFilesAreReadAsOpenImageIoReadsThem) {
  make_leftovers_equal();
  const TempFolder folder;
  EncodedFormat png{.name = "a.png", .width = 23, .height = 19, .channels = std::vector<std::string>(3), .key = "key"};
  EncodedFormat exr{.name = "a.exr",
                    .width = 23,
                    .height = 19,
                    .channels = {"R", "G", "B"},
                    .values = EncodedFormat::Values::Half,
                    .key = "key"};
  const std::array files{std::pair{std::string("a.png"), encoded(png, values_of<std::uint8_t>(png, 0, 255).data())},
                         std::pair{std::string("a.exr"), encoded(exr, values_of<float>(exr, 0, 1).data())}};
  RandomStream random(11, 0);
  int num_ours = 0;
  for (const auto& [name, good] : files) {
    for (std::size_t length = 0; length < good.size();
         length += 1 + good.size() / testing_support::sample_count<std::size_t>(60)) {
      write_atomically(folder / name, std::string_view(good).substr(0, length));
      num_ours += expect_equal_reading(folder / name) ? 1 : 0;
    }
    for (int i = 0; i < testing_support::sample_count(300); ++i) {
      std::string bad = good;
      for (int flips = 0; flips <= i % 3; ++flips) {
        const auto at = static_cast<std::size_t>(
            random.uniform() * static_cast<double>(i % 2 == 0 ? std::min<std::size_t>(bad.size(), 400) : bad.size()));
        bad[at] = static_cast<char>(random.uniform() * 256.0);
      }
      write_atomically(folder / name, bad);
      num_ours += expect_equal_reading(folder / name) ? 1 : 0;
    }
  }
  EXPECT_GT(num_ours, testing_support::sample_count(100));  // The check has looked at something.
}

/// All codes, as OpenImageIO makes values of them; `num` at a time, since it has a way of its own for many.
template <class Code>
void expect_equal_values(CodedImage::Type type, const OIIO::TypeDesc& truth_type, int num) {
  constexpr int kCodes = std::numeric_limits<Code>::max() + 1;
  ImageInfo info;
  info.channels = {"Y"};
  for (int first = 0; first + num <= kCodes; first += num) {
    std::vector<Code> codes(static_cast<std::size_t>(num));
    std::iota(codes.begin(), codes.end(), static_cast<Code>(first));
    std::vector<float> truth(codes.size());
    ASSERT_TRUE(OIIO::convert_pixel_values(truth_type, codes.data(), OIIO::TypeDesc::FLOAT, truth.data(), num));
    CodedImage coded{num, 1, 1, type, -1, std::vector<std::byte>(codes.size() * sizeof(Code))};
    std::memcpy(coded.bytes.data(), codes.data(), coded.bytes.size());
    const DecodedImage image = decoded(coded, info, "a.png");
    EXPECT_EQ(std::vector<float>(image.values.values().begin(), image.values.values().end()), truth) << first;
  }
}

TEST(ImageOracle, CodesBecomeTheValuesThatOpenImageIoMakesOfThem) {
  for (int num : {1, 4, 16, 256}) {
    expect_equal_values<std::uint8_t>(CodedImage::Type::UInt8, OIIO::TypeDesc::UINT8, num);
    expect_equal_values<std::uint16_t>(CodedImage::Type::UInt16, OIIO::TypeDesc::UINT16, num);
  }
}

TEST(ImageOracle, AProgramThatLinksTheLibraryLoadsNoModule) {
  ::setenv("PATINATE_MODULES", "/nowhere", 1);
  const TempFolder folder;
  const EncodedFormat tiff{.name = "a.tif", .width = 3, .height = 2, .channels = std::vector<std::string>(3)};
  write_atomically(folder / "a.tif", encoded(tiff, values_of<std::uint8_t>(tiff, 0, 255).data()));
  EXPECT_EQ(media_module().open_image(folder / "a.tif", folder / "a.tif", false)->first_info().width, 3);
  ::unsetenv("PATINATE_MODULES");
}

TEST(ImageOracle, RealFilesAreReadAsOpenImageIoReadsThem) {
  PATINATE_REQUIRE_DATA(data, ".");
  int num_ours = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(data)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".png" || extension == ".exr") num_ours += expect_equal_reading(entry.path()) ? 1 : 0;
  }
  EXPECT_GT(num_ours, 20);
}

}  // namespace
}  // namespace patinate
