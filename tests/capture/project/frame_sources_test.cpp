#include "capture/project/frame_sources.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "capture/timelapse/ingest.h"
#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tests/support/movies.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate::capture {
namespace {

namespace fs = std::filesystem;
using testing_support::TempFolder;

constexpr int kNumFrames = 12;

ImageU8 movie_frame(int i) {
  ImageU8 frame(16, 8, 3);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x) {
      for (int c = 0; c < 3; ++c) frame.at(x, y, c) = static_cast<std::uint8_t>(10 * x + 3 * y + 9 * i + c);
    }
  }
  return frame;
}

void write_movie(const fs::path& file) {
  std::vector<ImageU8> frames;
  for (int i = 0; i < kNumFrames; ++i) frames.push_back(movie_frame(i));
  testing_support::write_avi(file, frames, 10);
}

CaptureProject project_of(const TempFolder& folder, const std::string& frames, const std::string& more = "") {
  const fs::path file = folder / "capture.json";
  write_atomically(
      file, R"({"format": "patinate.capture", "version": 1, "name": "movie", "kind": "fixed", "frames": )" + frames +
                (more.empty() ? "" : ", " + more) + "}");
  return read_capture_project(file);
}

std::vector<double> times_of(const CaptureProject& project) {
  std::vector<double> times;
  for (const CapturePhoto& photo : project.frames) times.push_back(photo.time);
  return times;
}

HistoryReader ingest_project(const CaptureProject& project, const fs::path& out, int num_threads = 0) {
  RunControl control;
  control.num_threads = num_threads;
  (void)run_job(plan_ingest(project, {}, out), {}, control);
  return HistoryReader(out);
}

TEST(FrameSources, EveryImageOfAMovieIsAFrame) {
  const TempFolder folder;
  write_movie(folder / "clip.avi");
  const CaptureProject project = project_of(folder, R"({"pattern": "clip.avi", "interval": 4.85})");
  const HistoryReader history = ingest_project(project, folder / "out");
  ASSERT_EQ(history.num_frames(), kNumFrames);
  EXPECT_EQ(history.manifest().frames[3].time, 14.55);
  for (int i = 0; i < kNumFrames; ++i) {
    const float expected = linear_from_srgb(static_cast<float>(movie_frame(i).at(5, 2, 1)) / 255.0f);
    EXPECT_NEAR(history.read_frame(i).at(5, 2, 1), expected, expected / 2048.0f) << i;  // Half has 11 bits.
  }
}

TEST(FrameSources, WithoutIntervalTheRateOfAMovieGivesTheTimes) {
  const TempFolder folder;
  write_movie(folder / "clip.avi");
  const CaptureProject project = project_of(folder, R"({"pattern": "clip.avi", "every": 5})");
  EXPECT_EQ(project.time_source, "when the movie shows its images");
  EXPECT_EQ(times_of(project), (std::vector<double>{0.0, 0.5, 1.0}));
}

TEST(FrameSources, ChosenImagesKeepTheirTimes) {
  const TempFolder folder;
  write_movie(folder / "clip.avi");
  const CaptureProject project = project_of(
      folder, R"({"pattern": "clip.avi", "interval": 2, "from": 1, "to": 10, "every": 3})", R"("exclude": [4])");
  EXPECT_EQ(times_of(project), (std::vector<double>{2.0, 14.0, 20.0}));  // Images 1, 7, 10.
  const HistoryReader history = ingest_project(project, folder / "out");
  const float expected = linear_from_srgb(static_cast<float>(movie_frame(7).at(5, 2, 1)) / 255.0f);
  EXPECT_NEAR(history.read_frame(1).at(5, 2, 1), expected, expected / 2048.0f);
}

TEST(FrameSources, AListNamesImagesOfAMovie) {
  const TempFolder folder;
  write_movie(folder / "clip.avi");
  const CaptureProject project = project_of(
      folder, R"([{"time": 0, "photo": "clip.avi", "image": 9}, {"time": 1, "photo": "clip.avi", "image": 2}])");
  const HistoryReader history = ingest_project(project, folder / "out");
  const float expected = linear_from_srgb(static_cast<float>(movie_frame(9).at(5, 2, 1)) / 255.0f);
  EXPECT_NEAR(history.read_frame(0).at(5, 2, 1), expected, expected / 2048.0f);
}

TEST(FrameSources, CropScaleAndMaskWorkOnMovies) {
  const TempFolder folder;
  write_movie(folder / "clip.avi");
  ImageU8 mask(16, 8, 1, 0);
  for (int y = 0; y < 8; ++y) {
    for (int x = 8; x < 16; ++x) mask.at(x, y) = 255;
  }
  write_codes(folder / "mask.png", mask);
  const CaptureProject project =
      project_of(folder, R"({"pattern": "clip.avi", "interval": 2})",
                 R"("response": "linear", "roi": [4, 2, 8, 4], "scale": 0.5, "mask": "mask.png")");
  const HistoryReader history = ingest_project(project, folder / "out", 1);
  ASSERT_EQ(history.manifest().width, 4);
  ASSERT_EQ(history.manifest().height, 2);
  double sum = 0.0;
  for (int y = 2; y < 4; ++y) {
    for (int x = 8; x < 10; ++x) sum += movie_frame(5).at(x, y, 0) / 255.0;
  }
  EXPECT_NEAR(static_cast<double>(history.read_frame(5).at(2, 0, 0)), sum / 4.0, 3e-4);
  EXPECT_EQ(history.read_mask().at(1, 0), 0);
  EXPECT_EQ(history.read_mask().at(2, 0), 255);
}

TEST(FrameSources, ABrokenPhotographMayBeExcluded) {
  const TempFolder folder;
  for (int i = 0; i < 3; ++i) write_codes(folder / (std::to_string(i) + ".png"), movie_frame(i));
  write_atomically(folder / "1.png", "broken");
  EXPECT_EQ(times_of(project_of(folder, R"({"pattern": "*.png", "interval": 1})", R"("exclude": [1])")),
            (std::vector<double>{0.0, 2.0}));
  EXPECT_THROW((void)project_of(folder, R"({"pattern": "*.png", "interval": 1})"), IoError);
}

TEST(FrameSources, MistakesWithMoviesAreNamed) {
  const struct {
    const char* frames;
    const char* expected;
  } kCases[] = {
      {R"([{"time": 0, "photo": "clip.avi"}])", "clip.avi: holds 12 images; say which one with `image`"},
      {R"([{"time": 0, "photo": "clip.avi", "image": 12}])", "/frames/0/image: found 12; expected an integer [0, 11]"},
      {R"({"pattern": "*.avi"})", "does not say when its images were taken; give `interval`"},
      {R"({"pattern": "clip.avi", "from": 12})", "/frames/from"},
      {R"({"pattern": "clip.avi", "from": 5, "to": 4})", "/frames/to"},
      {R"({"pattern": "clip.avi", "every": 0})", "/frames/every"},
  };
  const TempFolder folder;
  write_movie(folder / "clip.avi");
  write_movie(folder / "more.avi");
  for (const auto& c : kCases) {
    std::string error;
    try {
      (void)project_of(folder, c.frames);
    } catch (const InputError& e) {
      error = e.what();
    }
    EXPECT_NE(error.find(c.expected), std::string::npos) << c.frames << " gave: " << error;
  }
}

TEST(FrameSources, CameraRawIsTakenAsLight) {
  const TempFolder folder;
  ImageF light(64, 48, 3);
  for (float& v : light.values()) v = 0.25f;
  testing_support::write_dng(folder / "day_2024-05-06.dng", light);
  const CaptureProject project = project_of(folder, R"({"pattern": "*.dng"})");
  EXPECT_TRUE(project.has_raw_frames);
  EXPECT_NEAR(ingest_project(project, folder / "out").read_frame(0).at(20, 20, 1), 0.25f, 0.004f);
}

TEST(FrameSourcesRealData, EveryTimeLapseIsReadAsAMovie) {
  PATINATE_REQUIRE_DATA(data, "timelapse");
  for (const auto& [name, count] : {std::pair{"copper_patinating", 100}, std::pair{"decaying_melon", 98}}) {
    const TempFolder folder;
    const fs::path movie = data / name / (std::string(name) + ".webp");
    const CaptureProject project = project_of(folder, R"({"pattern": ")" + movie.string() + R"(", "interval": 4.85})");
    ASSERT_EQ(static_cast<int>(project.frames.size()), count);
    EXPECT_EQ(ingest_project(project, folder / "out").num_frames(), count);
  }
}

}  // namespace
}  // namespace patinate::capture
