// The card of edge cases, whose courses are known, through the whole of ingest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string_view>

#include "capture/timelapse/ingest.h"
#include "datasets_synthetic/edges.h"
#include "patinate/image/color.h"
#include "tests/support/photo_rounding.h"
#include "tests/support/temp_folder.h"

namespace patinate::capture {
namespace {

using namespace datasets;

constexpr EdgesOptions kCard{.patch_px = 40};

class IngestEdges : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<testing_support::TempFolder>();
    (void)run_job(plan_edges(kCard, *folder_ / "edges"), {}, {});
    (void)run_job(plan_ingest(read_capture_project(*folder_ / "edges/capture.json"), {}, *folder_ / "history"), {}, {});
    history_ = std::make_unique<HistoryReader>(*folder_ / "history");
  }
  static void TearDownTestSuite() {
    history_.reset();
    folder_.reset();
  }
  /// Progress in the middle of a patch, farther from its border than the blur reaches.
  static double progress(std::string_view name) {
    const ControlFacts& facts = history_->control("progress");
    const ImageF values = history_->read_control("progress");
    const auto patch = static_cast<int>(
        std::find_if(kEdgePatches.begin(), kEdgePatches.end(), [&](const EdgePatch& p) { return p.name == name; }) -
        kEdgePatches.begin());
    const int step = 40 + 13, x = 13 + patch % kEdgeColumns * step + 20, y = 13 + patch / kEdgeColumns * step + 20;
    return facts.low + static_cast<double>(values.at(x, y)) * (facts.high - facts.low);
  }

  static std::unique_ptr<testing_support::TempFolder> folder_;
  static std::unique_ptr<HistoryReader> history_;
};
std::unique_ptr<testing_support::TempFolder> IngestEdges::folder_;
std::unique_ptr<HistoryReader> IngestEdges::history_;

TEST_F(IngestEdges, EveryCourseIsKeptToTheRoundingOfPhotographsAtItsTime) {
  ASSERT_EQ(history_->num_frames(), static_cast<int>(kEdgeTimes.size()));
  for (int i = 0; i < history_->num_frames(); ++i) {
    EXPECT_EQ(history_->facts().frames[i].time, kEdgeTimes[i]);
    const ImageF frame = history_->read_frame(i);
    const ImageU8 mask = history_->read_frame_mask(i);
    for (int y = 0; y < edges_side(kCard); ++y) {
      for (int x = 0; x < edges_side(kCard); ++x) {
        if (!mask.empty() && mask.at(x, y) == 0) continue;
        const Vec3 truth = edge_color(kCard, x, y, i);
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(static_cast<double>(frame.at(x, y, c)), truth[c], testing_support::photo_rounding(truth[c]))
              << x << ' ' << y << " at " << i;
      }
    }
  }
}

TEST_F(IngestEdges, WhatIsSaturatedIsNotLookedAtAndTheRestIs) {
  const ImageU8 mask = history_->read_mask();
  int num_saturated = 0;
  for (int y = 0; y < edges_side(kCard); ++y) {
    for (int x = 0; x < edges_side(kCard); ++x) {
      const int patch = edge_patch_at(kCard, x, y);
      const std::string_view name = patch < 0 ? "" : kEdgePatches[patch].name;
      const bool is_corner = x + y < kCard.patch_px / 3;
      // The other photographs show what one spoils.
      const bool is_saturated = name == "white" || name == "red_saturated";
      num_saturated += is_saturated ? 1 : 0;
      // Saturated pixels may take pixels beside them along, which belong to no patch.
      if (patch >= 0 || is_corner) {
        EXPECT_EQ(mask.at(x, y) == 0, is_corner || is_saturated) << x << ' ' << y << ' ' << name;
      }
    }
  }
  EXPECT_EQ(num_saturated, 2 * 40 * 40);
}

TEST_F(IngestEdges, ProgressIsTheShareOfTheTimeThatIsAgedAndNothingElse) {
  // Never: what does not change, and what one photograph alone shows.
  for (const char* name : {"constant", "black", "spoilt_once"})
    EXPECT_LE(progress(name), history_->control("progress").low) << name;
  // Half a code is one code or none after rounding. Of a chess board of which one half changes as the other changes
  // back the blur sees the mean of codes, which is not the code of the mean color. Both over the change that counts as
  // aged, which is that of most patches.
  const auto codes = [](const Vec3& linear) {
    Vec3 out;
    for (int c = 0; c < 3; ++c) out[c] = static_cast<double>(srgb_from_linear(static_cast<float>(linear[c])));
    return out;
  };
  const int even = 13 + 3 * (40 + 13) + 20, row = 13 + 40 + 13 + 20;
  ASSERT_EQ(kEdgePatches[edge_patch_at(kCard, even, row)].name, "even");
  const Vec3 before = edge_color(kCard, even, row, 0), after = edge_color(kCard, even, row, 11);
  const double aged_change = (codes(after) - codes(before)).norm(), code = std::sqrt(3.0) / 255.0;
  const double bent = (codes(0.5 * (before + after)) - 0.5 * (codes(before) + codes(after))).norm();
  EXPECT_LE(progress("faint"), code / aged_change);
  EXPECT_LE(progress("chessboard"), (bent + code) / aged_change);
  // Aged but for the trapezoid of the interval in which it changed: from the first to the second photograph, from 1.5
  // to 10 h, from 99 to 100 h. Inner photographs are medians of three, which leave steps where they are.
  // Both have the same change, whatever counts as aged; half floats of colors are exact to 1 in 2048.
  EXPECT_NEAR(progress("step") / progress("step_first"), (1.0 - 5.75 / 100.0) / (1.0 - 0.005 / 100.0), 1.0 / 2048.0);
  EXPECT_GT(progress("step_first"), progress("soon"));
  EXPECT_GT(progress("soon"), progress("step"));
  EXPECT_GT(progress("step"), progress("even"));
  EXPECT_GT(progress("even"), progress("late"));
  EXPECT_GT(progress("late"), progress("step_last"));
}

}  // namespace
}  // namespace patinate::capture
