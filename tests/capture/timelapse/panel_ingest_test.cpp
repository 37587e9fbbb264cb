// The synthetic coated panel, whose color, gloss and scale are known, through the whole of ingest.
#include <gtest/gtest.h>

#include "capture/timelapse/ingest.h"
#include "datasets_synthetic/panel_io.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/history/history_sampling.h"
#include "tests/support/temp_folder.h"

namespace patinate::capture {
namespace {

TEST(IngestSynthetic, CoatedPanelHasItsHoursItsScaleAndItsPaint) {
  const testing_support::TempFolder folder;
  const datasets::PanelOptions o{
      .width = 160, .height = 120, .num_frames = 5, .edge_mm = 2.0, .rust = 0.0, .noise = 0.0};
  (void)run_job(datasets::plan_panel(o, folder / "panel"), {}, {});
  (void)run_job(plan_ingest(read_capture_project(folder / "panel/capture.json"), {}, folder / "history"), {}, {});
  const HistoryReader history(folder / "history");
  EXPECT_EQ(history.manifest().texel_size_mm, 0.1);
  EXPECT_EQ(history.manifest().time_unit, TimeUnit::Hours);
  ASSERT_EQ(history.manifest().frames.size(), 5U);
  EXPECT_EQ(history.manifest().frames.back().time, 480.0);
  const auto roughness = [&](double time) {
    return sample_material_map(history, MaterialMap::Roughness, time, Between::Blend).at(80, 60);
  };
  EXPECT_NEAR(roughness(0.0), o.roughness, o.roughness / 2048.0);  // Half floats.
  EXPECT_NEAR(roughness(240.0), 0.5 * (o.roughness + o.roughness_end), o.roughness_end / 2048.0);
  const datasets::Panel panel = datasets::make_panel(o);
  for (int i = 0; i < o.num_frames; ++i) {
    const ImageF frame = history.read_frame(i);
    Vec3 sum = Vec3::Zero();
    double count = 0.0;
    for (int y = 0; y < o.height; ++y) {
      for (int x = 0; x < o.width; ++x) {
        if (panel.test_area.at(x, y) == 0.0f) continue;
        for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(frame.at(x, y, c));
        count += 1.0;
      }
    }
    const std::array<double, 3> lab = lab_from_linear(sum[0] / count, sum[1] / count, sum[2] / count);
    // 9,600 codes are rounded, then half floats: 0.02 of a code in the mean, the blur over the border less than that.
    const std::array<double, 3>& truth = panel.frames[static_cast<std::size_t>(i)].figures.paint;
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(lab[c], truth[c], 0.1);
  }
}

}  // namespace
}  // namespace patinate::capture
