#include "patinate/image/image_io.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>

#include "libcommon/core/files.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::TempFolder;

ImageF ramp(int width, int height, int channels) {
  ImageF image(width, height, channels);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < channels; ++c) {
        image.at(x, y, c) =
            static_cast<float>(x + width * y) / static_cast<float>(width * height) + 0.001f * static_cast<float>(c);
      }
    }
  }
  return image;
}

TEST(Color, All256CodesRoundTripExactly) {
  for (int code = 0; code < 256; ++code) {
    EXPECT_EQ(srgb8_from_linear(linear_from_srgb(static_cast<float>(code) / 255.0f)), code);
  }
}

TEST(Color, FollowsTheStandard) {
  // IEC 61966-2-1: code 0.5 is 0.21404114 linear.
  EXPECT_NEAR(linear_from_srgb(0.5f), 0.21404114f, 1e-7f);
  EXPECT_NEAR(srgb_from_linear(0.21404114f), 0.5f, 1e-6f);
  EXPECT_EQ(srgb8_from_linear(-1.0f), 0);
  EXPECT_EQ(srgb8_from_linear(7.0f), 255);
}

TEST(Color, TabulatedHalfFloatsLieBetweenTheirNeighbors) {
  for (std::uint32_t bits = 0x38000000U; bits < 0x40000000U; bits += 0x2000U) {
    const auto half = std::bit_cast<float>(bits);
    ASSERT_LE(srgb_from_linear(std::nextafter(half, 0.0F)), srgb_from_linear(half)) << half;
    ASSERT_LE(srgb_from_linear(half), srgb_from_linear(std::nextafter(half, 2.0F))) << half;
  }
}

TEST(Color, CodesChangeHalfWay) {
  for (int code = 0; code < 255; ++code) {
    const double half_way = (code + 0.5) / 255.0;  // IEC 61966-2-1
    const auto edge =
        static_cast<float>(half_way <= 0.04045 ? half_way / 12.92 : std::pow((half_way + 0.055) / 1.055, 2.4));
    EXPECT_EQ(srgb8_from_linear(std::nextafter(edge, 0.0f)), code);
    EXPECT_EQ(srgb8_from_linear(edge), code + 1);
  }
  constexpr double kRounding = 1e-4;  // Rounding of floats near an edge, in codes.
  for (float linear = 1e-5f; linear < 1.0f; linear *= 1.0001f) {
    EXPECT_NEAR(srgb8_from_linear(linear), 255.0 * static_cast<double>(srgb_from_linear(linear)), 0.5 + kRounding)
        << linear;
  }
}

TEST(ImageIo, EqualImagesGiveEqualBytes) {
  TempFolder folder;
  const ImageF image = ramp(33, 17, 3);
  for (const char* name : {"a.exr", "a.png", "a.tif"}) {
    write_color(folder / name, image);
    const std::string first = read_file(folder / name);
    std::filesystem::remove(folder / name);
    write_color(folder / name, image);
    EXPECT_EQ(first, read_file(folder / name)) << name;
  }
}

TEST(ImageIo, FloatExrKeepsNamedChannelsWhateverTheirOrder) {
  TempFolder folder;
  const ImageF image = ramp(8, 5, 2);
  write_exr(folder / "m.exr", image, {"source.y", "source.x"}, ExrDepth::Float, "k1");
  const ImageF swapped = read_channels(folder / "m.exr", {"source.x", "source.y"});
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 8; ++x) {
      EXPECT_EQ(swapped.at(x, y, 0), image.at(x, y, 1));
      EXPECT_EQ(swapped.at(x, y, 1), image.at(x, y, 0));
    }
  }
  EXPECT_EQ(probe_image(folder / "m.exr").key, "k1");
  EXPECT_THROW((void)read_channels(folder / "m.exr", {"Y"}), IoError);
}

TEST(ImageIo, AScaledExrSaysWhatZeroAndOneStandFor) {
  TempFolder folder;
  const ImageF map = ramp(9, 6, 1);
  const ValueScale scale{-0.125, 1.0 / 3.0, "1/mm"};
  write_scaled_exr(folder / "a.exr", map, scale, "k2");
  const ImageInfo info = probe_image(folder / "a.exr");
  EXPECT_EQ(info.scale, scale);  // Doubles, to the last bit.
  EXPECT_EQ(info.key, "k2");
  EXPECT_EQ(read_gray(folder / "a.exr"), map);
  write_scaled_exr(folder / "b.exr", map, scale, "k2");
  EXPECT_EQ(read_file(folder / "a.exr"), read_file(folder / "b.exr"));
  write_exr(folder / "c.exr", map, {"Y"}, ExrDepth::Float);
  EXPECT_FALSE(probe_image(folder / "c.exr").scale.has_value());
  EXPECT_THROW(write_scaled_exr(folder / "d.exr", map, {0.0, std::numeric_limits<double>::infinity(), ""}),
               InvalidInput);
}

TEST(ImageIo, EveryFormatThatIsWrittenCarriesTheKey) {
  TempFolder folder;
  for (const char* name : {"k.png", "k.jpg", "k.tif", "k.exr", "K.EXR"}) {
    write_color(folder / name, ramp(16, 16, 3), "0123abcd");
    EXPECT_EQ(probe_image(folder / name).key, "0123abcd") << name;
  }
}

TEST(ImageIo, TheExtensionDecidesWhateverItsCase) {
  TempFolder folder;
  write_color(folder / "a.EXR", ramp(4, 4, 3));
  EXPECT_FALSE(probe_image(folder / "a.EXR").is_integer);
  EXPECT_THROW(write_color(folder / "a.hdr", ramp(4, 4, 3)), ParseError);
}

TEST(ImageIo, AlphaDoesNotDarkenColor) {
  TempFolder folder;
  ImageU8 codes(2, 1, 4, 255);
  codes.at(0, 0, 0) = 200;
  codes.at(0, 0, 1) = 100;
  codes.at(0, 0, 2) = 50;
  codes.at(0, 0, 3) = 128;
  write_codes(folder / "a.png", codes);
  const ImageF png = read_color(folder / "a.png", {.kind = Response::Kind::Linear});
  EXPECT_NEAR(png.at(0, 0, 0), 200.0f / 255.0f, 1e-6f);
  EXPECT_NEAR(png.at(0, 0, 2), 50.0f / 255.0f, 1e-6f);
  // EXR stores color times alpha.
  ImageF premultiplied(1, 1, 4, 0.25f);
  premultiplied.at(0, 0, 3) = 0.5f;
  write_exr(folder / "a.exr", premultiplied, {"R", "G", "B", "A"}, ExrDepth::Float);
  EXPECT_FLOAT_EQ(read_color(folder / "a.exr").at(0, 0, 1), 0.5f);
}

TEST(ImageIo, BadFilesAreOneLine) {
  TempFolder folder;
  write_atomically(folder / "empty.png", "");
  write_atomically(folder / "text.png", "this is no image");
  write_srgb8(folder / "good.png", ramp(64, 64, 3));
  const std::string good = read_file(folder / "good.png");
  write_atomically(folder / "cut.png", std::string_view(good).substr(0, good.size() / 2));
  for (const char* name : {"missing.png", "empty.png", "text.png", "cut.png"}) {
    try {
      (void)read_color(folder / name);
      ADD_FAILURE() << name << " was read";
    } catch (const IoError& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
      EXPECT_EQ(std::string(e.what()).find((folder / name).string()), 0u) << e.what();
    }
  }
}

TEST(ImageIo, TruncatedExrIsAnErrorAtEveryLength) {
  TempFolder folder;
  write_exr(folder / "good.exr", ramp(64, 64, 3), {"R", "G", "B"}, ExrDepth::Half);
  const std::string good = read_file(folder / "good.exr");
  for (std::size_t length = 0; length + 64 < good.size(); length += good.size() / 37 + 1) {
    write_atomically(folder / "cut.exr", std::string_view(good).substr(0, length));
    EXPECT_THROW((void)read_color(folder / "cut.exr"), IoError) << length << " of " << good.size();
  }
}

// Noise, of which every byte counts. What follows the pixels may be missing: 64 bytes.
TEST(ImageIo, AFileThatLacksRowsIsAnErrorInEveryFormat) {
  TempFolder folder;
  ImageF noise(64, 200, 3);
  RandomStream random(7, 0);
  for (float& v : noise.values()) v = static_cast<float>(random.uniform());
  for (const char* name : {"a.tif", "a.png", "a.jpg", "a.exr"}) {
    write_color(folder / name, noise);
    const std::string whole = read_file(folder / name);
    (void)read_color(folder / name);
    for (std::size_t length = whole.size() / 29; length + 64 < whole.size(); length += whole.size() / 29) {
      write_atomically(folder / name, std::string_view(whole).substr(0, length));
      EXPECT_THROW((void)read_color(folder / name), IoError) << name << ": " << length << " of " << whole.size();
    }
  }
}

// Cameras pad; the decoder remarks on it, and no pixel is lost.
TEST(ImageIo, AJpegWithBytesBetweenItsMarkersIsReadAsItIs) {
  TempFolder folder;
  write_srgb8(folder / "a.jpg", ramp(32, 32, 3));
  const ImageF expected = read_color(folder / "a.jpg");
  std::string bytes = read_file(folder / "a.jpg");
  bytes.insert(bytes.size() - 2, 5, 'x');  // Before the last marker.
  write_atomically(folder / "a.jpg", bytes);
  const ImageF found = read_color(folder / "a.jpg");
  EXPECT_TRUE(std::equal(found.values().begin(), found.values().end(), expected.values().begin()));
}

/// A PNG of one color, of any size, whose rows are not there: what its header says is all that is looked at.
std::string png_header(std::uint32_t width, std::uint32_t height) {
  const auto u32 = [](std::uint32_t v) {
    return std::string{static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
                       static_cast<char>(v)};
  };
  const auto chunk = [&](const std::string& kind, const std::string& data) {
    std::uint32_t crc = 0xFFFFFFFFu;
    for (unsigned char c : kind + data) {
      crc ^= c;
      for (int k = 0; k < 8; ++k) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xEDB88320u : 0u);
    }
    return u32(static_cast<std::uint32_t>(data.size())) + kind + data + u32(~crc);
  };
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", u32(width) + u32(height) + std::string("\x08\x02\0\0\0", 5)) +
         chunk("IDAT", std::string("\x78\x9c", 2)) + chunk("IEND", "");
}

// 30000 x 30000 x 3 values are 10 GiB as floats. Nothing is allocated for them: the test would be slow, and this one is
// not.
TEST(ImageIo, AnImageThatIsTooLargeToDecodeIsNamedBeforeItIsDecoded) {
  TempFolder folder;
  write_atomically(folder / "bomb.png", png_header(30000, 30000));
  EXPECT_EQ(probe_image(folder / "bomb.png").width, 30000);
  for (const auto& read : std::vector<std::function<void()>>{[&] { (void)read_color(folder / "bomb.png"); },
                                                             [&] { (void)read_gray(folder / "bomb.png"); },
                                                             [&] { (void)read_mask(folder / "bomb.png"); }}) {
    EXPECT_EQ(testing_support::error_of<IoError>(read),
              (folder / "bomb.png").string() +
                  ": is 30000 x 30000 pixels of 3 channels, 10 GiB when decoded; at most 4 GiB can be read at once");
  }
}

TEST(ImageIo, NanIsNeitherWrittenNorRead) {
  TempFolder folder;
  ImageF image = ramp(4, 4, 1);
  image.at(1, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(write_exr(folder / "n.exr", image, {"Y"}, ExrDepth::Float), InvalidInput);
  EXPECT_FALSE(std::filesystem::exists(folder / "n.exr"));
}

TEST(ImageIo, UnwritablePlacesAreCannotComplete) {
  TempFolder folder;
  EXPECT_THROW(write_srgb8(folder / "no/such/a.png", ramp(4, 4, 3)), CannotComplete);
  EXPECT_THROW(write_srgb8(folder / "a.nonsense", ramp(4, 4, 3)), ParseError);
}

TEST(ImageIo, ReadsRealPhotographs) {
  PATINATE_REQUIRE_DATA(file, "timelapse/banana_14_B/14_B_2020-05-28_18-20_U.png");
  const ImageF image = read_color(file);
  EXPECT_EQ(image.width(), 1488);
  EXPECT_EQ(image.height(), 1141);
}

}  // namespace
}  // namespace patinate
