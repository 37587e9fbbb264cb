#include "patinate/transfer/time_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "patinate/core/error.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"
#include "transfer/lookup/packed_lookup.h"

namespace patinate::transfer {
namespace {

/// Five frames at times 0 ... 4, and a 32 x 16 atlas whose texel (x, y) shows pixel (x / 2, y) and whose right column
/// is no chart.
class TimeMap : public testing::Test {
 protected:
  void SetUp() override { testing_support::write_history(folder_.path(), 16, 16, 5, testing_support::blotches); }

  static ImageF coordinates() {
    ImageF s(32, 16, 2, -1.0f);
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 31; ++x) {
        s.at(x, y, 0) = static_cast<float>(x / 2);
        s.at(x, y, 1) = static_cast<float>(y);
      }
    }
    return s;
  }
  static PackedPlaces indices() { return pack_coordinates(coordinates(), 16, 16); }
  testing_support::TempFolder folder_;
};

TEST_F(TimeMap, OneTimeEverywhereIsAPlainLookupToTheBit) {
  const HistoryReader history(folder_.path());
  for (Between between : {Between::Blend, Between::Hold, Between::Nearest}) {
    for (double t : {-1.0, 0.0, 1.3, 2.5, 4.0, 9.0}) {
      const ImageF times(32, 16, 1, static_cast<float>(t));
      const auto exact = static_cast<double>(static_cast<float>(t));
      EXPECT_EQ(gather_at_times(history, indices(), times, between),
                gather(sample(history, exact, between), coordinates()))
          << t;
    }
  }
}

TEST_F(TimeMap, BetweenPixelsOneTimeEverywhereIsAPlainLookupToTheBit) {
  const HistoryReader history(folder_.path());
  ImageF between = coordinates();
  for (float& place : between.values()) {
    if (place >= 1.0f && place < 15.0f) place += 0.375f;
  }
  for (double t : {0.0, 1.25, 2.5}) {
    EXPECT_EQ(gather_at_times(history, between, ImageF(32, 16, 1, static_cast<float>(t)), Between::Blend),
              gather(history.sample(t), between))
        << t;
  }
}

TEST_F(TimeMap, EachTexelHasTheColorOfItsOwnTime) {
  const HistoryReader history(folder_.path());
  ImageF times(32, 16, 1);
  for (std::int64_t i = 0; i < times.num_pixels(); ++i) times.data()[i] = static_cast<float>(i % 97) * 0.05f;
  const ImageF result = gather_at_times(history, indices(), times, Between::Blend);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 31; x += 5) {
      const ImageF frame = history.sample(times.at(x, y));
      for (int c = 0; c < 3; ++c) ASSERT_EQ(result.at(x, y, c), frame.at(x / 2, y, c)) << x << ' ' << y;
    }
  }
  EXPECT_EQ(result.at(31, 3, 0), 0.0f);
}

TEST_F(TimeMap, ThreadsDoNotChangeBits) {
  const HistoryReader history(folder_.path());
  ImageF times(32, 16, 1);
  for (std::int64_t i = 0; i < times.num_pixels(); ++i) times.data()[i] = static_cast<float>(i % 89) * 0.04f;
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  EXPECT_EQ(gather_at_times(history, indices(), times, Between::Blend, one),
            gather_at_times(history, indices(), times, Between::Blend, three));
}

TEST_F(TimeMap, FramesThatDoNotFitInMemoryChangeNothing) {
  const HistoryReader history(folder_.path());
  ImageF times(32, 16, 1);
  for (std::int64_t i = 0; i < times.num_pixels(); ++i) times.data()[i] = static_cast<float>(i % 97) * 0.05f - 0.3f;
  constexpr std::int64_t kFrame = 16 * 16 * 4 * sizeof(float);
  for (Between between : {Between::Blend, Between::Hold, Between::Nearest}) {
    const ImageF expected = gather_at_times(history, indices(), times, between);
    for (std::int64_t bytes : {std::int64_t{0}, 2 * kFrame, 3 * kFrame, 4 * kFrame}) {
      EXPECT_EQ(gather_at_times(history, indices(), times, between, {}, {.frame_bytes = bytes}), expected) << bytes;
    }
  }
}

TEST_F(TimeMap, SaysWhichTexelHasNoTime) {
  const HistoryReader history(folder_.path());
  ImageF times(32, 16, 1, 2.0f);
  times.at(31, 4) = NAN;  // No chart.
  EXPECT_NO_THROW((void)gather_at_times(history, indices(), times, Between::Blend));
  times.at(7, 5) = NAN;
  const std::string said =
      testing_support::error_of([&] { (void)gather_at_times(history, indices(), times, Between::Blend); });
  EXPECT_NE(said.find("texel (7, 5)"), std::string::npos) << said;
  times.at(7, 5) = INFINITY;  // After all.
  EXPECT_EQ(gather_at_times(history, indices(), times, Between::Blend).at(7, 5, 1), history.read_frame(4).at(3, 5, 1));
}

TEST_F(TimeMap, RefusesOtherSizesAndTimesThatAreNoNumber) {
  const HistoryReader history(folder_.path());
  EXPECT_THROW((void)gather_at_times(history, indices(), ImageF(31, 16), Between::Blend), InvalidInput);
  EXPECT_THROW((void)gather_at_times(history, indices(), ImageF(32, 16, 1, NAN), Between::Blend), InvalidInput);
}

TEST_F(TimeMap, HoldShowsWhatWasAndNearestWhatIsNearer) {
  const HistoryReader history(folder_.path());
  EXPECT_EQ(sample(history, 1.99, Between::Hold), history.read_frame(1));
  EXPECT_EQ(sample(history, 2.0, Between::Hold), history.read_frame(2));
  EXPECT_EQ(sample(history, 1.49, Between::Nearest), history.read_frame(1));
  EXPECT_EQ(sample(history, 1.5, Between::Nearest), history.read_frame(2));
  EXPECT_EQ(sample(history, 99.0, Between::Nearest), history.read_frame(4));
}

}  // namespace
}  // namespace patinate::transfer
