#include "transfer/synthesis/amounts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "tests/support/meshes.h"
#include "transfer/synthesis/source_levels.h"

namespace patinate::transfer {
namespace {

constexpr int kHalvesSource = 128, kHalvesSide = 64;

/// A source that is dark in its upper half and bright in its lower one, for all values of the control, and a plane.
struct HalfAndHalf {
  SynthesisLevel level;
  HalfAndHalf() {
    AppearanceImage appearance(kHalvesSource, kHalvesSource, kAppearanceSize);
    ControlImage known(kHalvesSource, kHalvesSource, 1), asked(kHalvesSide, kHalvesSide, 1);
    for (int y = 0; y < kHalvesSource; ++y) {
      for (int x = 0; x < kHalvesSource; ++x) {
        // Of 16 shades; those of the upper half are the lower eight.
        appearance.at(x, y, 0) = static_cast<std::int16_t>(y * 16 / kHalvesSource);
        known.at(x, y) = static_cast<std::uint16_t>(x * kControlSteps / (kHalvesSource - 1));
      }
    }
    for (int i = 0; i < kHalvesSide * kHalvesSide; ++i)
      asked.data()[i] = static_cast<std::uint16_t>(i % kHalvesSide * kControlSteps / (kHalvesSide - 1));
    const Neighborhood neighborhood = Neighborhood::square(1);
    const auto map = std::make_shared<TexelMap>(testing_support::unit_plane(kHalvesSide), kHalvesSide, kHalvesSide);
    level = {make_source_level(std::move(appearance), std::move(known), ImageU8(kHalvesSource, kHalvesSource, 1, 255),
                               10.0, neighborhood),
             make_destination_level(map, std::move(asked), neighborhood, place_source(*map, nullptr, 1.0, 0))};
  }
  /// Every texel takes a pixel of the column that it asks for. @param num_rows  Of the source, from row 2 on.
  [[nodiscard]] PlaceMap places(int num_rows) const {
    PlaceMap made(kHalvesSide * kHalvesSide, kHalvesSource);
    for (TexelId t : level.destination.texels) {
      const int x = 2 + static_cast<int>(t % kHalvesSide) * (kHalvesSource - 4) / kHalvesSide;
      const int y = 2 + static_cast<int>(t / kHalvesSide) * num_rows / kHalvesSide;
      made.set(t, place_of(level.source, y * kHalvesSource + x));
    }
    return made;
  }
  [[nodiscard]] std::int32_t excess(const Amounts& amounts, int y) const {
    const auto target = static_cast<std::uint16_t>(kControlSteps / 2);
    return amounts.excess(std::span(&target, 1), y * kHalvesSource + kHalvesSource / 2);
  }
};

TEST(Amounts, EqualSharesAreNoExcess) {
  const HalfAndHalf task;
  Amounts amounts(task.level.source);
  EXPECT_EQ(task.excess(amounts, 20), 0) << "not measured";
  amounts.measure(task.level.destination, task.places(kHalvesSource - 4), {});
  EXPECT_NEAR(task.excess(amounts, 20), 0, 40);
  EXPECT_NEAR(task.excess(amounts, 100), 0, 40);
}

TEST(Amounts, AMapOfOneHalfHasTwiceItsShareAndNothingOfTheOther) {
  const HalfAndHalf task;
  Amounts amounts(task.level.source);
  amounts.measure(task.level.destination, task.places(kHalvesSource / 2 - 4), {});
  EXPECT_NEAR(task.excess(amounts, 20), 256, 64);  // Rows are counted whole: eight or seven to a look.
  EXPECT_EQ(task.excess(amounts, 100), -256);
}

// A price that does not grow is balanced by what makes the look rare in the first place, and stays wrong by as much.
TEST(Amounts, WhatStaysWrongBecomesDearerUpToAnEnd) {
  const HalfAndHalf task;
  Amounts amounts(task.level.source);
  const auto price = [&](int y) {
    const auto target = static_cast<std::uint16_t>(kControlSteps / 2);
    return amounts.price(std::span(&target, 1), y * kHalvesSource + kHalvesSource / 2);
  };
  EXPECT_EQ(price(20), 0) << "not measured";
  for (int times = 0; times < 6; ++times) {
    amounts.measure(task.level.destination, task.places(kHalvesSource / 2 - 4), {});
    EXPECT_EQ(price(20), std::min(8 * 256, (1 + 2 * times) * task.excess(amounts, 20)));
    EXPECT_EQ(price(100), std::max(-8 * 256, -(1 + 2 * times) * 256));
  }
}

TEST(Amounts, PiecesThatAreThereTwiceAreReusedAndThoseThatAreThereOnceAreNot) {
  const HalfAndHalf task;
  Amounts amounts(task.level.source);
  EXPECT_EQ(amounts.reuse(20 * kHalvesSource + 64), 0) << "not measured";
  // 64 x 64 texels copy every second pixel of 15 rows four or five times: of the 8 x 8 pixels around one, 8 rows of
  // four or five columns, which is two to three copies of all of them.
  amounts.measure(task.level.destination, task.places(15), {});
  EXPECT_GE(amounts.reuse(12 * kHalvesSource + 64), 256);
  EXPECT_LE(amounts.reuse(12 * kHalvesSource + 64), 2 * 256);
  EXPECT_EQ(amounts.reuse(100 * kHalvesSource + 64), 0);
  amounts.measure(task.level.destination, task.places(kHalvesSource - 4), {});
  EXPECT_EQ(amounts.reuse(12 * kHalvesSource + 64), 0) << "a quarter of all pixels is there once";
}

TEST(Amounts, AreTheSameForAnyNumberOfThreads) {
  const HalfAndHalf task;
  Amounts one(task.level.source), three(task.level.source);
  RunControl control;
  control.num_threads = 1;
  one.measure(task.level.destination, task.places(40), control);
  control.num_threads = 3;
  three.measure(task.level.destination, task.places(40), control);
  for (int y = 1; y < kHalvesSource - 1; ++y) EXPECT_EQ(task.excess(one, y), task.excess(three, y));
}

}  // namespace
}  // namespace patinate::transfer
