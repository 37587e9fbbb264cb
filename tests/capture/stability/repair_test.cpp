#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "capture/stability/deflicker.h"
#include "capture/stability/fill.h"
#include "capture/stability/flat_field.h"
#include "capture/stability/highlights.h"
#include "capture/stability/stabilize.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/capture/stability/stability_scene.h"

namespace patinate::capture {
namespace {

using testing_support::render_scene;

FramePair exact_pair(int reference, int frame, const Eigen::Affine2d& motion) {
  FramePair pair;
  pair.reference = reference;
  pair.frame = frame;
  pair.motion = {motion, 0.95, 0.01, true};
  pair.is_motion_measured = true;
  return pair;
}

TEST(Stabilize, AnchorsKeepErrorsFromAddingUpAndAWrongPairFromCounting) {
  // Truth: the camera drifts along a line. Every neighbor is measured 0.1 px too far, every pair with an anchor within
  // 0.01 px.
  constexpr int kNumFrames = 33, kAnchor = 16;
  const auto truth = [](int i) { return Eigen::Affine2d(Eigen::Translation2d(0.5 * i, -0.25 * i)); };
  const auto between = [&](int a, int b, double error) {
    return exact_pair(a, b, Eigen::Translation2d(error, 0.0) * truth(b) * truth(a).inverse());
  };
  std::vector<FramePair> pairs;
  for (int i = 1; i < kNumFrames; ++i) {
    pairs.push_back(between(i - 1, i, i == 7 ? 40.0 : 0.1));
    const int anchor = (i - 1) / kAnchor * kAnchor;
    if (anchor != i - 1) pairs.push_back(between(anchor, i, 0.01));
  }
  const StabilizedMotions solved = solve_motions(kNumFrames, pairs, 256, 256);
  EXPECT_TRUE(solved.unlinked_frames.empty());
  for (int i = 0; i < kNumFrames; ++i) {
    // The chain alone would be 3.2 px off at the end.
    EXPECT_LT((solved.frame_from_first[i].translation() - truth(i).translation()).norm(), 0.35) << i;
  }
}

TEST(Stabilize, SaysWhichFrameNothingTies) {
  FramePair loose = exact_pair(1, 2, Eigen::Affine2d::Identity());
  loose.motion.is_reliable = false;
  const StabilizedMotions solved =
      solve_motions(3, {exact_pair(0, 1, Eigen::Affine2d(Eigen::Translation2d(3.0, 0.0))), loose}, 64, 64);
  EXPECT_EQ(solved.unlinked_frames, std::vector<int>{2});
  ASSERT_EQ(solved.frame_residual_px.size(), 3u);
  EXPECT_EQ(solved.frame_residual_px[2], 0.0) << "no pair of its own counts";
  EXPECT_EQ(solve_motions(3, {loose}, 64, 64).unlinked_frames, (std::vector<int>{0, 1, 2}));
  EXPECT_NEAR(solved.frame_from_first[2].translation().x(), 3.0, 1e-6);
  EXPECT_THROW((void)solve_motions(2, {exact_pair(0, 5, Eigen::Affine2d::Identity())}, 64, 64), InvalidInput);
}

TEST(Stabilize, ResamplingUndoesAKnownMotionAndMarksWhatLeftTheView) {
  const Eigen::Affine2d motion(Eigen::Translation2d(5.5, -3.25));
  const ImageF still = render_scene({}), moved = render_scene({.frame_from_scene = motion});
  ImageU8 valid;
  const ImageF back = resample_frame(moved, motion, 192, 192, valid);
  double worst = 0.0;
  for (int y = 8; y < 184; ++y) {
    for (int x = 8; x < 180; ++x)
      worst = std::max(
          worst, static_cast<double>(std::abs(back.at(x, y) - still.at(x, y))) / static_cast<double>(still.at(x, y)));
  }
  EXPECT_LT(worst, 0.05);           // Discretization: cubics on waves of 6 px and more.
  EXPECT_EQ(valid.at(187, 50), 0);  // 187 + 5.5 > 191.
  EXPECT_EQ(valid.at(185, 50), 255);
  EXPECT_EQ(valid.at(50, 3), 0);  // 3 - 3.25 < 0.
  EXPECT_EQ(valid.at(50, 4), 255);
}

TEST(Stabilize, AWholeStepCopiesValues) {
  const ImageF image = render_scene({});
  ImageU8 valid;
  const ImageF out = resample_frame(image, Eigen::Affine2d(Eigen::Translation2d(7.0, 4.0)), 100, 90, valid);
  for (int y = 0; y < 90; y += 7) EXPECT_EQ(out.at(11, y, 1), image.at(18, y + 4, 1));
}

TEST(Deflicker, KnownGainsAreRecoveredAndATrendStays) {
  // Truth: brightness exp(-0.02 i) (the material darkens by 2 % a frame) times a flicker of 10 %.
  constexpr int kNumFrames = 60;
  std::vector<double> flicker;
  for (int i = 0; i < kNumFrames; ++i)
    flicker.push_back(0.1 * RandomStream(3, static_cast<std::uint64_t>(i), 0).normal());
  std::vector<std::array<double, 3>> gains;
  for (std::size_t i = 1; i < flicker.size(); ++i) {
    const double gain = -0.02 + flicker[i] - flicker[i - 1];
    gains.push_back({gain, gain, -0.02});
  }
  const auto factors = deflicker_factors(gains);
  ASSERT_EQ(factors.size(), flicker.size());
  // Rest of the flicker, beyond its mean over the window: sd 0.1 / sqrt(about 11 frames); 4 sigma.
  double mean = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < flicker.size(); ++i) {
    const double left = std::log(factors[i][0]) + flicker[i];
    mean += left / kNumFrames;
    squares += left * left / kNumFrames;
    EXPECT_NEAR(factors[i][2], 1.0, 1e-9) << "a steady trend is the material's";
  }
  EXPECT_LT(std::sqrt(squares - mean * mean), 0.04);
}

TEST(Deflicker, OneSpoiltPhotographIsMendedAlone) {
  std::vector<std::array<double, 3>> gains(29, {0.01, 0.01, 0.01});
  for (std::size_t c = 0; c < 3; ++c) {
    gains[13][c] += 0.3;
    gains[14][c] -= 0.3;
  }
  const auto factors = deflicker_factors(gains);
  for (std::size_t i = 0; i < factors.size(); ++i)
    EXPECT_NEAR(factors[i][1], i == 14 ? std::exp(-0.3) : 1.0, 1e-3) << i;
  EXPECT_THROW((void)deflicker_factors(gains, {.half_width = 0}), InvalidInput);
}

/// Light of a flash: falls to 0.3 in the corners.
double fall_off(int x, int y) {
  return std::exp(-1.2 * (std::pow(x / 95.5 - 1.0, 2) + std::pow(y / 95.5 - 1.0, 2)) / 2.0);
}

TEST(FlatField, AKnownFallOffIsTakenOutOfATexturedGrowingScene) {
  const auto bare = [](int i) { return render_scene({.growth = 0.1 * i}); };
  const auto frame = [&](int i) {
    ImageF image = bare(i);
    for (int y = 0; y < 192; ++y) {
      for (int x = 0; x < 192; ++x) {
        for (float& v : image.pixel(x, y)) v *= static_cast<float>(fall_off(x, y));
      }
    }
    return image;
  };
  const ImageF gain = estimate_flat_field(6, frame, {});
  // The logarithm of this fall-off is a polynomial, so the gain must differ by just it from that of the same scene in
  // even light.
  const ImageF even = estimate_flat_field(6, bare, {});
  double low = 1e9, high = 0.0;
  for (int y = 0; y < 192; y += 5) {
    for (int x = 0; x < 192; x += 5) {
      const double product = static_cast<double>(gain.at(x, y) / even.at(x, y)) * fall_off(x, y);
      low = std::min(low, product);
      high = std::max(high, product);
    }
  }
  EXPECT_LT(high / low, 1.02) << "the fall-off itself spans 3.3";
}

TEST(FlatField, WhatLiesAroundTheMaskDoesNotCount) {
  // A disk in even light on a table that is brighter on one side.
  ImageU8 mask(192, 192, 1, 0);
  ImageF disk(192, 192, 3);
  for (int y = 0; y < 192; ++y) {
    for (int x = 0; x < 192; ++x) {
      const bool is_inside = std::hypot(x - 95.5, y - 95.5) < 50.0;
      mask.at(x, y) = is_inside ? 255 : 0;
      for (float& v : disk.pixel(x, y)) v = is_inside ? 0.1f : 0.2f + 0.003f * static_cast<float>(x);
    }
  }
  const auto frame = [&](int) { return disk; };
  const ImageF gain = estimate_flat_field(2, frame, mask), over_all = estimate_flat_field(2, frame, {});
  double most = 0.0, most_over_all = 0.0;
  for (std::int64_t i = 0; i < gain.num_pixels(); ++i) {
    EXPECT_NEAR(static_cast<double>(gain.data()[i]), 1.0, 1e-3) << "outside, too: it has the range that it has inside";
    if (mask.data()[i] == 0) continue;
    most = std::max(most, static_cast<double>(gain.data()[i]));
    most_over_all = std::max(most_over_all, static_cast<double>(over_all.data()[i]));
  }
  EXPECT_GT(most_over_all, 1.1) << "the table alone makes a gradient";
  const ImageU8 half(96, 96, 1, 255);
  EXPECT_NO_THROW((void)estimate_flat_field(2, frame, half)) << "a mask has a size of its own";
  EXPECT_THROW((void)estimate_flat_field(2, frame, ImageU8(192, 192, 1, 0)), InvalidInput);
}

TEST(FlatField, APhotographOfAUniformSurfaceBecomesUniformWithItsMean) {
  ImageF light(192, 192, 3);
  double mean = 0.0;
  for (int y = 0; y < 192; ++y) {
    for (int x = 0; x < 192; ++x) {
      for (int c = 0; c < 3; ++c) light.at(x, y, c) = static_cast<float>((0.5 + 0.1 * c) * fall_off(x, y));
      mean += static_cast<double>(light.at(x, y, 1)) / (192.0 * 192.0);
    }
  }
  ImageF flat = light;
  apply_gain(flat, flat_field_from_image(light, {.smoothing_share = 0.0}));
  for (int y = 0; y < 192; y += 17) {
    for (int x = 0; x < 192; x += 13) EXPECT_NEAR(static_cast<double>(flat.at(x, y, 1)), mean, 1e-5);
  }
  EXPECT_THROW((void)flat_field_from_image(ImageF(8, 8, 3)), InvalidInput);
  EXPECT_THROW((void)estimate_flat_field(2, [](int) { return ImageF(32, 32, 3, 1.0f); }, {}), InvalidInput);
}

/// A plate with a flash's streak, and white things of other kinds.
ImageF plate(bool has_streak, double growth) {
  ImageF image = render_scene({.growth = growth});
  for (int y = 0; y < 192; ++y) {
    for (int x = 0; x < 192; ++x) {
      const double streak = has_streak ? 1.6 * std::exp(-0.5 * std::pow((x - 80.0) / 7.0, 2)) : 0.0;
      for (float& v : image.pixel(x, y)) v = std::min(1.0f, v + static_cast<float>(streak));
    }
  }
  return image;
}

TEST(Highlights, AStandingStreakIsFoundAndWhatGrowsIsNot) {
  const ImageU8 found = find_standing_highlight(
      20, [](int i) { return plate(true, 0.05 * i); }, 1.0f);
  for (int y = 4; y < 188; y += 9) {
    for (int x = 72; x <= 88; ++x) EXPECT_EQ(found.at(x, y), 255) << x << " " << y;
    EXPECT_EQ(found.at(40, y), 0);
    EXPECT_EQ(found.at(120, y), 0);
  }
  const ImageU8 none = find_standing_highlight(
      20, [](int i) { return plate(false, 0.05 * i); }, 1.0f);
  EXPECT_TRUE(std::all_of(none.values().begin(), none.values().end(), [](std::uint8_t v) { return v == 0; }));
}

TEST(Highlights, SaturatedSpotsAreFoundAndWideWhiteIsNot) {
  ImageF image(200, 200, 3, 0.3f);
  const auto paint = [&](int x0, int y0, int w, int h) {
    for (int y = y0; y < y0 + h; ++y) {
      for (int x = x0; x < x0 + w; ++x) {
        for (float& v : image.pixel(x, y)) v = 1.0f;
      }
    }
  };
  paint(0, 0, 100, 200);  // A white plate, half of the picture, with a cracked pattern:
  for (int y = 0; y < 200; y += 12) {
    for (int x = 0; x < 100; ++x) image.at(x, y, 0) = image.at(x, y, 1) = image.at(x, y, 2) = 0.2f;
  }
  paint(150, 40, 6, 30);         // A glint.
  image.at(180, 150, 0) = 1.0f;  // A speck, in one channel.
  const ImageU8 found = find_saturated(image, 0.99f);
  EXPECT_EQ(found.at(50, 50), 0);
  EXPECT_EQ(found.at(98, 101), 0);
  EXPECT_EQ(found.at(153, 50), 255);
  EXPECT_EQ(found.at(149, 50), 255) << "light spills over";
  EXPECT_EQ(found.at(180, 150), 255);
  EXPECT_EQ(found.at(181, 150), 0);
}

constexpr std::uint8_t kV = 255, kS = 128, kO = 0;

FillPlan plan_of(const std::vector<std::uint8_t>& course, double longest_gap) {
  std::vector<double> times;
  for (std::size_t i = 0; i < course.size(); ++i) times.push_back(static_cast<double>(i));
  return plan_fill(times, [&](int i) { return ImageU8(1, 1, 1, course[i]); }, {.longest_gap = longest_gap});
}

TEST(Fill, AGapIsFilledOnlyBetweenKnownFramesThatAreClose) {
  EXPECT_EQ(plan_of({kV, kS, kV, kV, kV}, 0.0).inside.at(0, 0), 255) << "one missing frame always is";
  EXPECT_EQ(plan_of({kV, kS, kS, kV, kV}, 0.5).inside.at(0, 0), 0) << "three quarters of the time";
  EXPECT_EQ(plan_of({kV, kS, kS, kV, kV}, 0.75).inside.at(0, 0), 255);
  EXPECT_EQ(plan_of({kS, kV, kV, kV, kV}, 1.0).inside.at(0, 0), 0) << "nothing is known before";
  EXPECT_EQ(plan_of({kV, kV, kV, kO, kO}, 1.0).inside.at(0, 0), 0) << "nothing is known after";
  EXPECT_EQ(plan_of({kV, kS, kV, kO, kO}, 1.0).inside.at(0, 0), 0);
}

TEST(Fill, WhatTurnsWhiteAndStaysSoIsMaterial) {
  const FillPlan plan = plan_of({kV, kV, kS, kS}, 0.0);
  EXPECT_EQ(plan.inside.at(0, 0), 255);
  EXPECT_EQ(plan.white_from.at(0, 0), 2);
  EXPECT_EQ(frame_mask(3, ImageU8(1, 1, 1, kS), plan).at(0, 0), 255);
  EXPECT_EQ(plan_of({kV, kO, kS, kS}, 0.0).inside.at(0, 0), 0) << "it was out of view before: no one saw it grow";
  EXPECT_EQ(plan_of({kS, kS}, 0.0).inside.at(0, 0), 0) << "it always shone";
}

TEST(Fill, ColorIsInterpolatedInTimeFromValidFramesOnly) {
  const std::vector<double> times{0, 1, 2, 10, 11};
  const std::vector<std::uint8_t> course{kV, kS, kS, kV, kV};
  const std::vector<float> color{0.2f, 9.0f, 9.0f, 0.7f, 0.9f};
  const auto validity = [&](int i) { return ImageU8(1, 1, 1, course[i]); };
  const auto frame = [&](int i) { return ImageF(1, 1, 3, color[i]); };
  const FillPlan plan = plan_fill(times, validity, {.longest_gap = 1.0});
  EXPECT_EQ(plan.needs_fill, (std::vector<char>{0, 1, 1, 0, 0}));
  EXPECT_NEAR(fill_frame(1, times, plan, validity, frame).at(0, 0, 2), 0.25f, 1e-6f);
  EXPECT_NEAR(fill_frame(2, times, plan, validity, frame).at(0, 0, 0), 0.3f, 1e-6f);
  EXPECT_EQ(frame_mask(2, validity(2), plan).at(0, 0), 0) << "filled, and said so";
  EXPECT_NEAR(plan.invalid_share, 0.4, 1e-12);
}

}  // namespace
}  // namespace patinate::capture
