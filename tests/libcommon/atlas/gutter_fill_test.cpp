#include "libcommon/atlas/gutter_fill.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate {
namespace {

/// Values are the texels' own numbers, at about one in `rarity` texels.
Image<std::uint32_t> scattered(int width, int height, std::uint32_t rarity, std::uint64_t seed) {
  Image<std::uint32_t> values(width, height, 1, kNoValue);
  RandomStream random(seed, 0);
  for (std::size_t i = 0; i < values.values().size(); ++i) {
    if (random.below(rarity) == 0) values.data()[i] = static_cast<std::uint32_t>(i);
  }
  return values;
}

std::int64_t squared_distance(std::uint32_t from, int x, int y, int width) {
  const std::int64_t dx = static_cast<int>(from) % width - x, dy = static_cast<int>(from) / width - y;
  return dx * dx + dy * dy;
}

// Oracle: brute force. Distances are compared, since several texels may be as near.
TEST(GutterFill, FindsTheNearestTexelOfAll) {
  for (const auto& [width, height, rarity] : {std::array{40, 33, 50}, std::array{1, 57, 9}, std::array{64, 1, 9},
                                              std::array{31, 47, 3}, std::array{25, 90, 700}}) {
    const Image<std::uint32_t> values = scattered(width, height, static_cast<std::uint32_t>(rarity), 7);
    Image<std::uint32_t> filled = values;
    fill_gutters(filled);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        std::int64_t nearest = std::int64_t{1} << 60;
        for (std::uint32_t v : values.values()) {
          if (v != kNoValue) nearest = std::min(nearest, squared_distance(v, x, y, width));
        }
        ASSERT_EQ(squared_distance(filled.at(x, y), x, y, width), nearest) << x << ' ' << y;
      }
    }
  }
}

TEST(GutterFill, HeightOfStripsAndThreadsChangeNothing) {
  const Image<std::uint32_t> values = scattered(70, 101, 400, 3);
  Image<std::uint32_t> expected = values;
  fill_gutters(expected);
  for (int rows : {1, 7, 16, 100, 101, 500}) {
    GutterFill gutters(values.width(), values.height(), rows);
    GutterFill::Sweep sweep;
    Image<std::uint32_t> filled = values;
    const auto strip = [&](int s) {
      return std::span(filled.row(gutters.begin(s)).data(),
                       static_cast<std::size_t>(70 * (gutters.end(s) - gutters.begin(s))));
    };
    for (int s = 0; s < gutters.num_strips(); ++s) gutters.look(strip(s));
    RunControl control;
    control.num_threads = rows % 3 + 1;
    for (int s = 0; s < gutters.num_strips(); ++s) gutters.fill(strip(s), sweep, control);
    EXPECT_EQ(filled, expected) << rows;
  }
}

TEST(GutterFill, NothingCoveredStaysSo) {
  Image<std::uint32_t> values(9, 300, 1, kNoValue);
  fill_gutters(values);
  EXPECT_EQ(values, Image<std::uint32_t>(9, 300, 1, kNoValue));
}

TEST(GutterFill, RefusesStripsOutOfTurn) {
  GutterFill gutters(4, 8, 4);
  std::vector<std::uint32_t> strip(16, 1);
  GutterFill::Sweep sweep;
  EXPECT_THROW(gutters.fill(strip, sweep), InvalidInput);
  EXPECT_THROW(gutters.look(std::span(strip).first(8)), InvalidInput);
  EXPECT_THROW(GutterFill(0, 8, 4), InvalidInput);
  EXPECT_THROW(GutterFill(4, 8, 0), InvalidInput);
}

}  // namespace
}  // namespace patinate
