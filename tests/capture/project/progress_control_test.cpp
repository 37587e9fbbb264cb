#include "capture/project/progress_control.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/history/memory_history.h"
#include "patinate/image/color.h"

namespace patinate::capture {
namespace {

constexpr int kWidth = 64, kHeight = 32, kNumFrames = 21;

/// Columns switch from dark to bright one after another, the right ones first; the lower quarter is a black background.
ImageF switching_frame(int index, double noise) {
  ImageF frame(kWidth, kHeight, 3);
  RandomStream random(5, static_cast<std::uint64_t>(index));
  const double done = static_cast<double>(index) / (kNumFrames - 1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool is_background = y >= 3 * kHeight / 4;
      const bool is_aged = done > 1.0 - (x + 0.5) / kWidth;
      for (int c = 0; c < 3; ++c) {
        const double code = (is_background ? 0.0 : is_aged ? 0.7 : 0.3) + noise * random.normal();
        frame.at(x, y, c) = linear_from_srgb(static_cast<float>(code));
      }
    }
  }
  return frame;
}

std::vector<double> even_times() {
  std::vector<double> times(kNumFrames);
  std::iota(times.begin(), times.end(), 0.0);
  return times;
}

TEST(Progress, IsTheShareOfTimeThatAPixelSpentAged) {
  for (double noise : {0.0, 0.02}) {
    const ProgressMap map = progress_from_history(even_times(), [&](int i) { return switching_frame(i, noise); }, {},
                                                  {.smoothing_px = 1.5});
    // Switched at 1 - x / W of the time, so aged for x / W of it. A frame apart is 1 / 20; a blurred front and noise as
    // much.
    constexpr double kTolerance = 0.1;
    for (int x = 4; x < kWidth - 4; x += 5) {
      EXPECT_NEAR(static_cast<double>(map.values.at(x, 8)), (x + 0.5) / kWidth, kTolerance) << x;
    }
    EXPECT_NEAR(map.changing_share, 0.75, 0.08);
    EXPECT_NEAR(map.aged_change, 0.4 * std::sqrt(3.0), 0.05);
  }
}

TEST(Progress, BackgroundNeitherAgesNorMovesTheRange) {
  const ProgressMap map =
      progress_from_history(even_times(), [&](int i) { return switching_frame(i, 0.005); }, {}, {.smoothing_px = 1.5});
  EXPECT_LT(map.values.at(32, kHeight - 2), 0.05f);
  EXPECT_LT(map.low, 0.12);
  EXPECT_GT(map.high, 0.9);
}

TEST(Progress, AveragesOverTimeNotOverFrames) {
  // Frames crowd at the start: times 0, 1, 2, 3, 100. A pixel that is aged from frame 4 on is aged half of the last
  // interval.
  const std::vector<double> times{0, 1, 2, 3, 100};
  const auto frame = [](int i) { return ImageF(8, 8, 3, i == 4 ? 0.5f : 0.1f); };
  EXPECT_NEAR(progress_from_history(times, frame, {}).values.at(4, 4), 0.485f, 1e-3f);
}

TEST(Progress, OneSpoiltPhotographDoesNotCount) {
  const std::vector<double> times{0, 1, 2, 3, 4, 5};
  const auto good = [](int i) { return ImageF(8, 8, 3, i >= 4 ? 0.5f : 0.1f); };
  const auto spoilt = [&](int i) { return i == 1 ? ImageF(8, 8, 3, 0.9f) : good(i); };
  EXPECT_EQ(progress_from_history(times, good, {}).values, progress_from_history(times, spoilt, {}).values);
}

TEST(Progress, IgnoresWhatLiesOutsideTheMask) {
  ImageU8 mask(kWidth, kHeight, 1, 255);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < 10; ++x) mask.at(x, y) = 0;
  }
  const auto with_border = [&](float value) {
    return progress_from_history(
        even_times(),
        [&](int i) {
          ImageF frame = switching_frame(i, 0.0);
          for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < 10; ++x) frame.at(x, y, 0) = value * static_cast<float>(i);
          }
          return frame;
        },
        mask);
  };
  EXPECT_EQ(with_border(0.0f).values, with_border(0.05f).values);
}

TEST(Progress, IsZeroWhereNothingHappens) {
  const auto still = [](int) { return ImageF(8, 8, 3, 0.25f); };
  for (const std::vector<double>& times : {std::vector<double>{0.0}, std::vector<double>{0.0, 1.0, 2.0}}) {
    const ProgressMap map = progress_from_history(times, still, {});
    EXPECT_EQ(map.values, ImageF(8, 8));
    EXPECT_EQ(map.changing_share, 0.0);
  }
}

TEST(Progress, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto with_threads = [](int n) {
    RunControl control;
    control.num_threads = n;
    return progress_from_history(
               even_times(), [](int i) { return switching_frame(i, 0.02); }, {}, {}, control)
        .values;
  };
  EXPECT_EQ(with_threads(1), with_threads(3));
}

TEST(Progress, RefusesBadInput) {
  const auto frame = [](int) { return ImageF(8, 8, 3, 0.25f); };
  EXPECT_THROW((void)progress_from_history({}, frame, {}), InvalidInput);
  EXPECT_THROW((void)progress_from_history({1, 1}, frame, {}), InvalidInput);
  EXPECT_THROW((void)progress_from_history({0, 1}, frame, ImageU8(8, 8)), InvalidInput);
  EXPECT_THROW((void)progress_from_history({0, 1}, frame, ImageU8(7, 8, 1, 1)), InvalidInput);
  EXPECT_THROW((void)progress_from_history({0, 1}, frame, {}, {.smoothing_px = -1.0}), InvalidInput);
  EXPECT_THROW((void)progress_from_history({0, 1}, [](int i) { return ImageF(8 + i, 8, 3); }, {}), InvalidInput);
}

TEST(Progress, OfAHistoryIsThatOfItsFramesTimesAndMask) {
  MemoryHistoryImages images{.name = "switching", .frames = {}};
  std::vector<double> times;
  for (int i = 0; i < kNumFrames; ++i) {
    times.push_back(0.5 * i * i);
    images.frames.push_back({.time = times.back(), .color = switching_frame(i, 0.005)});
  }
  images.mask = ImageU8(kWidth, kHeight, 1, 255);
  for (int x = 0; x < kWidth; ++x) images.mask.at(x, 0) = 0;
  const ProgressMap made = progress_from_history(MemoryHistory(images)),
                    expected = progress_from_history(
                        times, [](int i) { return switching_frame(i, 0.005); }, images.mask);
  EXPECT_EQ(made.values, expected.values);
  EXPECT_EQ(made.low, expected.low);
  EXPECT_EQ(made.high, expected.high);
}

}  // namespace
}  // namespace patinate::capture
