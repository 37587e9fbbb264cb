#include "transfer/synthesis/similar_pixels.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "libcommon/core/random.h"

namespace patinate::transfer {
namespace {

// A picture of noise that repeats every 8 pixels: what looks most like a pixel are its copies, of which more are there
// than are asked for. The slack of the search cannot pass over them: their distance is 0.
TEST(SimilarPixels, OfARepeatingPatternAreItsCopies) {
  constexpr int kSide = 64, kPeriod = 8;
  AppearanceImage appearance(kSide, kSide, kAppearanceSize);
  RandomStream random(5, 5);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      for (int c = 0; c < kAppearanceSize; ++c) {
        appearance.at(x, y, c) = x < kPeriod && y < kPeriod
                                     ? static_cast<std::int16_t>(static_cast<int>(random.below(2000)) - 1000)
                                     : appearance.at(x % kPeriod, y % kPeriod, c);
      }
    }
  }
  const SourceLevel source = make_source_level(appearance, ControlImage(kSide, kSide, 1), ImageU8(kSide, kSide, 1, 255),
                                               20000.0, Neighborhood::square(3));
  const SimilarPixels similar = find_similar_pixels(source);
  ASSERT_EQ(source.usable.size(), 58u * 58u);
  for (const std::int32_t pixel : source.usable) {
    for (const std::int32_t other : similar[pixel]) {
      ASSERT_GE(other, 0) << pixel;
      ASSERT_NE(other, pixel);
      ASSERT_EQ((other % kSide - pixel % kSide) % kPeriod, 0) << pixel << " " << other;
      ASSERT_EQ((other / kSide - pixel / kSide) % kPeriod, 0) << pixel << " " << other;
    }
  }
}

}  // namespace
}  // namespace patinate::transfer
