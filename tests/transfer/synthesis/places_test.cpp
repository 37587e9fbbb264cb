#include "transfer/synthesis/places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "libcommon/core/random.h"

namespace patinate::transfer {
namespace {

// A place is kept as its pixel and what is left: the same comes back, for widths around powers of two, at both ends of
// a row and of all pixels.
TEST(PlaceMap, GivesPlacesBackAsTheyWere) {
  constexpr std::int32_t kOne = PixelNeighbor::kOne;
  for (const std::int32_t width : {1, 2, 3, 7, 63, 64, 65, 511, 512, 513, 65535, 65537, 3'999'999, kLargestSource_px}) {
    const std::int64_t height =
        std::min<std::int64_t>(kLargestSource_px, std::numeric_limits<std::int32_t>::max() / width);
    PlaceMap places(1, width);
    EXPECT_EQ(places.at(0), Place{}) << "no place yet";
    const auto expect_back = [&](std::int64_t x, std::int64_t y, std::int32_t beside_x, std::int32_t beside_y) {
      const Place place{
          static_cast<std::int32_t>(y * width + x),
          {static_cast<std::int32_t>(x * kOne + beside_x), static_cast<std::int32_t>(y * kOne + beside_y)}};
      places.set(0, place);
      ASSERT_EQ(places.at(0), place) << width << ": " << x << " " << y;
      ASSERT_EQ(places.point(0), place.point);
    };
    for (const std::int64_t x : {0, width / 2, width - 1}) {
      for (const std::int64_t y : {std::int64_t{0}, height / 2, height - 1}) {
        for (std::int32_t beside : {-kOne / 2, -1, 0, 1, kOne / 2 - 1}) expect_back(x, y, beside, -1 - beside);
      }
    }
    RandomStream random(11, static_cast<std::uint64_t>(width));
    const auto below = [&](std::int64_t n) { return random.below(static_cast<std::uint32_t>(n)); };
    for (int i = 0; i < 2000; ++i)
      expect_back(below(width), below(height), static_cast<std::int32_t>(below(kOne)) - kOne / 2,
                  static_cast<std::int32_t>(below(kOne)) - kOne / 2);
  }
}

}  // namespace
}  // namespace patinate::transfer
