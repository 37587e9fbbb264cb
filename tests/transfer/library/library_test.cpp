#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "patinate/image/image_io.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"
#include "transfer/library/library_job.h"

namespace patinate::transfer {
namespace {

namespace fs = std::filesystem;
using testing_support::TempFolder;

float sand(int x, int y, int frame, int channel) {
  return 0.1f + 0.02f * static_cast<float>((3 * x + 5 * y) % 17) + 0.05f * static_cast<float>(frame) +
         0.1f * static_cast<float>(channel);
}

/// A history of `times.size()` frames whose manifest is changed before it is written again.
fs::path make_history(const fs::path& folder, int width, int height, const std::vector<double>& times,
                      const std::function<float(int, int, int, int)>& color,
                      const std::function<void(HistoryManifest&)>& change = {}) {
  testing_support::write_history(folder, width, height, static_cast<int>(times.size()), color);
  HistoryManifest m = read_history_manifest(folder);
  m.name = folder.filename().string();
  m.key = "key of " + m.name;
  for (std::size_t i = 0; i < times.size(); ++i) m.frames[i].time = times[i];
  if (change) change(m);
  write_history_manifest(folder / kHistoryManifestFile, m);
  return folder;
}

HistoryReader combine(const fs::path& output, const std::vector<fs::path>& histories,
                      const LibraryOptions& options = {}, const std::vector<LibraryControl>& controls = {}) {
  EXPECT_EQ(run_job(plan_library(open_library({histories, controls, options}), output), {}, {}), JobStatus::Done);
  return HistoryReader(output);
}

/// Largest difference between a part of a library's image and the image of that history.
double difference(const ImageF& library, const LibraryPart& part, const ImageF& own) {
  double largest = 0.0;
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      for (int c = 0; c < own.channels(); ++c)
        largest = std::max(largest, std::abs(static_cast<double>(library.at(part.x + x, y, c)) -
                                             static_cast<double>(own.at(x, y, c))));
    }
  }
  return largest;
}

class Library : public testing::Test {
 protected:
  TempFolder folder_;
  fs::path one_ = make_history(folder_ / "one", 40, 24, {0, 1, 4, 6}, testing_support::blotches);
  fs::path two_ = make_history(folder_ / "two", 21, 33, {1, 2.5, 9}, sand);
};

TEST_F(Library, HoldsEveryHistoryBitForBitAtItsOwnTimes) {
  const HistoryReader library = combine(folder_ / "library", {one_, two_});
  const std::vector<LibraryPart> parts = library.facts().parts;
  ASSERT_EQ(parts.size(), 2u);
  for (std::size_t p = 0; p < 2; ++p) {
    const HistoryReader own(p == 0 ? one_ : two_);
    for (int i = 0; i < own.num_frames(); ++i) {
      EXPECT_EQ(difference(library.sample(own.manifest().frames[i].time), parts[p], own.read_frame(i)), 0.0)
          << p << " frame " << i;
    }
  }
}

TEST_F(Library, HasAFrameAtEveryTimeOfAnyHistory) {
  const HistoryReader library = combine(folder_ / "library", {one_, two_});
  std::vector<double> times;
  for (const HistoryFrame& frame : library.manifest().frames) times.push_back(frame.time);
  EXPECT_EQ(times, (std::vector<double>{0, 1, 2.5, 4, 6, 9}));  // 1 is a time of both.
}

// Stored as half floats: 2^-11 of values below 1.
constexpr double kHalf = 5e-4;

TEST_F(Library, ShowsEveryHistoryAtAnyTimeAsItIsItself) {
  const HistoryReader library = combine(folder_ / "library", {one_, two_}), one(one_), two(two_);
  for (double time : {-1.0, 0.3, 1.7, 3.0, 5.5, 7.0, 20.0}) {
    const ImageF image = library.sample(time);
    EXPECT_LE(difference(image, library.facts().parts[0], one.sample(time)), kHalf) << time;
    EXPECT_LE(difference(image, library.facts().parts[1], two.sample(time)), kHalf) << time;
  }
}

TEST_F(Library, MapsSpansOntoTheFirst) {
  const HistoryReader library = combine(folder_ / "library", {one_, two_}, {.clock = LibraryClock::Span}), one(one_),
                      two(two_);
  for (double share : {0.0, 0.1875, 0.4, 1.0}) {  // 0.1875: of the second frame of two, 1 + 8 x 0.1875 = 2.5.
    const ImageF image = library.sample(6.0 * share);
    EXPECT_LE(difference(image, library.facts().parts[0], one.sample(6.0 * share)), kHalf) << share;
    EXPECT_LE(difference(image, library.facts().parts[1], two.sample(1.0 + 8.0 * share)), kHalf) << share;
  }
  EXPECT_EQ(difference(library.sample(6.0 * 0.1875), library.facts().parts[1], two.read_frame(1)), 0.0);
}

TEST_F(Library, TimesOfAnotherUnitAreOfTheFirst) {
  const fs::path hours = make_history(folder_ / "hours", 16, 16, {0.0, 0.1, 0.2}, sand,
                                      [](HistoryManifest& m) { m.time_unit = TimeUnit::Hours; });
  const fs::path minutes = make_history(folder_ / "minutes", 16, 16, {0.0, 6.0, 12.0}, sand,
                                        [](HistoryManifest& m) { m.time_unit = TimeUnit::Minutes; });
  const HistoryReader library = combine(folder_ / "library", {minutes, hours});
  ASSERT_EQ(library.num_frames(), 3);  // 0.1 h is 6 min, although 0.1 * 3600 / 60 is not to the last bit.
  EXPECT_EQ(library.manifest().frames[1].time, 6.0);
}

TEST_F(Library, MasksAreThoseOfItsHistoriesAndNothingBeside) {
  ImageU8 hole(40, 24, 1, 255);
  hole.at(7, 3) = 0;
  write_codes(one_ / "mask.png", hole);
  HistoryManifest m = read_history_manifest(one_);
  m.mask = "mask.png";
  write_history_manifest(one_ / kHistoryManifestFile, m);
  fs::create_directory(two_ / "masks");
  ImageU8 spot(21, 33, 1, 255);
  spot.at(20, 32) = 0;
  write_codes(two_ / "masks/0001.png", spot);
  m = read_history_manifest(two_);
  m.frames[1].mask = "masks/0001.png";
  write_history_manifest(two_ / kHistoryManifestFile, m);

  const HistoryReader library = combine(folder_ / "library", {one_, two_});
  const ImageU8 mask = library.read_mask();
  EXPECT_EQ(std::count(mask.values().begin(), mask.values().end(), 255), 40 * 24 - 1 + 21 * 33);
  const LibraryPart part = library.facts().parts[1];
  EXPECT_EQ(part.x % kLibraryGutter_px, 0);
  EXPECT_GE(part.x, 40 + kLibraryGutter_px);
  EXPECT_EQ(mask.at(7, 3), 0);
  EXPECT_EQ(mask.at(part.x - 1, 0), 0);
  EXPECT_EQ(mask.at(part.x, 32), 255);
  // Frames 0 to 5 are at 0, 1, 2.5, 4, 6, 9: the second history's frame at 2.5, and what is blended with it.
  for (int frame = 0; frame < 6; ++frame)
    EXPECT_EQ(library.read_frame_mask(frame).at(part.x + 20, 32), frame >= 2 && frame <= 4 ? 0 : 255) << frame;
}

TEST_F(Library, ControlsOfOneUnitGetOneRange) {
  const HistoryReader library = combine(folder_ / "library", {one_, two_});
  const ControlFacts& y = library.control("y");  // 0 to 23 px, and 0 to 32.
  EXPECT_EQ(y.low, 0.0);
  EXPECT_EQ(y.high, 32.0);
  EXPECT_EQ(y.unit, "px");
  const ImageF values = library.read_control("y"), which = library.read_control(kLibraryControl);
  for (const LibraryPart& part : library.facts().parts) {
    for (int row = 0; row < part.height; ++row)
      EXPECT_NEAR(32.0 * static_cast<double>(values.at(part.x, row)), row, 1e-5);
  }
  EXPECT_EQ(library.control(kLibraryControl).high, 1.0);
  EXPECT_EQ(which.at(39, 0), 0.0f);
  EXPECT_EQ(which.at(library.facts().parts[1].x, 0), 1.0f);
}

TEST_F(Library, ControlsOfOtherNamesAndUnitsCanBePaired) {
  const fs::path depth = make_history(folder_ / "depth", 16, 16, {0, 1}, sand, [](HistoryManifest& m) {
    m.controls[0].name = "depth";
    m.controls[0].unit = "mm";
  });
  const std::shared_ptr<const OpenLibrary> opened =
      open_library({{one_, depth}, {{.name = "age", .sources = {"x", "depth"}}}, {}});
  ASSERT_EQ(opened->layout.controls.size(), 2u);
  EXPECT_EQ(opened->layout.controls[0].name, "age");
  EXPECT_EQ(opened->layout.controls[0].unit, "relative");
  EXPECT_EQ(opened->layout.controls[1].name, "y");
  const HistoryReader library =
      combine(folder_ / "library", {one_, depth}, {}, {{.name = "age", .sources = {"x", "depth"}}});
  const ImageF age = library.read_control("age");
  EXPECT_EQ(difference(age, library.facts().parts[0], HistoryReader(one_).read_control("x")), 0.0);
  EXPECT_EQ(difference(age, library.facts().parts[1], HistoryReader(depth).read_control("depth")), 0.0);
}

TEST_F(Library, AControlThatOneHistoryLacksIsLeftOutAndSaid) {
  const fs::path bare =
      make_history(folder_ / "bare", 16, 16, {0, 1}, sand, [](HistoryManifest& m) { m.controls.pop_back(); });
  const std::shared_ptr<const OpenLibrary> opened = open_library({{one_, bare}});
  ASSERT_EQ(opened->layout.controls.size(), 1u);
  EXPECT_EQ(opened->layout.controls[0].name, "x");
  EXPECT_TRUE(std::any_of(opened->layout.notes.begin(), opened->layout.notes.end(), [](const std::string& note) {
    return testing_support::has(note, "`y` is excluded") && testing_support::has(note, "bare");
  }));
}

TEST_F(Library, CoarserPixelsBecomeThoseOfTheFinest) {
  const auto fine =
      make_history(folder_ / "fine", 32, 16, {0, 1}, sand, [](HistoryManifest& m) { m.texel_size_mm = 0.25; });
  const auto coarse = make_history(
      folder_ / "coarse", 20, 10, {0, 1}, [](int x, int, int, int) { return 0.01f * static_cast<float>(x); },
      [](HistoryManifest& m) { m.texel_size_mm = 0.5; });
  const HistoryReader library = combine(folder_ / "library", {coarse, fine});
  EXPECT_EQ(library.manifest().texel_size_mm, 0.25);
  const LibraryPart part = library.facts().parts[0];
  EXPECT_EQ(part.width, 40);
  EXPECT_EQ(part.height, 20);
  const ImageF frame = library.read_frame(0);
  EXPECT_EQ(difference(frame, library.facts().parts[1], HistoryReader(fine).read_frame(0)), 0.0);
  // A ramp stays a ramp: pixel x lies over (x + 0.5) / 2 - 0.5 of the coarse ones.
  for (int x = 1; x < 39; ++x) EXPECT_NEAR(frame.at(x, 4), 0.01 * ((x + 0.5) / 2.0 - 0.5), kHalf) << x;
  const HistoryReader small = combine(folder_ / "small", {coarse, fine}, {.texel_size_mm = 1.0});
  EXPECT_EQ(small.facts().parts[1].width, 8);
}

TEST_F(Library, NormalsAndGlossGoAlong) {
  HistoryManifest m = read_history_manifest(two_);
  for (int i = 0; i < 3; ++i) {
    ImageF normal(21, 33, 3), gloss(21, 33, 2);
    for (int y = 0; y < 33; ++y) {
      for (int x = 0; x < 21; ++x) {
        normal.at(x, y, 0) = 0.6f;
        normal.at(x, y, 2) = 0.8f;
        gloss.at(x, y, 0) = 0.25f * static_cast<float>(i + 1);
        gloss.at(x, y, 1) = 0.5f;
      }
    }
    HistoryWriter::write_frame_extra(two_, i, "normal", normal);
    HistoryWriter::write_frame_extra(two_, i, "specular", gloss);
    m.frames[i].extras = {{"specular", HistoryWriter::frame_extra_file(i, "specular")},
                          {"normal", HistoryWriter::frame_extra_file(i, "normal")}};
  }
  write_history_manifest(two_ / kHistoryManifestFile, m);
  const HistoryReader library = combine(folder_ / "library", {one_, two_});
  const int x = library.facts().parts[1].x + 3;
  const ImageF normal = *library.read_frame_extra(2, "normal"), gloss = *library.read_frame_extra(1, "specular");
  EXPECT_NEAR(normal.at(x, 3, 0), 0.6, 1e-6);
  EXPECT_NEAR(normal.at(3, 3, 2), 1.0, 1e-6);  // The other history stands upright.
  EXPECT_EQ(gloss.at(x, 3, 0), 0.25f);
  EXPECT_EQ(gloss.at(3, 3, 0), 0.0f);  // Not known.
}

TEST_F(Library, WhatCannotBeCombinedIsSaid) {
  using testing_support::error_of;
  using testing_support::has;
  const auto problem = [](const LibraryTask& task) { return error_of([&] { (void)open_library(task); }); };
  EXPECT_TRUE(has(problem({{one_}}), "at least two"));
  const fs::path sized =
      make_history(folder_ / "sized", 16, 16, {0, 1}, sand, [](HistoryManifest& m) { m.texel_size_mm = 0.5; });
  EXPECT_TRUE(has(problem({{sized, one_}}), "one: has no texel_size_mm"));
  EXPECT_EQ(problem({{sized, one_}, {}, {.texel_size_mm = 0.5}}), "");
  EXPECT_TRUE(has(problem({{sized, sized}, {}, {.texel_size_mm = 1e-9}}), "use 1 to 65536"));
  (void)combine(folder_ / "library", {one_, two_});
  EXPECT_TRUE(has(problem({{folder_ / "library", one_}}), "is a library already"));
  EXPECT_TRUE(has(problem({{one_, two_}, {{.name = "age", .sources = {"x", "z"}}}}), "two: has no control `z`"));
  EXPECT_TRUE(has(problem({{one_, two_}, {{.name = "age", .sources = {"x"}}}}), "give one each"));
  EXPECT_TRUE(has(problem({{one_, two_}, {{.name = kLibraryControl, .sources = {"x", "x"}}}}), "use another name"));
  const fs::path taken = make_history(folder_ / "taken", 16, 16, {0, 1}, sand,
                                      [](HistoryManifest& m) { m.controls[0].name = kLibraryControl; });
  EXPECT_TRUE(has(problem({{one_, taken}}), "taken: has a control named `history`"));
  const fs::path still = make_history(folder_ / "still", 16, 16, {3}, sand);
  EXPECT_TRUE(has(problem({{still, one_}, {}, {.clock = LibraryClock::Span}}), "still: has one frame"));
  EXPECT_EQ(problem({{one_, still}, {}, {.clock = LibraryClock::Span}}), "");
}

TEST_F(Library, AManifestWhosePartsDoNotFitIsRefused) {
  const HistoryReader library = combine(folder_ / "library", {one_, two_});
  const auto problem = [&](const std::function<void(HistoryManifest&)>& change) {
    HistoryManifest m = library.manifest();
    change(m);
    return testing_support::error_of([&] { write_history_manifest(folder_ / "other.json", m); });
  };
  EXPECT_EQ(problem([](auto&) {}), "");
  EXPECT_TRUE(testing_support::has(problem([](auto& m) { m.parts[1].x = 39; }), "over the one before"));
  EXPECT_TRUE(testing_support::has(problem([](auto& m) { m.parts[1].width = 22; }), "lies outside"));
  EXPECT_TRUE(testing_support::has(problem([](auto& m) { m.controls.pop_back(); }), "is missing"));
}

TEST_F(Library, TheSameHistoriesAreUpToDateAndAnotherOrderIsNot) {
  (void)combine(folder_ / "library", {one_, two_});
  EXPECT_EQ(run_job(plan_library(open_library({{one_, two_}}), folder_ / "library"), {}, {}), JobStatus::UpToDate);
  EXPECT_THROW((void)run_job(plan_library(open_library({{two_, one_}}), folder_ / "library"), {}, {}), CannotComplete);
}

}  // namespace
}  // namespace patinate::transfer
