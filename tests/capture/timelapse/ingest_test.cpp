#include "capture/timelapse/ingest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <string>

#include "libcommon/core/files.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tests/capture/timelapse/ingest_folder.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate::capture {
namespace {

namespace fs = std::filesystem;
using testing_support::has;
using testing_support::ingest;
using testing_support::ingest_error;
using testing_support::TempFolder;

constexpr int kWidth = 24, kHeight = 16;

ImageU8 photo_codes(int index, int channels = 3) {
  ImageU8 codes(kWidth, kHeight, channels, 255);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) codes.at(x, y, c) = static_cast<std::uint8_t>(40 + 4 * x + 6 * y + 20 * index + c);
      if (channels == 4 && x < 2 + index) codes.at(x, y, 3) = 0;
    }
  }
  return codes;
}

/// A folder with three photographs and a project file; `more` are further keys.
void write_project(const fs::path& folder, const std::string& more = "",
                   const std::string& frames = R"({"pattern": "frames/*.png", "interval": 2.5, "start": 1})",
                   int channels = 3) {
  fs::create_directories(folder / "frames");
  for (int i = 0; i < 3; ++i) write_codes(folder / "frames" / (std::to_string(i) + ".png"), photo_codes(i, channels));
  write_atomically(folder / "capture.json",
                   R"({"format": "patinate.capture", "version": 1, "name": "test", "kind": "fixed", "frames": )" +
                       frames + (more.empty() ? "" : ", " + more) + "}");
}

TEST(Ingest, WritesTheLinearPhotographsAtTheirTimes) {
  const TempFolder folder;
  write_project(folder.path(), R"("time_unit": "h", "texel_size_mm": 0.5)");
  const HistoryReader history = ingest(folder.path());
  ASSERT_EQ(history.num_frames(), 3);
  EXPECT_EQ(history.manifest().name, "test");
  EXPECT_EQ(history.manifest().origin, "captured");
  EXPECT_EQ(history.manifest().time_unit, TimeUnit::Hours);
  EXPECT_EQ(history.manifest().texel_size_mm, 0.5);
  EXPECT_FALSE(history.manifest().mask);
  constexpr float kHalfRounding = 1.0f / 2048.0f;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(history.manifest().frames[i].time, 1.0 + 2.5 * i);
    const float expected = linear_from_srgb(static_cast<float>(photo_codes(i).at(7, 5, 1)) / 255.0f);
    EXPECT_NEAR(history.read_frame(i).at(7, 5, 1), expected, expected * kHalfRounding);
  }
}

TEST(Ingest, MakesProgressWhenNothingWasMeasured) {
  const TempFolder folder;
  write_project(folder.path());
  const HistoryReader history = ingest(folder.path());
  ASSERT_EQ(history.manifest().controls.size(), 1u);
  EXPECT_EQ(history.manifest().controls[0].name, "progress");
  EXPECT_EQ(history.manifest().controls[0].unit, "relative");
  EXPECT_EQ(history.read_control("progress").width(), kWidth);
}

TEST(Ingest, CutsAndScales) {
  const TempFolder folder;
  write_project(folder.path(), R"("roi": [4, 2, 12, 8], "scale": 0.5, "response": "linear", "texel_size_mm": 0.5)");
  const HistoryReader history = ingest(folder.path());
  EXPECT_EQ(history.manifest().width, 6);
  EXPECT_EQ(history.manifest().height, 4);
  EXPECT_EQ(history.manifest().texel_size_mm, 1.0);
  double sum = 0.0;
  for (int y = 4; y < 6; ++y) {
    for (int x = 6; x < 8; ++x) sum += photo_codes(1).at(x, y, 2) / 255.0;
  }
  EXPECT_NEAR(static_cast<double>(history.read_frame(1).at(1, 1, 2)), sum / 4.0, 3e-4);
}

TEST(Ingest, ExcludedFramesLeaveTheTimesOfTheOthers) {
  const TempFolder folder;
  write_project(folder.path(), R"("exclude": [1])");
  const HistoryReader history = ingest(folder.path());
  ASSERT_EQ(history.num_frames(), 2);
  EXPECT_EQ(history.manifest().frames[1].time, 6.0);
}

TEST(Ingest, GivenControlsKeepTheirPhysicalRange) {
  const TempFolder folder;
  ImageF wetness(kWidth, kHeight);
  for (int x = 0; x < kWidth; ++x) {
    for (int y = 0; y < kHeight; ++y) wetness.at(x, y) = static_cast<float>(10 + x);
  }
  write_exr(folder / "wetness.exr", wetness, {"Y"}, ExrDepth::Float);
  write_project(folder.path(), R"("controls": [{"name": "wetness", "file": "wetness.exr", "unit": "%"}])");
  const HistoryReader history = ingest(folder.path());
  ASSERT_EQ(history.manifest().controls.size(), 1u);
  EXPECT_EQ(history.control("wetness").low, 10.0);
  EXPECT_EQ(history.control("wetness").high, 33.0);
  EXPECT_EQ(history.control("wetness").unit, "%");
  EXPECT_NEAR(history.read_control("wetness").at(12, 3), 12.0f / 23.0f, 1e-6f);
}

TEST(Ingest, TransmissionBecomesThicknessAndProgressCanBeAdded) {
  const TempFolder folder;
  ImageU8 backlight(kWidth, kHeight, 1, 200);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) backlight.at(x, y) = 100;
  }
  write_codes(folder / "backlight.png", backlight);
  write_project(folder.path(), R"("transmission": {"photo": "backlight.png"}, "response": "linear")");
  IngestOptions options;
  options.thickness.mode_filter.spatial_sigma_px = 2.0;
  options.thickness.num_refinements = 0;  // The layer has an edge.
  {
    const HistoryReader history = ingest(folder.path(), options);
    ASSERT_EQ(history.manifest().controls.size(), 1u);
    EXPECT_NEAR(history.control("thickness").low, 255.0 / 200.0, 0.01);
    EXPECT_NEAR(history.control("thickness").high, 255.0 / 100.0, 0.01);
    EXPECT_GT(history.read_control("thickness").at(3, 8), 0.99f);
    EXPECT_LT(history.read_control("thickness").at(20, 8), 0.01f);
  }
  fs::remove_all(folder / "out");
  options.add_progress = true;
  EXPECT_EQ(ingest(folder.path(), options).manifest().controls.size(), 2u);
}

TEST(Ingest, WhatIsTransparentInAnyFrameIsOutside) {
  const TempFolder folder;
  write_project(folder.path(), "", R"({"pattern": "frames/*.png", "interval": 1})", 4);
  const ImageU8 mask = ingest(folder.path()).read_mask();
  // Frame i is transparent in columns [0, 2 + i).
  EXPECT_EQ(mask.at(3, 5), 0);
  EXPECT_EQ(mask.at(4, 5), 255);
}

TEST(Ingest, TheSameWorkGivesTheSameBytesOnAnyNumberOfThreads) {
  const TempFolder a, b;
  write_project(a.path());
  write_project(b.path());
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  (void)ingest(a.path(), {}, one);
  (void)ingest(b.path(), {}, three);
  for (const char* file : {"history.json", "frames/0002.exr", "controls/progress.exr"}) {
    EXPECT_EQ(read_file(a / "out" / file), read_file(b / "out" / file)) << file;
  }
}

TEST(Ingest, KeyFollowsContentNotNames) {
  const TempFolder folder;
  write_project(folder.path());
  const auto key = [&](const IngestOptions& options = {}) {
    return plan_ingest(read_capture_project(folder / "capture.json"), options, folder / "out").key;
  };
  const std::string before = key();
  IngestOptions smoother;
  smoother.progress.smoothing_px = 5.0;
  EXPECT_NE(key(smoother), before);
  IngestOptions unused;
  unused.thickness.curve = ThicknessCurve::Linear;
  EXPECT_EQ(key(unused), before);
  fs::rename(folder / "frames/2.png", folder / "frames/7.png");
  EXPECT_EQ(key(), before);
  write_codes(folder / "frames/7.png", photo_codes(5));
  EXPECT_NE(key(), before);
}

TEST(CaptureProject, MistakesInTheProjectAreNamedWithTheirPlace) {
  const struct {
    const char* more;
    const char* expected;
  } kCases[] = {
      {R"("maks": "m.png")", "/maks: unknown key; did you mean `mask`?"},
      {R"("time_unit": "weeks")", "/time_unit"},
      {R"("response": "rgb")", "/response"},
      {R"("response": {"gamma": 0})", "/response/gamma: found 0; expected a number (0, 10]"},
      {R"("roi": [0, 0, 25, 8])", "/roi: found an array of 4; expected [x, y, width, height] inside the photographs"},
      {R"("roi": [0, 0, 0, 8])", "/roi"},
      {R"("roi": [0.5, 0, 4, 8])", "/roi"},
      {R"("scale": 0)", "/scale"},
      {R"("scale": 2)", "/scale"},
      {R"("exclude": [3])", "/exclude/0"},
      {R"("exclude": [0, 1, 2])", "/exclude"},
      {R"("texel_size_mm": -1)", "/texel_size_mm"},
      {R"("mask": "nothing.png")", "nothing.png: does not exist"},
      {R"("transmission": {"photo": "nothing.png"})", "nothing.png: does not exist"},
      {R"("transmission": {"photo": "frames/0.png", "align": "automatic"})",
       "/transmission/align: found \"automatic\""},
      {R"("transmission": {"photo": "frames/0.png", "align": [[[0, 0], [0, 0]]]})",
       "/transmission/align: found an array of 1; expected four"},
      {R"("transmission": {"photo": "frames/0.png", "align": "auto"})", "0.png: cannot be aligned"},
      {R"("controls": [{"name": "a b", "file": "frames/0.png"}])", "/controls/0/name"},
      {R"("controls": [{"name": "a", "file": "frames/0.png"}, {"name": "a", "file": "frames/0.png"}])",
       "/controls/1/name"},
      {R"("scan": {"mesh": "m.ply"})", "no `unit`"},
  };
  for (const auto& c : kCases) {
    const TempFolder folder;
    write_project(folder.path(), c.more);
    EXPECT_TRUE(has(ingest_error(folder.path()), c.expected)) << c.more << " gave: " << ingest_error(folder.path());
  }
}

TEST(CaptureProject, FramesNeedRisingTimes) {
  const struct {
    const char* frames;
    const char* expected;
  } kCases[] = {
      {R"([{"time": 0, "photo": "frames/0.png"}, {"time": 0, "photo": "frames/1.png"}])",
       "/frames/1/time: found 0; expected a time later"},
      {R"([{"time": 5, "photo": "frames/0.png"}, {"time": 1, "photo": "frames/1.png"}])",
       "/frames/1/time: found 1; expected a time later"},
      {R"([{"time": 5, "photo": "frames/0.png"}, {"photo": "frames/1.png"}])", "a `time` for every frame"},
      {R"([{"time": "x", "photo": "frames/0.png"}])", "/frames/0/time"},
      {R"([])", "at least one frame"},
      {R"(7)", "/frames"},
      {R"({"pattern": "frames/*.jpg", "interval": 1})", "/frames/pattern"},
      {R"({"pattern": "nowhere/*.png", "interval": 1})", "nowhere"},
      {R"({"pattern": "frames/*.png", "interval": 0})", "/frames/interval: found 0; expected a number > 0"},
      {R"({"pattern": "frames/*.png", "interval": 1e-9, "start": 1600000000})",
       "capture.json: /frames/interval: found 1e-09; expected an interval"},
      {R"({"pattern": "frames/*.png", "interval": 1e308})", "/frames/interval: found 1e+308; expected an interval"},
      {R"({"pattern": "frames/*.png", "intervall": 1})", "/frames/intervall: unknown key; did you mean `interval`?"},
      {R"({"pattern": "frames/*.png"})", "and dates in file names (0.png has no date in the name)"},
      {R"([{"time": 0, "photo": "frames/9.png"}])", "9.png: does not exist"},
  };
  for (const auto& c : kCases) {
    const TempFolder folder;
    write_project(folder.path(), "", c.frames);
    EXPECT_TRUE(has(ingest_error(folder.path()), c.expected)) << c.frames << " gave: " << ingest_error(folder.path());
  }
}

TEST(CaptureProject, ShortIntervalsFromALateStartKeepTheirLength) {
  const TempFolder folder;
  const auto times = [&](const std::string& frames) {
    write_project(folder.path(), "", frames);
    std::vector<double> result;
    for (const CapturePhoto& frame : read_capture_project(folder / "capture.json").frames) result.push_back(frame.time);
    return result;
  };
  const double start = 1600000000.0;
  EXPECT_EQ(times(R"({"pattern": "frames/*.png", "start": 1600000000, "interval": 0.004})"),
            (std::vector<double>{start, start + 0.004, start + 0.008}));
  EXPECT_EQ(times(R"({"pattern": "frames/*.png", "start": 0.1, "interval": 0.1})"),
            (std::vector<double>{0.1, 0.2, 0.3}));
}

TEST(Ingest, BrokenPhotographsAreNamed) {
  const std::string png = [] {
    const TempFolder folder;
    write_project(folder.path());
    return read_file(folder / "frames/1.png");
  }();
  for (const std::string& bytes : {std::string(), png.substr(0, 20), png.substr(0, png.size() / 2),
                                   std::string("this is text, and by no means a picture of anything at all")}) {
    const TempFolder folder;
    write_project(folder.path());
    write_atomically(folder / "frames/1.png", bytes);
    const std::string error = ingest_error(folder.path());
    EXPECT_TRUE(has(error, "1.png: ")) << bytes.size() << " bytes gave: " << error;
    EXPECT_FALSE(has(error, "\n"));
    EXPECT_FALSE(fs::exists(folder / "out"));
  }
  const TempFolder folder;
  write_project(folder.path());
  write_codes(folder / "frames/1.png", ImageU8(5, 4, 3));
  EXPECT_TRUE(has(ingest_error(folder.path()), "1.png: is 5 x 4 pixels, but 0.png is 24 x 16"))
      << ingest_error(folder.path());
}

TEST(Ingest, ABrokenPhotographCostsNoneOfTheOthers) {
  const TempFolder folder, fresh;
  write_project(folder.path());
  const fs::path broken = folder / "frames/2.png";
  const std::string png = read_file(broken);
  write_atomically(broken, png.substr(0, png.size() - 40));  // Its header is whole: found out when it is decoded.
  RunControl one;
  one.num_threads = 1;
  EXPECT_THROW((void)ingest(folder.path(), {}, one), IoError);
  const auto made = fs::last_write_time(folder / "out.partial/frames/0001.exr");
  // Repaired, and one more at the end.
  write_atomically(broken, png);
  write_codes(folder / "frames/3.png", photo_codes(3));
  EXPECT_EQ(ingest(folder.path()).num_frames(), 4);
  EXPECT_EQ(fs::last_write_time(folder / "out/frames/0001.exr"), made);
  EXPECT_FALSE(fs::exists(folder / "out.partial"));

  write_project(fresh.path());
  write_codes(fresh / "frames/3.png", photo_codes(3));
  (void)ingest(fresh.path());
  for (const char* file : {"history.json", "frames/0001.exr", "frames/0003.exr", "controls/progress.exr"}) {
    EXPECT_EQ(read_file(folder / "out" / file), read_file(fresh / "out" / file)) << file;
  }
}

TEST(Ingest, FramesAreMadeAgainWhenTheyAreDevelopedOtherwise) {
  const TempFolder folder;
  write_project(folder.path(), R"("scale": 0.5, "controls": [{"name": "wet", "file": "wet.png"}])");
  write_codes(folder / "wet.png", ImageU8(kWidth, kHeight));
  const auto frame_keys = [&] {
    std::vector<std::string> keys;
    for (const JobItem& item : plan_ingest(read_capture_project(folder / "capture.json"), {}, folder / "out").items) {
      if (item.name.starts_with("frame-")) keys.push_back(item.key);
    }
    return keys;
  };
  const std::vector<std::string> before = frame_keys();
  EXPECT_EQ(std::set<std::string>(before.begin(), before.end()).size(), 3u);
  write_codes(folder / "wet.png", ImageU8(kWidth, kHeight, 1, 9));
  EXPECT_EQ(frame_keys(), before);
  for (const char* more :
       {R"("scale": 0.25)", R"("scale": 0.5, "roi": [0, 0, 24, 14])", R"("scale": 0.5, "response": "linear")"}) {
    write_project(folder.path(), more);
    EXPECT_NE(frame_keys()[0], before[0]) << more;
  }
}

TEST(Ingest, SoftAlphaLeavesColorAndTakesHalfTransparentPixelsOffTheMask) {
  const TempFolder folder;
  write_project(folder.path());
  for (int i = 0; i < 3; ++i) {
    ImageU8 codes = photo_codes(i, 4);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) codes.at(x, y, 3) = static_cast<std::uint8_t>(10 * x);
    }
    write_codes(folder / "frames" / (std::to_string(i) + ".png"), codes);
  }
  const HistoryReader history = ingest(folder.path());
  const ImageU8 mask = history.read_mask();
  EXPECT_EQ(mask.at(12, 5), 0);    // alpha 120 of 255
  EXPECT_EQ(mask.at(13, 5), 255);  // alpha 130
  constexpr float kHalfRounding = 1.0f / 2048.0f;
  for (int c = 0; c < 3; ++c) {
    const float expected = linear_from_srgb(static_cast<float>(photo_codes(1).at(14, 5, c)) / 255.0f);
    EXPECT_NEAR(history.read_frame(1).at(14, 5, c), expected, expected * kHalfRounding);
  }
}

TEST(Ingest, MapsOfTheWrongSizeOrWithNothingInsideAreNamed) {
  const TempFolder folder;
  write_codes(folder / "small.png", ImageU8(5, 4, 1, 255));
  write_codes(folder / "black.png", ImageU8(kWidth, kHeight));
  write_project(folder.path(), R"("mask": "small.png")");
  EXPECT_TRUE(has(ingest_error(folder.path()), "small.png: is 5 x 4 pixels; expected 24 x 16"));
  write_project(folder.path(), R"("mask": "black.png")");
  EXPECT_TRUE(has(ingest_error(folder.path()), "black.png: leaves nothing inside"));
  write_project(folder.path(), R"("transmission": {"photo": "frames/0.png", "blank": "black.png"})");
  EXPECT_TRUE(has(ingest_error(folder.path()), "the blank must be brighter than black"));
}

TEST(Ingest, NotANumberInAFloatPhotographIsAnError) {
  const TempFolder folder;
  // write_exr refuses NaN; a PFM is a header and plain floats.
  write_project(folder.path(), "", R"([{"time": 0, "photo": "a.pfm"}])");
  std::string pfm = "PF\n2 2\n-1.0\n";
  const float values[12] = {0, 0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0, 0, 0, 0, 0, 0, 0};
  pfm.append(reinterpret_cast<const char*>(values), sizeof(values));
  write_atomically(folder / "a.pfm", pfm);
  const std::string error = ingest_error(folder.path());
  EXPECT_TRUE(has(error, "a.pfm: ")) << error;
}

TEST(Ingest, OptionsOutOfRangeAreErrors) {
  const TempFolder folder;
  write_project(folder.path());
  const CaptureProject project = read_capture_project(folder / "capture.json");
  IngestOptions options;
  options.thickness.mode_filter.num_bins = 3;
  EXPECT_THROW((void)plan_ingest(project, options, folder / "out"), InvalidInput);
  options = {};
  options.progress.smoothing_px = std::nan("");
  EXPECT_THROW((void)plan_ingest(project, options, folder / "out"), InvalidInput);
}

TEST(IngestRealData, CopperAgesFromTheRight) {
  PATINATE_REQUIRE_DATA(frames, "timelapse/copper_patinating/frames_every4");
  const TempFolder folder;
  write_atomically(
      folder / "capture.json",
      R"({"format": "patinate.capture", "version": 1, "name": "copper", "kind": "fixed", "time_unit": "min",
                       "frames": {"pattern": ")" +
          (frames / "*.png").string() + R"(", "interval": 19.4}})");
  const HistoryReader history = ingest(folder.path());
  ASSERT_EQ(history.num_frames(), 26);
  EXPECT_EQ(history.manifest().width, 256);
  // In the pictures, blue patina takes the right side early while the left stays the brown it was.
  const ImageF progress = history.read_control("progress");
  const auto mean = [&](int x, int y, int w, int h) {
    double sum = 0.0;
    for (int j = y; j < y + h; ++j) {
      for (int i = x; i < x + w; ++i) sum += static_cast<double>(progress.at(i, j));
    }
    return sum / (w * h);
  };
  EXPECT_GT(mean(170, 80, 80, 100), mean(20, 80, 60, 60) + 0.3);
}

TEST(IngestRealData, BananaTakesItsUnevenDatesFromTheNames) {
  PATINATE_REQUIRE_DATA(photos, "timelapse/banana_14_B");
  const TempFolder folder;
  write_atomically(folder / "capture.json",
                   R"({"format": "patinate.capture", "version": 1, "name": "banana", "kind": "fixed", "time_unit": "d",
                       "frames": {"pattern": ")" +
                       (photos / "*.png").string() + R"("}, "scale": 0.25})");
  EXPECT_EQ(read_capture_project(folder / "capture.json").time_source, "dates in file names");
  const HistoryReader history = ingest(folder.path());
  ASSERT_EQ(history.num_frames(), 20);
  // 2020-05-28 18:20 to 2020-05-29 20:10 and to 2020-06-17 18:00.
  EXPECT_NEAR(history.manifest().frames[1].time, 25.0 / 24.0 + 50.0 / 1440.0, 1e-9);
  EXPECT_NEAR(history.manifest().frames[19].time, 20.0 - 20.0 / 1440.0, 1e-9);
  // The white background never ages.
  EXPECT_LT(history.read_control("progress").at(5, 5), 0.01f);
}

}  // namespace
}  // namespace patinate::capture
