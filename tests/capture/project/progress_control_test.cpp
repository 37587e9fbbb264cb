#include "capture/project/progress_control.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "libcommon/core/median.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/history/memory_history.h"
#include "patinate/image/color.h"

namespace patinate::capture {
namespace {

constexpr int kSwitchingWidth = 64, kSwitchingHeight = 32, kNumSwitchingFrames = 21;

/// Columns switch from dark to bright one after another, the right ones first; the lower quarter is a black background.
ImageF switching_frame(int index, double noise) {
  ImageF frame(kSwitchingWidth, kSwitchingHeight, 3);
  RandomStream random(5, static_cast<std::uint64_t>(index));
  const double done = static_cast<double>(index) / (kNumSwitchingFrames - 1);
  for (int y = 0; y < kSwitchingHeight; ++y) {
    for (int x = 0; x < kSwitchingWidth; ++x) {
      const bool is_background = y >= 3 * kSwitchingHeight / 4;
      const bool is_aged = done > 1.0 - (x + 0.5) / kSwitchingWidth;
      for (int c = 0; c < 3; ++c) {
        const double code = (is_background ? 0.0 : is_aged ? 0.7 : 0.3) + noise * random.normal();
        frame.at(x, y, c) = linear_from_srgb(static_cast<float>(code));
      }
    }
  }
  return frame;
}

std::vector<double> even_times() {
  std::vector<double> times(kNumSwitchingFrames);
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
    for (int x = 4; x < kSwitchingWidth - 4; x += 5) {
      EXPECT_NEAR(static_cast<double>(map.values.at(x, 8)), (x + 0.5) / kSwitchingWidth, kTolerance) << x;
    }
    EXPECT_NEAR(map.changing_share, 0.75, 0.08);
    EXPECT_NEAR(map.aged_change, 0.4 * std::sqrt(3.0), 0.05);
  }
}

TEST(Progress, BackgroundNeitherAgesNorMovesTheRange) {
  const ProgressMap map =
      progress_from_history(even_times(), [&](int i) { return switching_frame(i, 0.005); }, {}, {.smoothing_px = 1.5});
  EXPECT_LT(map.values.at(32, kSwitchingHeight - 2), 0.05f);
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
  ImageU8 mask(kSwitchingWidth, kSwitchingHeight, 1, 255);
  for (int y = 0; y < kSwitchingHeight; ++y) {
    for (int x = 0; x < 10; ++x) mask.at(x, y) = 0;
  }
  const auto with_border = [&](float value) {
    return progress_from_history(
        even_times(),
        [&](int i) {
          ImageF frame = switching_frame(i, 0.0);
          for (int y = 0; y < kSwitchingHeight; ++y) {
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
  for (int i = 0; i < kNumSwitchingFrames; ++i) {
    times.push_back(0.5 * i * i);
    images.frames.push_back({.time = times.back(), .color = switching_frame(i, 0.005)});
  }
  images.mask = ImageU8(kSwitchingWidth, kSwitchingHeight, 1, 255);
  for (int x = 0; x < kSwitchingWidth; ++x) images.mask.at(x, 0) = 0;
  const ProgressMap made = progress_from_history(MemoryHistory(images)),
                    expected = progress_from_history(
                        times, [](int i) { return switching_frame(i, 0.005); }, images.mask);
  EXPECT_EQ(made.values, expected.values);
  EXPECT_EQ(made.low, expected.low);
  EXPECT_EQ(made.high, expected.high);
}

/// Columns that fade one after another, at a third of the time each: smooth, so that a frame's noise moves them.
ImageF fading_frame(int index) {
  ImageF frame(96, 48, 3);
  const double time = static_cast<double>(index) / (kNumSwitchingFrames - 1);
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      const double share = std::clamp(1.5 * time - 0.5 * (x + 0.5) / frame.width(), 0.0, 1.0);
      const std::array<double, 3> codes{0.7 - 0.3 * share, 0.5 - 0.2 * share, 0.3 + 0.2 * share};
      for (int c = 0; c < 3; ++c) frame.at(x, y, c) = linear_from_srgb(static_cast<float>(codes[c]));
    }
  }
  return frame;
}

TEST(Progress, StatesHowFarNoiseMovesIt) {
  // 0.8 to 1.25 of the truth is what goals.md asks of stated deviations; both a blur and a reduction on the way.
  constexpr float kNoise = 0.004f;  // A code of 8 bits; bends of the sRGB curve are no matter yet.
  const ImageF deviation(96, 48, 3, kNoise);
  for (double sigma : {1.5, 4.0}) {
    const ProgressOptions options{.smoothing_px = sigma};
    const ProgressMap truth = progress_from_history(even_times(), fading_frame, {}, options);
    std::vector<double> off;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const auto noisy = [&](int i) {
        ImageF frame = fading_frame(i);
        RandomStream random(seed, static_cast<std::uint64_t>(i));
        for (float& v : frame.values()) v += kNoise * static_cast<float>(random.normal());
        return frame;
      };
      const ProgressMap map =
          progress_from_history(even_times(), noisy, {}, options, {}, {.read = [&](int) { return deviation; }});
      ASSERT_TRUE(map.deviation.same_size(map.values));
      // Each map has a D of its own, which is no noise of a place.
      const float scale = static_cast<float>(map.aged_change / truth.aged_change);
      for (int y = 8; y < 40; y += 4) {
        for (int x = 8; x < 88; x += 4)
          off.push_back(std::abs(
              static_cast<double>((scale * map.values.at(x, y) - truth.values.at(x, y)) / map.deviation.at(x, y))));
      }
    }
    const double z = 1.4826 * median(std::move(off));
    EXPECT_GT(z, 0.8) << sigma;
    EXPECT_LT(z, 1.25) << sigma;
  }
}

TEST(Progress, SharedDeviationsDoNotShrinkBySmoothing) {
  const ImageF deviation(96, 48, 3, 0.01f);
  const auto made = [&](bool is_shared) {
    return progress_from_history(even_times(), fading_frame, {}, {.smoothing_px = 3.0}, {},
                                 {.read = [&](int) { return deviation; }, .is_shared = is_shared})
        .deviation.at(48, 24);
  };
  // A Gaussian of 3 px takes noise down by 2 sqrt(pi) 3; edges of the picture and of the steps by a few per cent.
  EXPECT_NEAR(static_cast<double>(made(true) / made(false)), 2.0 * std::sqrt(std::numbers::pi) * 3.0, 1.0);
}

}  // namespace
}  // namespace patinate::capture
