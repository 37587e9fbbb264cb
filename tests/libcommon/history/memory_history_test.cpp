#include "patinate/history/memory_history.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "patinate/history/history.h"
#include "patinate/history/history_sampling.h"
#include "patinate/history/write_history.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::error_of;
using testing_support::has;

constexpr int kMemoryWidth = 24, kMemoryHeight = 16, kFrames = 4;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Everything that a history may have.
MemoryHistoryImages full_images() {
  MemoryHistoryImages images =
      testing_support::half_images(kMemoryWidth, kMemoryHeight, kFrames, testing_support::blotches);
  images.texel_size_mm = 0.25;
  images.time_unit = TimeUnit::Days;
  images.mask = ImageU8(kMemoryWidth, kMemoryHeight, 1, 255);
  images.mask.at(3, 4) = 0;
  images.frames[1].mask = ImageU8(kMemoryWidth, kMemoryHeight, 1, 255);
  images.frames[1].mask.at(5, 6) = 0;
  images.frames[2].extras = {{"height", ImageF(kMemoryWidth, kMemoryHeight, 1, 0.125f)},
                             {"specular", ImageF(kMemoryWidth, kMemoryHeight, 2, 0.5f)}};
  images.frames[3].is_extrapolated = true;
  images.maps = {{"height", ImageF(kMemoryWidth, kMemoryHeight, 1, 2.0f)},
                 {"position", ImageF(kMemoryWidth, kMemoryHeight, 3, 1.5f)}};
  return images;
}

// Frames of a folder are half floats, and the images' values are such: both are the same numbers.
TEST(MemoryHistory, AnswersAsTheSameHistoryInAFolder) {
  const testing_support::TempFolder folder;
  const MemoryHistory memory(full_images());
  write_history(folder.path(), memory);
  const HistoryReader disk(folder.path());
  EXPECT_EQ(memory.facts(), disk.facts());
  EXPECT_EQ(memory.times(), (std::vector<double>{0, 1, 4, 9}));
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(memory.read_frame(i), disk.read_frame(i));
    EXPECT_EQ(memory.read_frame_mask(i), disk.read_frame_mask(i));
    for (std::string_view name : kFrameExtraNames)
      EXPECT_EQ(memory.read_frame_extra(i, std::string(name)), disk.read_frame_extra(i, std::string(name))) << name;
  }
  for (const char* name : {"x", "y"}) EXPECT_EQ(memory.read_control(name), disk.read_control(name));
  for (const char* name : {"height", "position"}) EXPECT_EQ(memory.read_map(name), disk.read_map(name));
  EXPECT_EQ(memory.read_mask(), disk.read_mask());
  for (double time : {-1.0, 0.0, 0.3, 1.0, 3.7, 9.0, 99.0}) {
    for (Between between : {Between::Blend, Between::Hold, Between::Nearest})
      EXPECT_EQ(sample(memory, time, between), sample(disk, time, between));
    EXPECT_EQ(memory.locate(time).index, disk.locate(time).index);
    EXPECT_EQ(sample_material_map(memory, MaterialMap::Roughness, time, Between::Blend),
              sample_material_map(disk, MaterialMap::Roughness, time, Between::Blend));
  }
}

TEST(MemoryHistory, OfAFolderHoldsAllOfIt) {
  const testing_support::TempFolder folder;
  write_history(folder.path(), MemoryHistory(full_images()));
  const HistoryReader disk(folder.path());
  const MemoryHistory memory = read_into_memory(disk);
  EXPECT_EQ(memory.facts(), disk.facts());
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(memory.read_frame(i), disk.read_frame(i));
    EXPECT_EQ(memory.read_frame_mask(i), disk.read_frame_mask(i));
  }
  EXPECT_EQ(memory.read_frame_extra(2, "specular"), disk.read_frame_extra(2, "specular"));
  EXPECT_EQ(memory.read_control("x"), disk.read_control("x"));
  EXPECT_EQ(memory.read_map("position"), disk.read_map("position"));
}

TEST(MemoryHistory, SaysWhatItHasNot) {
  const MemoryHistory memory(full_images());
  EXPECT_EQ(error_of([&] { (void)memory.read_frame(kFrames); }), "frame 4: is not in the history; use [0, 3]");
  EXPECT_TRUE(
      has(error_of([&] { (void)memory.read_control("z"); }), "history test: has no control `z`; there is: x, y"));
  EXPECT_EQ(error_of([&] { (void)memory.read_map("normal"); }),
            "history test: has no map `normal`; there is: position, height");
  EXPECT_EQ(error_of([&] { (void)memory.locate(std::numeric_limits<double>::quiet_NaN()); }), "time: is not a number");
}

// Reasons for which a folder is refused, and in the same words where those name no file.
TEST(MemoryHistory, RefusesWhatIsNoHistoryInOneLine) {
  constexpr double kNoTime = std::numeric_limits<double>::infinity();
  using Change = std::function<void(MemoryHistoryImages&)>;
  const std::pair<Change, const char*> cases[] = {
      {[](auto& h) { h.frames.clear(); }, "has no frames; give at least one"},
      {[](auto& h) { h.origin = "found"; }, "unknown origin `found`; use captured, simulated or synthetic"},
      {[](auto& h) { h.frames[0].color = ImageF(); }, "is out of range"},
      {[](auto& h) { h.frames[2].color = ImageF(kMemoryWidth, kMemoryHeight - 1, 3); },
       "frame 2 is 24 x 15 with 3 channels; expected 24 x 16 with 3"},
      {[](auto& h) { h.frames[2].color = ImageF(kMemoryWidth, kMemoryHeight, 4); },
       "frame 2 is 24 x 16 with 4 channels"},
      {[](auto& h) { h.frames[3].color.at(7, 7, 1) = kNan; }, "frame 3 holds nan; expected finite values"},
      {[](auto& h) { h.frames[1].time = kNoTime; }, "frame 1: its time is not a number"},
      {[](auto& h) { h.frames[2].time = 1.0; },
       "frame 2: has time 1, not later than 1, the one before; times must be strictly increasing"},
      {[](auto& h) { h.frames[1].mask = ImageU8(3, 3); }, "mask of frame 1 is 3 x 3"},
      {[](auto& h) { h.frames[2].extras[0].image = ImageF(kMemoryWidth, kMemoryHeight, 2); },
       "frame 2: `height` is 24 x 16 with 2 channels; expected 24 x 16 with 1"},
      {[](auto& h) { h.frames[2].extras[0].name = "gloss"; },
       "`gloss` of a frame: use stddev, specular, normal, height, metalness or tint"},
      {[](auto& h) { h.frames[2].extras[0] = h.frames[2].extras[1]; }, "frame 2: `specular` is given twice"},
      {[](auto& h) { h.controls[0].values.at(2, 2) = 1.5f; },
       "control `x` holds 1.5; a control is normalized to [0, 1]"},
      {[](auto& h) { h.controls[0].values.at(2, 2) = kNan; }, "control `x` holds nan"},
      {[](auto& h) { h.controls[1].values = ImageF(kMemoryHeight, kMemoryWidth); }, "control `y` is 16 x 24"},
      {[](auto& h) { h.controls[1].facts.name = "x"; }, "control `x` is given twice; names must differ"},
      {[](auto& h) { h.controls[1].facts.name = ""; }, "control 1 has the name ``; names consist of letters"},
      {[](auto& h) { h.controls[1].facts.name = "../x"; }, "control 1 has the name `../x`; names consist of letters"},
      {[](auto& h) { h.controls[1].facts.low = 2.0; },
       "control `y` has the range [2, 1]; expected low <= high, both within -1e30 and 1e30"},
      {[](auto& h) { h.controls[1].facts.high = kNoTime; }, "control `y` has the range [0, inf]"},
      {[](auto& h) { h.controls[1].facts.high = 1e31; }, "both within -1e30 and 1e30"},
      {[](auto& h) { h.texel_size_mm = 0.0; }, "texel_size_mm must be within 1e-9 and 1e9"},
      {[](auto& h) { h.frames[1].time = 1e-13; }, "frame 1: has time 1e-13, nearly that of the one before"},
      {[](auto& h) { h.mask = ImageU8(kMemoryWidth, kMemoryHeight); }, "mask is 0 everywhere"},
      {[](auto& h) { h.mask = ImageU8(1, 1, 1, 255); }, "mask is 1 x 1"},
      {[](auto& h) { h.maps[0].name = "depth"; },
       "map `depth`: use position, normal, height, texel_size, specular, metalness or tint"},
      {[](auto& h) { h.maps[0].image.at(0, 0) = kNan; }, "map `height` holds nan"},
      {[](auto& h) { h.parts = {{.name = "one", .x = 0, .width = kMemoryWidth + 1, .height = 1, .key = ""}}; },
       "library: `one` lies outside of the history's 24 x 16 pixels"},
      {[](auto& h) { h.parts = {{.name = "one", .x = 0, .width = 1, .height = 1, .key = ""}}; },
       "library: the control `history`"},
  };
  for (const auto& [change, expected] : cases) {
    MemoryHistoryImages images = full_images();
    change(images);
    const std::string message = error_of([&] { (void)MemoryHistory(images); });
    EXPECT_TRUE(has(message, expected)) << expected << " <- " << message;
    EXPECT_EQ(message.rfind("history test: ", 0), 0u) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace patinate
