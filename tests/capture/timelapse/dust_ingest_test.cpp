// The synthetic dusty urn, whose dust is known, through the whole of ingest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "capture/timelapse/ingest.h"
#include "datasets_synthetic/dust_io.h"
#include "patinate/image/image_io.h"
#include "tests/support/photo_rounding.h"
#include "tests/support/temp_folder.h"

namespace patinate::capture {
namespace {

TEST(IngestSynthetic, DustThatGathersIsAsMuchAsWhatItFollowsSays) {
  for (const auto follows : {datasets::DustFollows::Facing, datasets::DustFollows::Exposure}) {
    const testing_support::TempFolder folder;
    datasets::DustOptions o{.width = 96, .height = 120, .num_frames = 4, .interval_d = 20.0, .follows = follows};
    o.unevenness = o.gloss = o.noise = 0.0;
    (void)run_job(datasets::plan_dust(o, folder / "dust"), {}, {});
    (void)run_job(plan_ingest(read_capture_project(folder / "dust/capture.json"), {}, folder / "history"), {}, {});
    const HistoryReader history(folder / "history");
    const std::string name(datasets::kDustFollowsNames.at(static_cast<std::size_t>(follows)));
    const ControlFacts& facts = history.control(name);
    const ImageF control = history.read_control(name), light = read_gray(folder / "dust/truth/light.exr");
    const ImageU8 mask = history.read_mask();
    const ImageF clean = history.read_frame(0);
    int num_checked = 0;
    for (int i = 1; i < o.num_frames; ++i) {
      const ImageF frame = history.read_frame(i);
      for (int y = 0; y < o.height; ++y) {
        for (int x = 0; x < o.width; ++x) {
          if (mask.at(x, y) == 0) continue;
          // Cover by the photographs: red goes from the glaze's to the dust's, in the same light.
          const double start = static_cast<double>(clean.at(x, y, 0)), now = static_cast<double>(frame.at(x, y, 0));
          const double dust = static_cast<double>(light.at(x, y)) * datasets::kDustAlbedo[0];
          const double found = (now - start) / (dust - start);
          // Cover by the control of the history: grains at random.
          const double value = facts.low + static_cast<double>(control.at(x, y)) * (facts.high - facts.low);
          const double expected = -std::expm1(-o.rate * std::pow(value, o.steepness) * i * o.interval_d);
          const double rounding = testing_support::photo_rounding(now) + testing_support::photo_rounding(start);
          ASSERT_NEAR(found, expected, rounding / (dust - start)) << x << ' ' << y;
          ++num_checked;
        }
      }
    }
    EXPECT_GT(num_checked, 5000);
  }
}

}  // namespace
}  // namespace patinate::capture
