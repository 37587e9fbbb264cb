#include "patinate/history/history.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/history/history_times.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;
using testing_support::has;
using testing_support::TempFolder;

constexpr int kFolderWidth = 6, kFolderHeight = 4;

/// Values that half floats hold exactly.
ImageF make_frame(float offset) {
  ImageF frame(kFolderWidth, kFolderHeight, 3);
  for (int y = 0; y < kFolderHeight; ++y) {
    for (int x = 0; x < kFolderWidth; ++x) {
      for (int c = 0; c < 3; ++c) {
        frame.at(x, y, c) =
            offset + static_cast<float>(x) / 16.0f + static_cast<float>(y) / 64.0f + static_cast<float>(c) / 128.0f;
      }
    }
  }
  return frame;
}

HistoryManifest make_manifest() {
  HistoryManifest m;
  m.name = "test";
  m.width = kFolderWidth;
  m.height = kFolderHeight;
  m.time_unit = TimeUnit::Days;
  m.key = "0123";
  return m;
}

/// Three frames at uneven times, a control and a mask.
void write_three_frames(const fs::path& folder) {
  HistoryWriter writer(folder, make_manifest());
  writer.write_frame(2, 10.0, make_frame(0.5f));
  writer.write_frame(0, 0.0, make_frame(0.0f));
  writer.write_frame(1, 2.5, make_frame(0.25f));
  ImageF control(kFolderWidth, kFolderHeight);
  for (int x = 0; x < kFolderWidth; ++x) control.at(x, 0) = static_cast<float>(x) - 1.0f;
  writer.write_control("thickness", control, 0.0, 4.0, "relative");
  ImageU8 mask(kFolderWidth, kFolderHeight, 1, 1);
  mask.at(0, 0) = 0;
  writer.write_mask(mask);
  writer.finish();
}

std::string reading_error(const fs::path& path) {
  try {
    const HistoryReader reader(path);
    (void)reader.read_mask();
    for (int i = 0; i < reader.num_frames(); ++i) (void)reader.read_frame(i);
    for (const auto& c : reader.manifest().controls) (void)reader.read_control(c.name);
  } catch (const IoError& e) {
    return e.what();
  }
  return "";
}

void replace_in_manifest(const fs::path& folder, const std::string& from, const std::string& to) {
  std::string text = read_file(folder / "history.json");
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  write_atomically(folder / "history.json", text.replace(at, from.size(), to));
}

TEST(History, ReadsBackWhatWasWritten) {
  const TempFolder folder;
  write_three_frames(folder.path());
  for (const fs::path& path : {folder.path(), folder / "history.json"}) {
    const HistoryReader reader(path);
    const HistoryManifest& m = reader.manifest();
    EXPECT_EQ(m.name, "test");
    EXPECT_EQ(m.origin, "captured");
    EXPECT_EQ(m.time_unit, TimeUnit::Days);
    EXPECT_EQ(m.key, "0123");
    EXPECT_FALSE(m.texel_size_mm);
    ASSERT_EQ(reader.num_frames(), 3);
    EXPECT_EQ(m.frames[1].time, 2.5);
    EXPECT_EQ(reader.read_frame(0), make_frame(0.0f));
    EXPECT_EQ(reader.read_frame(1), make_frame(0.25f));
    EXPECT_EQ(reader.read_frame(2), make_frame(0.5f));
    EXPECT_EQ(reader.read_mask().at(0, 0), 0);
    EXPECT_EQ(reader.read_mask().at(1, 0), 255);
    EXPECT_EQ(reader.control("thickness").high, 4.0);
    EXPECT_EQ(reader.control("thickness").unit, "relative");
  }
}

TEST(History, AFramesOwnMaskAddsToTheHistorysMask) {
  const TempFolder folder;
  HistoryWriter writer(folder.path(), make_manifest());
  for (int i = 0; i < 2; ++i) writer.write_frame(i, i, make_frame(0.0f));
  ImageU8 mask(kFolderWidth, kFolderHeight, 1, 255);
  mask.at(0, 0) = 0;
  writer.write_mask(mask);
  ImageU8 frame_mask(kFolderWidth, kFolderHeight, 1, 255);
  frame_mask.at(2, 1) = 0;
  fs::create_directory(folder / "masks");
  write_codes(folder / HistoryWriter::frame_mask_file(1), frame_mask);
  writer.add_written_frame_mask(1);
  writer.finish();
  const HistoryReader reader(folder.path());
  EXPECT_EQ(reader.read_frame_mask(0), mask);
  mask.at(2, 1) = 0;
  EXPECT_EQ(reader.read_frame_mask(1), mask);
  EXPECT_THROW((void)reader.read_frame_mask(2), InvalidInput);
}

TEST(History, ControlsAreNormalizedByTheirRangeAndClamped) {
  const TempFolder folder;
  write_three_frames(folder.path());
  const ImageF control = HistoryReader(folder.path()).read_control("thickness");
  // Written: x - 1 with range [0, 4].
  EXPECT_EQ(control.at(0, 0), 0.0f);
  EXPECT_EQ(control.at(1, 0), 0.0f);
  EXPECT_EQ(control.at(3, 0), 0.5f);
  EXPECT_EQ(control.at(5, 0), 1.0f);
}

TEST(History, SampleAtFrameTimesIsThatFrameToTheBit) {
  const TempFolder folder;
  write_three_frames(folder.path());
  const HistoryReader reader(folder.path());
  for (int i = 0; i < reader.num_frames(); ++i) {
    const double time = reader.manifest().frames[i].time;
    EXPECT_EQ(reader.sample(time), reader.read_frame(i));
  }
  EXPECT_EQ(reader.sample(-1.0), reader.read_frame(0));
  EXPECT_EQ(reader.sample(1e9), reader.read_frame(2));
}

TEST(History, SampleBetweenFramesIsLinearInTime) {
  const TempFolder folder;
  write_three_frames(folder.path());
  const HistoryReader reader(folder.path());
  // Offsets 0 at time 0 and 0.25 at time 2.5: 0.1 at time 1.
  const ImageF sampled = reader.sample(1.0), first = reader.read_frame(0);
  EXPECT_NEAR(sampled.at(3, 2, 1) - first.at(3, 2, 1), 0.1f, 1e-6f);
  EXPECT_EQ(reader.locate(2.5).index, 1);
  EXPECT_EQ(reader.locate(2.5).fraction, 0.0);
  EXPECT_THROW((void)reader.locate(std::numeric_limits<double>::quiet_NaN()), InvalidInput);
}

TEST(History, EqualWorkGivesEqualBytes) {
  const TempFolder a, b;
  write_three_frames(a.path());
  write_three_frames(b.path());
  for (const char* file : {"history.json", "frames/0001.exr", "controls/thickness.exr", "mask.png"}) {
    EXPECT_EQ(read_file(a / file), read_file(b / file)) << file;
  }
}

TEST(History, ManifestKeepsUnknownTexelSizeAsNull) {
  const TempFolder folder;
  write_three_frames(folder.path());
  EXPECT_TRUE(has(read_file(folder / "history.json"), "\"texel_size_mm\": null"));
}

TEST(History, AcceptsTheOptionalImagesOfTheFormat) {
  const TempFolder folder;
  write_three_frames(folder.path());
  replace_in_manifest(folder.path(), "\"file\": \"frames/0001.exr\"",
                      "\"file\": \"frames/0001.exr\", \"stddev\": \"s.exr\", \"mask\": \"mask.png\" // later\n");
  replace_in_manifest(folder.path(), "\"key\"", "\"maps\": {\"height\": \"h.exr\"}, \"key\"");
  EXPECT_EQ(reading_error(folder.path()), "");
}

TEST(History, WarningsAreKeptTheWorstFirst) {
  const TempFolder folder;
  HistoryWriter writer(folder.path(), make_manifest());
  writer.write_frame(0, 0.0, make_frame(0.0f));
  const HistoryWarning mild{.about = WarningSubject::Light, .text = "uneven", .cure = "", .share = 0.1};
  const HistoryWarning severe{
      .about = WarningSubject::Mask, .text = "masked", .cure = "keep it", .share = 0.75, .photos = {"a.png", "b.png"}};
  writer.add_warning(mild);
  writer.add_warning(severe);
  writer.finish();
  const HistoryReader reader(folder.path());
  EXPECT_EQ(reader.facts().warnings, (std::vector<HistoryWarning>{severe, mild}));
  EXPECT_EQ(warning_text(severe), "masked; what helps: keep it");
  EXPECT_EQ(warning_text(mild), "uneven");
}

TEST(History, FramesCarryMoreThanColor) {
  const TempFolder folder;
  write_three_frames(folder.path());
  HistoryManifest manifest = read_history_manifest(folder.path());
  HistoryWriter writer(folder.path(), manifest);
  const ImageF deviation(manifest.width, manifest.height, 3, 0.25f), lobe(manifest.width, manifest.height, 2, 0.5f);
  HistoryWriter::write_frame_extra(folder.path(), 1, "specular", lobe);
  HistoryWriter::write_frame_extra(folder.path(), 1, "stddev", deviation);
  writer.add_written_frame_extra(1, "specular");
  writer.add_written_frame_extra(1, "stddev");
  EXPECT_THROW(writer.add_written_frame_extra(1, "stddev"), InvalidInput);
  EXPECT_THROW(HistoryWriter::write_frame_extra(folder.path(), 1, "specular", deviation), InvalidInput);
  EXPECT_THROW((void)HistoryWriter::frame_extra_file(1, "color"), InvalidInput);
  writer.finish();
  const HistoryReader reader(folder.path());
  EXPECT_EQ(reader.read_frame_extra(1, "specular"), lobe);
  EXPECT_EQ(reader.read_frame_extra(1, "stddev"), deviation);
  EXPECT_EQ(reader.read_frame_extra(1, "normal"), std::nullopt);
  EXPECT_EQ(reader.read_frame_extra(0, "stddev"), std::nullopt);
}

TEST(History, UnknownKeysAreErrorsWithASuggestion) {
  const TempFolder folder;
  write_three_frames(folder.path());
  replace_in_manifest(folder.path(), "\"origin\"", "\"origin\": \"captured\", \"orign\"");
  EXPECT_TRUE(has(reading_error(folder.path()), "history.json: /orign: unknown key; did you mean `origin`?"))
      << reading_error(folder.path());
}

TEST(History, GarbageManifestsAreOneLineErrors) {
  const TempFolder folder;
  EXPECT_TRUE(has(reading_error(folder / "nothing"), "nothing"));
  EXPECT_TRUE(has(reading_error(folder.path()), "history.json: does not exist"));
  write_three_frames(folder.path());
  const std::string good = read_file(folder / "history.json");
  for (std::size_t length = 0; length + 2 < good.size(); length += 7) {
    write_atomically(folder / "history.json", good.substr(0, length));
    const std::string error = reading_error(folder.path());
    EXPECT_TRUE(has(error, "history.json")) << length;
    EXPECT_FALSE(has(error, "\n")) << length;
  }
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"\"version\": 1", "\"version\": 2"},
                                                        {"patinate.history", "patinate.scene"},
                                                        {"\"width\": 6", "\"width\": 0"},
                                                        {"\"width\": 6", "\"width\": 6e9"},
                                                        {"\"width\": 6", "\"width\": \"6\""},
                                                        {"\"origin\": \"captured\"", "\"origin\": \"found\""},
                                                        {"\"time\": 2.5", "\"time\": 1e999"},
                                                        {"\"time\": 2.5", "\"time\": null"},
                                                        {"\"time_unit\": \"d\"", "\"time_unit\": \"days\""},
                                                        {"\"frames\": [", "\"frames\": 3, \"x\": ["}}) {
    write_atomically(folder / "history.json", good);
    replace_in_manifest(folder.path(), from, to);
    EXPECT_TRUE(has(reading_error(folder.path()), "history.json")) << to;
  }
}

TEST(History, EqualOrUnsortedTimesAreErrors) {
  const TempFolder folder;
  write_three_frames(folder.path());
  replace_in_manifest(folder.path(), "\"time\": 2.5", "\"time\": 10");
  EXPECT_TRUE(has(reading_error(folder.path()), "times must be strictly increasing"));
  replace_in_manifest(folder.path(), "\"time\": 10", "\"time\": 11");
  EXPECT_TRUE(has(reading_error(folder.path()), "times must be strictly increasing"));

  HistoryWriter writer(folder.path(), make_manifest());
  EXPECT_THROW(writer.finish(), InvalidInput);
  writer.add_written_frame(0, 1.0);
  writer.add_written_frame(1, 1.0);
  EXPECT_THROW(writer.finish(), InvalidInput);
  HistoryWriter nan_writer(folder.path(), make_manifest());
  nan_writer.add_written_frame(0, std::nan(""));
  EXPECT_THROW(nan_writer.finish(), InvalidInput);
}

// Spans and steps are divided by and multiplied with in many places: 1e308 - -1e308 is infinite, 1 / 5e-324 too.
TEST(History, TimesThatCannotBeComputedWithAreErrors) {
  const TempFolder folder;
  write_three_frames(folder.path());
  const std::string good = read_file(folder / "history.json");
  const auto error_with = [&](const std::string& first, const std::string& last) {
    write_atomically(folder / "history.json", good);
    replace_in_manifest(folder.path(), "\"time\": 0", "\"time\": " + first);
    replace_in_manifest(folder.path(), "\"time\": 2.5", "\"time\": -1");  // Between them, and out of the way.
    replace_in_manifest(folder.path(), "\"time\": 10", "\"time\": " + last);
    return reading_error(folder.path());
  };
  EXPECT_TRUE(has(error_with("-1e308", "1e308"), "has time -1e+308; use -1e18 to 1e18"));
  EXPECT_TRUE(has(error_with("-2", "1.0000001e18"), "use -1e18 to 1e18"));
  EXPECT_TRUE(has(error_with("-1.0000000000001", "10"), "nearly that of the one before (-1.0000000000001)"));
  EXPECT_TRUE(has(error_with("-2", "-0.9999999999999999"), "1e-12 apart at least"));
  EXPECT_EQ(error_with("-1000002", "1e18"), "");
  EXPECT_TRUE(has(error_with("-2", "1e18"), "1000000 apart at least, 1e-12 of their span"));
  EXPECT_EQ(error_with("-1e18", "1e18"), "");
  EXPECT_EQ(error_with("-1.0000000001", "10"), "");
  // A camera of 120 pictures a second that counts from 1970.
  EXPECT_FALSE(find_time_problem(std::vector<double>{1.7e9, 1.7e9 + 1.0 / 120, 1.7e9 + 2.0 / 120}).has_value());
  EXPECT_FALSE(find_time_problem({}).has_value());
}

TEST(History, ControlsHaveNamesThatAreFilesOfTheirFolder) {
  const TempFolder folder;
  write_three_frames(folder.path());
  const std::string good = read_file(folder / "history.json");
  for (const char* name : {"../../evil", "a/b", "", ".hidden", "two words"}) {
    write_atomically(folder / "history.json", good);
    replace_in_manifest(folder.path(), "\"name\": \"thickness\"", std::string("\"name\": \"") + name + "\"");
    EXPECT_TRUE(has(reading_error(folder.path()),
                    "/controls/0/name: found \"" + std::string(name) + "\"; expected a name of letters"))
        << name;
  }
}

TEST(History, BrokenFilesAreNamed) {
  for (const std::string file : {"frames/0001.exr", "controls/thickness.exr", "mask.png"}) {
    const TempFolder folder;
    write_three_frames(folder.path());
    const std::string good = read_file(folder / file);
    fs::remove(folder / file);
    EXPECT_TRUE(has(reading_error(folder.path()), file)) << file;
    for (std::size_t length : {std::size_t{0}, std::size_t{10}, good.size() / 2, good.size() - 40}) {
      write_atomically(folder / file, good.substr(0, length));
      EXPECT_TRUE(has(reading_error(folder.path()), file)) << file << " of " << length;
    }
    write_atomically(folder / file, "this is no image, but long enough to be looked at by every decoder");
    EXPECT_TRUE(has(reading_error(folder.path()), file)) << file;
    write_exr(folder / "small.exr", ImageF(2, 2, 3), {"R", "G", "B"}, ExrDepth::Half);
    fs::rename(folder / "small.exr", folder / file);
    EXPECT_TRUE(has(reading_error(folder.path()), "is 2 x 2 pixels; the history says 6 x 4")) << file;
  }
}

TEST(History, ControlsOutsideTheUnitIntervalAndEmptyMasksAreErrors) {
  const TempFolder folder;
  write_three_frames(folder.path());
  write_codes(folder / "mask.png", ImageU8(kFolderWidth, kFolderHeight));
  EXPECT_TRUE(has(reading_error(folder.path()), "mask.png: is 0 everywhere"));
  write_codes(folder / "mask.png", ImageU8(kFolderWidth, kFolderHeight, 1, 255));
  write_exr(folder / "controls/thickness.exr", ImageF(kFolderWidth, kFolderHeight, 1, 1.5f), {"Y"}, ExrDepth::Float);
  EXPECT_TRUE(has(reading_error(folder.path()), "thickness.exr: holds 1.5"));
}

TEST(History, WriterRefusesWhatTheFormatDoesNotAllow) {
  const TempFolder folder;
  HistoryWriter writer(folder.path(), make_manifest());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(writer.write_frame(0, 0.0, ImageF(3, 3, 3)), InvalidInput);
  EXPECT_THROW(writer.write_frame(0, 0.0, ImageF(kFolderWidth, kFolderHeight, 3, nan)), InvalidInput);
  EXPECT_THROW(writer.write_frame(-1, 0.0, make_frame(0)), InvalidInput);
  EXPECT_THROW(writer.write_mask(ImageU8(kFolderWidth, kFolderHeight)), InvalidInput);
  EXPECT_THROW(writer.write_control("x", ImageF(kFolderWidth, kFolderHeight, 1, nan), 0, 1, ""), InvalidInput);
  EXPECT_THROW(writer.write_control("x", ImageF(kFolderWidth, kFolderHeight), 1, 0, ""), InvalidInput);
  EXPECT_THROW(writer.write_control("../x", ImageF(kFolderWidth, kFolderHeight), 0, 1, ""), InvalidInput);
  HistoryManifest wrong = make_manifest();
  wrong.width = 0;
  EXPECT_THROW(HistoryWriter(folder.path(), wrong), InvalidInput);
  wrong = make_manifest();
  wrong.origin = "found";
  EXPECT_THROW(HistoryWriter(folder.path(), wrong), InvalidInput);
}

TEST(History, UnknownControlsAreListed) {
  const TempFolder folder;
  write_three_frames(folder.path());
  try {
    (void)HistoryReader(folder.path()).control("thicknes");
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_TRUE(has(e.what(), "there is: thickness; did you mean `thickness`?")) << e.what();
  }
}

TEST(History, TimeUnitsAreThoseOfTheFormat) {
  for (TimeUnit unit : {TimeUnit::Seconds, TimeUnit::Minutes, TimeUnit::Hours, TimeUnit::Days}) {
    EXPECT_EQ(parse_time_unit(time_unit_text(unit)), unit);
  }
  EXPECT_EQ(seconds_per(TimeUnit::Days), 86400.0);
  EXPECT_THROW((void)parse_time_unit("weeks"), InvalidInput);
}

}  // namespace
}  // namespace patinate
