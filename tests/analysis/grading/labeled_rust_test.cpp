#include "analysis/grading/labeled_rust.h"

#include <gtest/gtest.h>

#include <array>

#include "analysis/grading/rust_map.h"
#include "libcommon/core/random.h"
#include "patinate/metrics/difference.h"
#include "tests/support/errors.h"

namespace patinate::analysis {
namespace {

using testing_support::error_of;
using testing_support::has;

constexpr int kSide = 120;

/// Gray paint with two squares of 20 x 20 of a color, and noise.
ImageF painted(const std::array<double, 3>& lab, bool is_corroded, std::uint64_t seed) {
  const std::array<double, 3> paint = linear_from_lab({70.0, 0.0, 2.0}), mark = linear_from_lab(lab);
  RandomStream random(seed, 0, 0);
  ImageF out(kSide, kSide, 3);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const bool is_mark = is_corroded && y >= 40 && y < 60 && ((x >= 20 && x < 40) || (x >= 80 && x < 100));
      for (std::size_t c = 0; c < 3; ++c)
        out.at(x, y, static_cast<int>(c)) =
            static_cast<float>((is_mark ? mark : paint)[c] + 0.01 * (random.uniform() - 0.5));
    }
  }
  return out;
}

/// The left square is marked.
ImageU8 left_square() {
  ImageU8 labels(kSide, kSide);
  for (int y = 40; y < 60; ++y) {
    for (int x = 20; x < 40; ++x) labels.at(x, y) = 255;
  }
  return labels;
}

TEST(LabeledRust, OfOneSpotFindsTheOthersOfItsColor) {
  // Copper's green, whose hue lies at the end of the circle; cobalt's blue; white rust.
  for (const std::array<double, 3>& lab :
       {std::array{55.0, -22.0, 1.0}, std::array{45.0, 5.0, -30.0}, std::array{90.0, 0.0, 1.0}}) {
    const ImageF before = painted(lab, false, 1), now = painted(lab, true, 2);
    const ImageU8 all(kSide, kSide, 1, 255);
    const auto found = [&](const RustRule& rule) {
      const RustMap map({.num_frames = 2, .color = [&](int t) { return t == 0 ? before : now; }, .mask = all}, rule);
      return map.at(1);
    };
    EXPECT_TRUE(found({}).spots.empty());
    const RustFrame rust = found(labeled_rust_rule({}, before, now, left_square()));
    ASSERT_EQ(rust.spots.size(), 2u) << lab[0];
    for (const RustSpot& spot : rust.spots) EXPECT_NEAR(spot.area_px, 400.0, 0.05 * 400.0) << lab[0];
  }
}

TEST(LabeledRust, RefusesLabelsOfAnotherSizeAndThoseThatMarkTooLittle) {
  const ImageF now = painted({40.0, 20.0, 20.0}, true, 3);
  EXPECT_TRUE(has(error_of([&] { (void)labeled_rust_rule({}, {}, now, ImageU8(4, 4)); }), "have 4 x 4 pixels"));
  EXPECT_TRUE(has(error_of([&] { (void)labeled_rust_rule({}, {}, now, ImageU8(kSide, kSide)); }), "mark 0 pixels"));
}

}  // namespace
}  // namespace patinate::analysis
