#include "transfer/lookup/packed_lookup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/history/history_sampling.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/support/errors.h"

namespace patinate::transfer {
namespace {

constexpr int kPackedSource = 37;

/// Pieces that continue for a few texels, single texels, and gaps; the width is no multiple of anything.
ImageF pieces() {
  ImageF coordinates(101, 40, 2, -1.0f);
  RandomStream random(11, 0);
  for (int y = 0; y < coordinates.height(); ++y) {
    for (int x = 0; x < coordinates.width();) {
      const int length = 1 + static_cast<int>(random.below(30)), sx = static_cast<int>(random.below(kPackedSource)),
                sy = static_cast<int>(random.below(kPackedSource));
      const bool is_gap = random.below(5) == 0;
      for (int k = 0; k < length && x < coordinates.width(); ++k, ++x) {
        if (is_gap || sx + k >= kPackedSource) continue;
        coordinates.at(x, y, 0) = static_cast<float>(sx + k);
        coordinates.at(x, y, 1) = static_cast<float>(sy);
      }
    }
  }
  return coordinates;
}

TEST(PackedLookup, EqualsTheSimpleOneToTheBit) {
  const ImageF coordinates = pieces();
  const PackedCoordinates indices = pack_coordinates(coordinates, kPackedSource, kPackedSource).pixels;
  for (int channels : {1, 2, 3, 4}) {
    ImageF source(kPackedSource, kPackedSource, channels);
    ImageU8 codes(kPackedSource, kPackedSource, channels);
    for (std::size_t i = 0; i < source.values().size(); ++i) {
      source.data()[i] = static_cast<float>(i) * 0.37f;
      codes.data()[i] = static_cast<std::uint8_t>(i % 251);
    }
    const ImageF expected = gather(source, coordinates, 0.25f);
    EXPECT_EQ(gather_packed(source, indices, 0.25f), expected);
    const ImageU8 found = gather_packed(codes, indices, 9);
    for (int y = 0; y < found.height(); ++y) {
      for (int x = 0; x < found.width(); ++x) {
        const bool is_outside = coordinates.at(x, y, 0) < 0.0f;
        for (int c = 0; c < channels; ++c) {
          const int code = is_outside ? 9
                                      : codes.at(static_cast<int>(coordinates.at(x, y, 0)),
                                                 static_cast<int>(coordinates.at(x, y, 1)), c);
          ASSERT_EQ(found.at(x, y, c), code);
        }
      }
    }
  }
}

TEST(PackedLookup, BetweenPixelsEqualsTheSimpleOneToTheBit) {
  ImageF coordinates = pieces();
  RandomStream random(12, 0);
  for (float& place : coordinates.values()) {
    if (place < 0.0f || random.below(4) == 0) continue;
    place = std::clamp(place + (static_cast<float>(random.below(256)) - 128.0f) / 256.0f, 0.0f, kPackedSource - 1.0f);
  }
  const PackedPlaces places = pack_coordinates(coordinates, kPackedSource, kPackedSource);
  for (int channels : {1, 2, 3, 4}) {
    ImageF source(kPackedSource, kPackedSource, channels);
    for (float& value : source.values()) value = static_cast<float>(random.uniform());
    EXPECT_EQ(gather_packed(source, places, 0.25f), gather(source, coordinates, 0.25f)) << channels;
  }
}

TEST(PackedLookup, NormalsMadeBetweenPixelsAreUnit) {
  const std::vector<std::uint32_t> pixels{3, 3, kNoValue}, beside{pack_beside({40, 0}), pack_beside({0, 0}), kNoValue};
  std::vector<float> xyz{0.0f, 0.3f, 0.4f, 0.0f, 0.3f, 0.4f, 0.0f, 0.0f, 0.0f};
  make_unit_between({pixels, beside}, xyz);
  EXPECT_EQ(xyz, (std::vector<float>{0.0f, 0.6f, 0.8f, 0.0f, 0.3f, 0.4f, 0.0f, 0.0f, 0.0f}));
}

TEST(PackedLookup, EightNeighborsWithoutSourceAreNoPiece) {
  const ImageF source(4, 4, 3, 1.0f);
  EXPECT_EQ(gather_packed(source, PackedCoordinates(16, 1, 1, kNoValue), 0.5f), ImageF(16, 1, 3, 0.5f));
}

TEST(PackedLookup, RefusesOtherChannelsAndSizes) {
  EXPECT_THROW((void)gather_packed(ImageF(2, 2, 5), PackedCoordinates(2, 2)), InvalidInput);
  std::vector<float> out(5);
  EXPECT_THROW(gather_packed(ImageF(2, 2, 3), std::vector<std::uint32_t>{0, 1}, 0.0f, out), InvalidInput);
  EXPECT_THROW((void)pack_coordinates(ImageF(2, 2, 3), 4, 4), InvalidInput);
}

// What a file may hold instead of pixels of the history; each is said with its texel.
// Whoever gives coordinates of their own: nothing is read beside the history.
TEST(PackedLookup, RefusesCoordinatesThatLieBesideTheSource) {
  ImageF coordinates(3, 2, 2, -1.0f);
  coordinates.at(1, 1, 0) = 6.0f;
  coordinates.at(1, 1, 1) = 3.0f;
  EXPECT_EQ(pack_coordinates(coordinates, 7, 4).pixels.at(1, 1), 27u);
  for (const float wrong : {6.25f, 7.0f, 1e9f, -2.0f, std::nanf(""), std::numeric_limits<float>::infinity()}) {
    coordinates.at(1, 1, 0) = wrong;
    const std::string said =
        testing_support::error_of<InvalidInput>([&] { (void)pack_coordinates(coordinates, 7, 4); });
    EXPECT_NE(said.find("texel (1, 1) points"), std::string::npos) << wrong << ": " << said;
  }
}

TEST(PackedLookup, SaysWhichTexelPointsNowhere) {
  const auto message = [](float x, float y) -> std::string {
    const std::vector<float> xy{0.0f, 0.0f, -1.0f, -1.0f, 3.0f, 4.0f, x, y};
    std::vector<std::uint32_t> indices(4);
    try {
      (void)pack_checked_rows("coordinates.exr", xy, 6, 2, 5, 7, indices, {});
    } catch (const IoError& e) {
      return e.what();
    }
    EXPECT_EQ(indices[1], kNoValue);
    EXPECT_EQ(indices[2], 23u);
    return "";
  };
  EXPECT_EQ(message(4.0f, 6.0f), "");
  for (const auto& [x, y] : {std::pair{5.0f, 0.0f},
                             {0.0f, 7.0f},
                             {-1.0f, 0.0f},
                             {0.0f, -1.0f},
                             {-2.0f, -2.0f},
                             {NAN, 0.0f},
                             {0.0f, NAN},
                             {1e30f, 0.0f},
                             {-INFINITY, 1.0f}}) {
    EXPECT_NE(message(x, y).find("texel (1, 7) points outside the history"), std::string::npos) << x << ' ' << y;
  }
  for (const auto& [x, y] : {std::pair{0.5f, 0.0f}, {1.0f, 5.25f}}) {
    EXPECT_NE(message(x, y).find("texel (1, 7) points between the history's pixels"), std::string::npos)
        << x << ' ' << y;
  }
}

}  // namespace
}  // namespace patinate::transfer
