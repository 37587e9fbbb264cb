#include "libcommon/history/frame_locator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libcommon/core/random.h"
#include "libcommon/history/history_times.h"
#include "patinate/history/history.h"
#include "patinate/history/history_sampling.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

/// A history of pixels that nobody looks at.
HistoryReader history_at(const std::filesystem::path& folder, const std::vector<double>& times) {
  HistoryManifest manifest;
  manifest.name = "stamps";
  manifest.origin = "synthetic";
  manifest.width = manifest.height = 1;
  HistoryWriter writer(folder, manifest);
  for (std::size_t i = 0; i < times.size(); ++i) writer.write_frame(static_cast<int>(i), times[i], ImageF(1, 1, 3));
  writer.finish();
  return HistoryReader(folder);
}

// Oracle: the binary search of HistoryReader::locate(); equal to the bit at stamps, just beside them, between and
// beyond them.
TEST(FrameLocator, EqualsTheSearchForUnevenStamps) {
  const std::vector<std::vector<double>> stamps{{3.0},
                                                {0.0, 1.0, 2.0, 3.0},
                                                {-5.0, 0.0, 1e-5, 2e-5, 7.0, 1e6},
                                                {0.1, 0.2, 0.30000000000000004, 0.7, 1.9, 2.0, 2.1},
                                                {0.0, kMinTimeStep},
                                                {-kFarthestTime, 0.0, kFarthestTime}};
  for (const std::vector<double>& times : stamps) {
    const testing_support::TempFolder folder;
    const HistoryReader history = history_at(folder.path(), times);
    std::vector<double> asked{-HUGE_VAL, HUGE_VAL, 0.0};
    for (double t : times) {
      for (double beside : {t, std::nextafter(t, HUGE_VAL), std::nextafter(t, -HUGE_VAL)}) asked.push_back(beside);
    }
    RandomStream random(2, 0);
    for (int i = 0; i < 2000; ++i)
      asked.push_back(times.front() + (times.back() * 0.5 - times.front() * 0.5) * 2.2 * random.uniform() - 0.1);
    for (Between between : {Between::Blend, Between::Hold, Between::Nearest}) {
      const FrameLocator locator(history.times(), between);
      for (double t : asked) {
        const TimePosition expected = locate(history, t, between);
        for (int hint = 0; hint < history.num_frames(); ++hint) {
          const TimePosition found = locator(t, hint);
          ASSERT_EQ(found.index, expected.index) << t;
          ASSERT_EQ(found.fraction, expected.fraction) << t;
        }
      }
    }
  }
}

}  // namespace
}  // namespace patinate
