// The synthetic drying patch, whose colors and times are known, through the whole of ingest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/timelapse/ingest.h"
#include "datasets_synthetic/drying_io.h"
#include "patinate/image/image_io.h"
#include "tests/support/photo_rounding.h"
#include "tests/support/temp_folder.h"

namespace patinate::capture {
namespace {

using testing_support::photo_rounding;

HistoryReader ingested(const datasets::DryingOptions& o, const testing_support::TempFolder& folder) {
  (void)run_job(datasets::plan_drying(o, folder / "drying"), {}, {});
  (void)run_job(plan_ingest(read_capture_project(folder / "drying/capture.json"), {}, folder / "history"), {}, {});
  return HistoryReader(folder / "history");
}

datasets::DryingOptions without_noise(datasets::DryingOrder order) {
  return {.width = 120, .height = 96, .order = order, .gloss = 0.0, .noise = 0.0};
}

TEST(IngestSynthetic, DryingStoneHasItsAlbedoToTheRoundingOfPhotographs) {
  for (const auto order : {datasets::DryingOrder::Rim, datasets::DryingOrder::Thickness}) {
    const testing_support::TempFolder folder;
    datasets::DryingOptions o = without_noise(order);
    o.num_frames = 6;
    o.interval_min = 25.0;
    const HistoryReader history = ingested(o, folder);
    const datasets::DryingPatch patch(o);
    for (int i = 0; i < o.num_frames; ++i) {
      const ImageF frame = history.read_frame(i);
      for (int y = 0; y < o.height; ++y) {
        for (int x = 0; x < o.width; ++x) {
          const Vec3 truth = patch.look(x, y, i * o.interval_min).albedo;
          for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(static_cast<double>(frame.at(x, y, c)), truth[c], photo_rounding(truth[c]));
        }
      }
    }
  }
}

TEST(IngestSynthetic, DryingStoneSaysWhenItsFilmWasGone) {
  for (const auto order : {datasets::DryingOrder::Rim, datasets::DryingOrder::Thickness}) {
    const testing_support::TempFolder folder;
    const datasets::DryingOptions o = without_noise(order);
    const HistoryReader history = ingested(o, folder);
    std::vector<ImageF> frames;
    for (int i = 0; i < o.num_frames; ++i) frames.push_back(history.read_frame(i));
    const datasets::DryingPatch patch(o);
    int num_checked = 0;
    for (int y = 0; y < o.height; ++y) {
      for (int x = 0; x < o.width; ++x) {
        const double onset = patch.onset_min(x, y), end = o.duration_min();
        if (!(patch.look(x, y, 0.0).wetness == 1.0) || !(onset + 2.0 * o.pores_min < end)) continue;
        // Green is half way between first and last photograph where wetness is, as both are linear in it.
        const auto green = [&](int i) { return static_cast<double>(frames[i].at(x, y, 1)); };
        const double first = green(0), last = green(o.num_frames - 1), half = 0.5 * (first + last);
        int i = 1;
        while (green(i) < half) ++i;
        const double found = o.interval_min * (i - (green(i) - half) / (green(i) - green(i - 1)));
        const double at_half = 0.5 * (1.0 + std::exp(-(end - onset) / o.pores_min));
        const double truth = onset + o.pores_min * std::log(1.0 / at_half);
        // A chord of exp() over an interval dt is off by dt^2 / (8 pores^2) at most, and the wetness that the interval
        // holds before onset by no more than that chord; three roundings of green, over its whole change, each move
        // the crossing as wetness moves it. Wetness falls by at_half / pores a minute there, by half of that at the end
        // of the interval.
        const double step = o.interval_min / o.pores_min, chord = step * step / 8.0;
        const double rounding = 2.0 * photo_rounding(last) / (last - first);
        ASSERT_NEAR(found, truth, o.pores_min * (chord + rounding) / (at_half * std::exp(-step)));
        ++num_checked;
      }
    }
    EXPECT_GT(num_checked, 2000);
  }
}

TEST(IngestSynthetic, DryingStoneThatDriesEarlierHasMoreProgress) {
  const testing_support::TempFolder folder;
  datasets::DryingOptions o = without_noise(datasets::DryingOrder::Rim);
  o.texture = 0.0;  // One color, so that equal change is equal progress.
  const HistoryReader history = ingested(o, folder);
  const ControlFacts& facts = history.control("progress");
  const ImageF progress = history.read_control("progress");
  const datasets::DryingPatch patch(o);
  // From far inside to the rim along rows. The blur of ingest (1.5 px here, cut at three of it) looks over 5 px: what
  // dries earlier by more than the onsets of 5 px differ must have more progress, up to one code of 255 over the change
  // that counts as aged, which is 0.2 and more of full scale.
  const auto onsets_near = [&](int x, int y) {
    double low = 1e30, high = -1.0;
    for (int j = -5; j <= 5; ++j) {
      for (int i = -5; i <= 5; ++i) {
        low = std::min(low, patch.onset_min(x + i, y + j));
        high = std::max(high, patch.onset_min(x + i, y + j));
      }
    }
    return std::array{low, high};
  };
  int num_pairs = 0;
  for (int y = 30; y < 66; y += 3) {
    for (int x = 12; x < 108; x += 3) {
      for (int other = 12; other < x; other += 3) {
        const auto a = onsets_near(x, y), b = onsets_near(other, y);
        if (!(a[0] >= 0.0) || !(b[0] >= 0.0)) continue;
        const bool is_earlier = a[1] < b[0], is_later = b[1] < a[0];
        if (!is_earlier && !is_later) continue;
        const double more = static_cast<double>(progress.at(x, y)) - static_cast<double>(progress.at(other, y));
        EXPECT_GT((is_earlier ? more : -more) * (facts.high - facts.low), -1.0 / 255.0 / 0.2);
        ++num_pairs;
      }
    }
  }
  EXPECT_GT(num_pairs, 200);
}

}  // namespace
}  // namespace patinate::capture
