#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "capture/stability/survey.h"
#include "patinate/core/error.h"
#include "tests/capture/stability/stability_scene.h"

namespace patinate::capture {
namespace {

using testing_support::render_scene;
using testing_support::StabilityScene;

PreparedFrame prepared(const StabilityScene& scene) { return prepare_frame(render_scene(scene)); }

Eigen::Affine2d shifted(double x, double y) { return Eigen::Affine2d(Eigen::Translation2d(x, y)); }

TEST(FrameShift, IsFoundBetweenPixelsOnAGrowingSceneUnderAnotherExposure) {
  // Truth: the scene is evaluated at moved positions. 0.05 px is what frame_shift.h promises.
  constexpr double kTolerance = 0.05;
  const PreparedFrame first = prepared({.growth = 0.5});
  for (const auto& [x, y] : {std::pair{0.3, -0.7}, {1.25, 0.0}, {-5.4, 3.6}, {17.8, -21.1}}) {
    const FrameShift shift =
        measure_shift(first, prepared({.growth = 0.55, .exposure = 1.3, .frame_from_scene = shifted(x, y)}));
    EXPECT_NEAR(shift.x, x, kTolerance);
    EXPECT_NEAR(shift.y, y, kTolerance);
    EXPECT_EQ(shift.status, ShiftStatus::Measured);
    EXPECT_GT(shift.agreement, 0.9);
  }
}

TEST(FrameShift, OfSwappedFramesIsTheOpposite) {
  const PreparedFrame a = prepared({}), b = prepared({.frame_from_scene = shifted(2.4, -1.3)});
  const FrameShift there = measure_shift(a, b), back = measure_shift(b, a);
  EXPECT_NEAR(there.x, -back.x, 0.02);
  EXPECT_NEAR(there.y, -back.y, 0.02);
}

TEST(FrameShift, OfAUniformPictureIsNotGuessed) {
  const PreparedFrame flat = prepare_frame(ImageF(64, 64, 3, 0.4f));
  EXPECT_EQ(measure_shift(flat, flat).status, ShiftStatus::NoTexture);
  EXPECT_THROW((void)measure_shift(flat, prepare_frame(ImageF(64, 65, 3, 0.4f))), InvalidInput);
}

TEST(FrameMotion, RecoversATurnAndASize) {
  // Truth as above; corners must land within a tenth of a pixel.
  Eigen::Affine2d truth = Eigen::Affine2d::Identity();
  truth.translate(Eigen::Vector2d(95.5 + 6.0, 95.5 - 9.0))
      .rotate(3.5 * std::numbers::pi / 180.0)
      .scale(1.07)
      .translate(Eigen::Vector2d(-95.5, -95.5));
  const FrameMotion motion =
      measure_motion(prepared({.growth = 0.4}), prepared({.growth = 0.45, .exposure = 0.8, .frame_from_scene = truth}));
  EXPECT_TRUE(motion.is_reliable);
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(191, 0), Eigen::Vector2d(0, 191), Eigen::Vector2d(191, 191)}) {
    EXPECT_LT((motion.frame_from_reference * corner - truth * corner).norm(), 0.1);
  }
}

TEST(Survey, NamesWhatMovedAndWhatWasExposedDifferentlyAndNothingElse) {
  constexpr int kNumFrames = 14;
  std::vector<FramePair> pairs;
  PreparedFrame before;
  for (int i = 0; i < kNumFrames; ++i) {
    StabilityScene scene{.growth = 0.07 * i};
    if (i >= 5) scene.frame_from_scene = shifted(1.8, -0.6);
    if (i == 9) scene.exposure = 1.2;
    PreparedFrame now = prepared(scene);
    if (i > 0) pairs.push_back(compare_frames(i - 1, before, i, now, false));
    before = std::move(now);
  }
  const std::vector<FrameFinding> findings = judge_frames(pairs, 192, 192);
  ASSERT_EQ(findings.size(), 3u);
  EXPECT_EQ(findings[0].frame, 5);
  EXPECT_TRUE(findings[0].is_shifted);
  EXPECT_FALSE(findings[0].is_exposure_changed);
  EXPECT_NEAR(findings[0].shift_x, 1.8, 0.05);
  EXPECT_NEAR(findings[0].shift_y, -0.6, 0.05);
  EXPECT_EQ(finding_text(findings[0]).find("moved by 1.8 px right and 0.6 px up"), 0u) << finding_text(findings[0]);
  EXPECT_EQ(findings[1].frame, 9);
  EXPECT_TRUE(findings[1].is_exposure_changed);
  EXPECT_FALSE(findings[1].is_shifted);
  EXPECT_NEAR(findings[1].gain[0], 1.2, 0.01);
  EXPECT_EQ(findings[2].frame, 10);  // Back to the usual exposure.
}

TEST(Survey, GrowthAloneIsNoShift) {
  PreparedFrame before = prepared({.growth = 0.0});
  for (int i = 1; i <= 5; ++i) {
    PreparedFrame now = prepared({.growth = 0.2 * i});
    const FramePair pair = compare_frames(i - 1, before, i, now, false);
    EXPECT_TRUE(judge_frames({pair}, 192, 192).empty() || !judge_frames({pair}, 192, 192)[0].is_shifted) << i;
    EXPECT_LT(std::hypot(pair.shift.x, pair.shift.y), 0.3) << i;  // Below shift_threshold_px with room to spare.
    before = std::move(now);
  }
}

/// Pairs that lie still and lack so much of their detail.
std::vector<FramePair> pairs_that_lack(const std::vector<double>& lacking) {
  std::vector<FramePair> pairs;
  for (std::size_t i = 0; i < lacking.size(); ++i) {
    FramePair pair;
    pair.reference = static_cast<int>(i);
    pair.frame = static_cast<int>(i) + 1;
    pair.shift.status = ShiftStatus::NotGlobal;
    pair.similarity_before = 1.0 - lacking[i];
    pairs.push_back(pair);
  }
  return pairs;
}

/// What slows down as 1 / t, or falls by a third from one to the next, begins with a change that is many times the
/// usual.
TEST(Survey, SlowingChangeIsNoJumpAtItsBeginningNorQuickeningAtItsEnd) {
  std::vector<double> slowing, falling;
  for (int i = 0; i < 15; ++i) {
    slowing.push_back(0.24 / (i + 1));
    falling.push_back(0.24 * std::pow(0.67, i));
  }
  for (std::vector<double> lacking : {slowing, falling}) {
    EXPECT_TRUE(judge_frames(pairs_that_lack(lacking), 64, 64).empty());
    std::reverse(lacking.begin(), lacking.end());
    EXPECT_TRUE(judge_frames(pairs_that_lack(lacking), 64, 64).empty());
  }
  // An odd first photograph is one all the same: beside change that is even, and twice what it slows down from.
  std::vector<double> even(15, 0.05);
  even[0] = 0.2;
  slowing[0] *= 2.0;
  for (const std::vector<double>& lacking : {even, slowing}) {
    const std::vector<FrameFinding> findings = judge_frames(pairs_that_lack(lacking), 64, 64);
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_TRUE(findings[0].is_jump);
    EXPECT_EQ(findings[0].frame, 1);
  }
}

TEST(Survey, PairsSurviveTheirFile) {
  FramePair pair = compare_frames(3, prepared({}), 4, prepared({.frame_from_scene = shifted(4.0, 1.0)}), false);
  const Json json = pair_to_json(pair);
  const FramePair back = pair_from_json(JsonReader("pairs.json", json));
  EXPECT_EQ(back.reference, 3);
  EXPECT_EQ(back.motion.frame_from_reference.matrix(), pair.motion.frame_from_reference.matrix());
  EXPECT_EQ(back.change.log_gain, pair.change.log_gain);
  EXPECT_EQ(pair_to_json(back), json);
}

}  // namespace
}  // namespace patinate::capture
