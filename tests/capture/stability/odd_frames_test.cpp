#include "capture/stability/odd_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "libcommon/core/random.h"
#include "tests/capture/stability/stability_scene.h"

namespace patinate::capture {
namespace {

using testing_support::render_scene;
using testing_support::StabilityScene;

constexpr int kSceneSide = 192;

struct Judged {
  std::vector<FrameFinding> findings;
  std::vector<FramePair> pairs;  ///< Neighbors, then those across.

  [[nodiscard]] std::vector<int> odd() const {
    std::vector<int> frames;
    for (const FrameFinding& f : findings) {
      if (frames.empty() || frames.back() != f.odd_frame) frames.push_back(f.odd_frame);
    }
    return frames;
  }
};

/// The whole survey, as ingest makes it.
Judged judge(const std::vector<ImageF>& images) {
  std::vector<PreparedFrame> frames;
  for (const ImageF& image : images) frames.push_back(prepare_frame(image));
  const auto compare = [&](int a, int b) { return compare_frames(a, frames[a], b, frames[b], false); };
  Judged judged;
  std::vector<FramePair> across;
  for (int i = 1; i < static_cast<int>(frames.size()); ++i) judged.pairs.push_back(compare(i - 1, i));
  judged.findings = judge_frames(judged.pairs, kSceneSide, kSceneSide);
  for (const FrameRun& run : runs_to_skip(judged.pairs, judged.findings))
    across.push_back(compare(run.first - 1, run.last + 1));
  find_odd_frames(judged.findings, judged.pairs, across, kSceneSide, kSceneSide);
  judged.pairs.insert(judged.pairs.end(), across.begin(), across.end());
  return judged;
}

std::vector<ImageF> growing(int num_frames) {
  static std::vector<ImageF> images;  // A picture takes half a second.
  for (int i = static_cast<int>(images.size()); i < num_frames; ++i)
    images.push_back(render_scene({.growth = 0.04 * i}));
  return {images.begin(), images.begin() + num_frames};
}

/// Another object: blocks of 4 px with random brightness.
ImageF other_object() {
  ImageF out(kSceneSide, kSceneSide, 3);
  for (int y = 0; y < kSceneSide; ++y) {
    for (int x = 0; x < kSceneSide; ++x) {
      RandomStream random(7, static_cast<std::uint64_t>(x / 4), static_cast<std::uint64_t>(y / 4));
      const float value = 0.1f + 0.4f * static_cast<float>(random.uniform());
      for (float& v : out.pixel(x, y)) v = value;
    }
  }
  return out;
}

/// 5 % larger about the middle.
Eigen::Affine2d larger() {
  Eigen::Affine2d motion = Eigen::Affine2d::Identity();
  motion.translate(Eigen::Vector2d(95.5, 95.5)).scale(1.05).translate(Eigen::Vector2d(-95.5, -95.5));
  return motion;
}

std::vector<int> outside(const Judged& judged, int num_frames) {
  return frames_outside(
      group_frames(num_frames, judged.pairs, [](const FramePair& pair) { return !is_unmatched(pair); }));
}

TEST(OddFrames, AFirstFrameOfAnotherSizeAndColorIsBlamedAndNotTheSecond) {
  std::vector<ImageF> images = growing(8);
  images[0] = render_scene({.frame_from_scene = larger()});
  for (std::int64_t i = 0; i < images[0].num_pixels(); ++i) images[0].data()[3 * i + 2] *= 1.8f;
  const Judged judged = judge(images);
  ASSERT_EQ(judged.odd(), std::vector<int>{0});
  EXPECT_NEAR(judged.findings[0].size, 1.05, 0.002) << "as it is seen from the second: within 0.2 px at the border";
  EXPECT_NEAR(judged.findings[0].gain[2], 1.8, 0.02);
  EXPECT_NEAR(judged.findings[0].gain[0], 1.0, 0.02);
  EXPECT_NE(finding_text(judged.findings[0]).find("against the one after it"), std::string::npos);
}

TEST(OddFrames, OneThatIsMovedAndComesBackIsBlamedTwiceAndItsFollowerNever) {
  std::vector<ImageF> images = growing(9);
  images[4] = render_scene({.growth = 0.16, .frame_from_scene = Eigen::Affine2d(Eigen::Translation2d(6.0, -4.0))});
  const Judged judged = judge(images);
  ASSERT_EQ(judged.findings.size(), 2u) << "to it, and back";
  EXPECT_EQ(judged.odd(), std::vector<int>{4});
  EXPECT_NEAR(judged.findings[1].shift_x, 6.0, 0.1) << "the same from either side";
}

TEST(OddFrames, AMoveThereAndBackIsNotBlamedForTheLightOfAnotherFrame) {
  std::vector<ImageF> images = growing(8);
  images[6] = render_scene({.growth = 0.24, .frame_from_scene = Eigen::Affine2d(Eigen::Translation2d(6.0, -4.0))});
  for (float& v : images[7].values()) v *= 1.5f;
  int num_moved = 0, num_exposed = 0;
  for (const FrameFinding& f : judge(images).findings) {
    num_moved += f.is_shifted;
    num_exposed += f.is_exposure_changed;
    EXPECT_TRUE(!f.is_shifted || f.odd_frame == 6);
    EXPECT_TRUE(!f.is_exposure_changed || f.odd_frame == 7);
  }
  EXPECT_EQ(num_moved, 2) << "there, and back";
  EXPECT_EQ(num_exposed, 1);
}

TEST(OddFrames, ACameraThatStaysMovedBlamesTheFirstThatIs) {
  std::vector<ImageF> images;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Affine2d motion(Eigen::Translation2d(i >= 4 ? 6.0 : 0.0, 0.0));
    images.push_back(render_scene({.growth = 0.04 * i, .frame_from_scene = motion}));
  }
  EXPECT_EQ(judge(images).odd(), std::vector<int>{4});
}

TEST(OddFrames, AnotherObjectIsNamedWhereverItStands) {
  for (int at : {0, 3, 7}) {
    std::vector<ImageF> images = growing(8);
    images[at] = other_object();
    const Judged judged = judge(images);
    EXPECT_EQ(judged.odd(), std::vector<int>{at});
    EXPECT_EQ(outside(judged, 8), std::vector<int>{at});
    for (const FrameFinding& f : judged.findings) EXPECT_TRUE(f.is_unmatched);
  }
}

/// Two or three in a row, wherever they stand, and nobody else.
TEST(OddFrames, ARunOfAnotherObjectOfMovedOrBrighterOnesIsNamedWhole) {
  for (const std::vector<int>& run : {std::vector{2, 3}, std::vector{5, 6}, std::vector{3, 4, 5}}) {
    std::vector<ImageF> other = growing(9), moved = other, bright = other;
    for (const int i : run) {
      const std::size_t k = i;
      other[k] = other_object();
      moved[k] =
          render_scene({.growth = 0.04 * i, .frame_from_scene = Eigen::Affine2d(Eigen::Translation2d(6.0, -4.0))});
      for (float& v : bright[k].values()) v *= 1.5f;
    }
    const Judged of_other = judge(other);
    EXPECT_EQ(of_other.odd(), run);
    EXPECT_EQ(outside(of_other, 9), run);
    const Judged of_moved = judge(moved);
    EXPECT_EQ(of_moved.odd(), run);
    for (const FrameFinding& f : of_moved.findings) EXPECT_NEAR(f.shift_x, 6.0, 0.1) << f.odd_frame;
    const Judged of_bright = judge(bright);
    EXPECT_EQ(of_bright.odd(), run);
    for (const FrameFinding& f : of_bright.findings) EXPECT_NEAR(f.gain[1], 1.5, 0.03) << f.odd_frame;
  }
}

/// Frames 4 and 5 are brighter, but only one end of them stands out from the aging around it.
TEST(OddFrames, OneEndOfBrighterOnesIsEnoughWhereTheOtherCancelsIt) {
  for (const int found : {4, 6}) {
    std::vector<FramePair> pairs;
    for (int i = 1; i < 10; ++i) {
      FramePair pair;
      pair.reference = i - 1;
      pair.frame = i;
      pair.change.log_gain.fill(i == 4 ? 0.35 : i == 6 ? -0.3 : 0.02);
      pairs.push_back(pair);
    }
    FrameFinding finding;
    finding.frame = finding.odd_frame = found;
    finding.against = found - 1;
    finding.is_exposure_changed = true;
    finding.gain.fill(std::exp(found == 4 ? 0.35 : -0.3));
    std::vector<FrameFinding> findings{finding};
    find_odd_frames(findings, pairs, {}, kSceneSide, kSceneSide);
    std::set<int> odd;
    for (const FrameFinding& f : findings) {
      odd.insert(f.odd_frame);
      EXPECT_GT(f.gain[1], 1.3) << "brighter, from whichever side it is seen";
    }
    EXPECT_EQ(odd, (std::set<int>{4, 5})) << "and not frame 6";
  }
}

TEST(OddFrames, TwoDifferentObjectsInARowAreBothNamed) {
  std::vector<ImageF> images = growing(8);
  images[3] = other_object();
  images[4] = other_object();
  std::reverse(images[4].values().begin(), images[4].values().end());
  EXPECT_EQ(judge(images).odd(), (std::vector<int>{3, 4}));
}

TEST(OddFrames, AHalfThatStandsElsewhereIsNoMistake) {
  std::vector<ImageF> images;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Affine2d motion(Eigen::Translation2d(i >= 1 && i <= 3 ? 6.0 : 0.0, 0.0));
    images.push_back(render_scene({.growth = 0.04 * i, .frame_from_scene = motion}));
  }
  for (const FrameFinding& f : judge(images).findings) EXPECT_NE(f.odd_frame, 2) << "three of six";
}

TEST(OddFrames, EverySecondOneOfAnotherObjectLeavesTheOthersTogether) {
  std::vector<ImageF> images = growing(7);
  for (std::size_t i : {1u, 3u, 5u}) images[i] = other_object();
  const Judged judged = judge(images);
  EXPECT_EQ(outside(judged, 7), (std::vector<int>{1, 3, 5}));
  EXPECT_EQ(judged.odd(), (std::vector<int>{1, 3, 5}));
}

TEST(OddFrames, GrowthAloneBlamesNobody) {
  const Judged judged = judge(growing(8));
  EXPECT_TRUE(judged.findings.empty());
  EXPECT_TRUE(outside(judged, 8).empty());
}

TEST(OddFrames, FramesThatNothingTiesAreAllOutside) {
  EXPECT_EQ(frames_outside({0, 1, 2}), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(frames_outside({1, 0, 0}), std::vector<int>{0});
  EXPECT_TRUE(frames_outside({0}).empty()) << "one photograph is no series";
}

TEST(OddFrames, SomethingLaidOverAMovedFrameIsStillAJump) {
  std::vector<ImageF> images;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Affine2d motion(Eigen::Translation2d(3.0 * (i % 3), 2.5 * ((i + 1) % 2)));
    images.push_back(render_scene({.growth = 0.04 * i, .frame_from_scene = motion}));
  }
  const ImageF other = other_object();
  for (int y = 48; y < 144; ++y) {  // A quarter of the picture.
    for (int x = 48; x < 144; ++x) {
      for (int c = 0; c < 3; ++c) images[4].at(x, y, c) = other.at(x, y, c);
    }
  }
  for (const FrameFinding& f : judge(images).findings) EXPECT_EQ(f.is_jump, f.frame == 4 || f.frame == 5) << f.frame;
}

}  // namespace
}  // namespace patinate::capture
