#include "libcommon/image/frame_stream.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <string>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/decoder_process.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/output/movie.h"
#include "tests/support/movies.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;
using testing_support::TempFolder;

std::vector<ImageU8> make_frames(int count, int width = 40, int height = 24) {
  std::vector<ImageU8> frames;
  for (int i = 0; i < count; ++i) {
    ImageU8 frame(width, height, 3);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        frame.at(x, y, 0) = static_cast<std::uint8_t>(5 * x + i);
        frame.at(x, y, 1) = static_cast<std::uint8_t>(9 * y);
        frame.at(x, y, 2) = static_cast<std::uint8_t>(3 * i);
      }
    }
    frames.push_back(frame);
  }
  return frames;
}

std::vector<int> all_of(int count) {
  std::vector<int> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

ImageU8 codes_of(const DecodedImage& image) {
  ImageU8 codes(image.values.width(), image.values.height(), 3);
  for (int y = 0; y < codes.height(); ++y) {
    for (int x = 0; x < codes.width(); ++x) {
      for (int c = 0; c < 3; ++c)
        codes.at(x, y, c) = static_cast<std::uint8_t>(std::lround(255.0f * image.values.at(x, y, c)));
    }
  }
  return codes;
}

class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) { ::setenv(name, value.c_str(), 1); }
  ~Environment() { ::unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
};

/// A program that stands in for patinate-decode.
fs::path write_script(const TempFolder& folder, const std::string& body) {
  const fs::path script = folder / "decoder";
  write_atomically(script, "#!/bin/sh\n" + body + "\n");
  fs::permissions(script, fs::perms::owner_all);
  return script;
}

std::string read_error(const fs::path& file) {
  try {
    (void)read_color(file);
  } catch (const IoError& e) {
    return e.what();
  }
  return "";
}

TEST(FrameStream, GivesEveryFrameOfAMovieAsItWasWritten) {
  const TempFolder folder;
  const std::vector<ImageU8> frames = make_frames(60);
  testing_support::write_avi(folder / "clip.avi", frames, 25);
  const ImageInfo info = probe_image(folder / "clip.avi");
  ASSERT_EQ(info.num_frames, 60);
  EXPECT_EQ(info.frame_rate, 25.0);
  FrameStream stream(folder / "clip.avi", all_of(60));
  for (int i = 0; i < 60; ++i) ASSERT_EQ(codes_of(stream.read(i)), frames[i]) << i;
  EXPECT_EQ(codes_of(stream.read(7)), frames[7]);  // Going back.
}

/// Frame i is gray of the code i + 16, with a ramp of red across: what a codec keeps of it to a code or two.
ImageU8 gray_frame(int i) {
  ImageU8 frame(64, 48, 3, static_cast<std::uint8_t>(i % 200 + 16));
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) frame.at(x, y, 0) = static_cast<std::uint8_t>(x + 60);
  }
  return frame;
}

std::array<double, 3> mean_codes(const DecodedImage& image) {
  std::array<double, 3> sum{};
  const ImageU8 codes = codes_of(image);
  for (std::size_t k = 0; k < codes.values().size(); ++k) sum[k % 3] += codes.values()[k];
  for (double& s : sum) s /= static_cast<double>(codes.width()) * codes.height();
  return sum;
}

class OwnMovie : public testing::TestWithParam<const char*> {};

// What lookup, render and export write is what init and ingest read: all frames, the last ones too, which encoders hold
// back, in their colors, in whichever order. 301 frames, an odd number, span several key frames.
TEST_P(OwnMovie, GivesEveryFrameInItsPlaceAndColor) {
  constexpr int kNumFrames = 301;
  constexpr double kCodecLoss =
      2.5;  // Loss of a mean, in codes; neighboring frames differ by 1 and frames 4 apart by more.
  const TempFolder folder;
  const fs::path file = folder / (std::string("own movie") + GetParam());
  write_coded_movie(file, kNumFrames, gray_frame, {.fps = 12.5});
  const ImageInfo info = probe_image(file);
  EXPECT_EQ(info.num_frames, kNumFrames);
  EXPECT_EQ(info.frame_rate, 12.5);
  EXPECT_EQ(std::pair(info.width, info.height), std::pair(64, 48));
  FrameStream stream(file, all_of(kNumFrames));
  const auto expect_frame = [&](int i) {
    const std::array<double, 3> mean = mean_codes(stream.read(i));
    EXPECT_NEAR(mean[0], 60 + 63 / 2.0, kCodecLoss) << GetParam() << " " << i;
    EXPECT_NEAR(mean[1], i % 200 + 16, kCodecLoss) << GetParam() << " " << i;
    EXPECT_NEAR(mean[2], i % 200 + 16, kCodecLoss) << GetParam() << " " << i;
  };
  for (int i = 0; i < kNumFrames; ++i) expect_frame(i);
  FrameStream jumping(file, all_of(kNumFrames));
  for (const int i : {300, 0, 299, 150, 3, 251, 250, 249, 130, 127, 128}) {
    const DecodedImage again = FrameStream(file, {i}).read(i);
    EXPECT_EQ(again.values, jumping.read(i).values) << i;
    EXPECT_NEAR(mean_codes(again)[1], i % 200 + 16, kCodecLoss) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, OwnMovie, testing::Values(".mp4", ".webm"));

TEST(FrameStream, ReadsNoFileThatAPlaylistNames) {
  const TempFolder folder;
  testing_support::write_avi(folder / "secret.avi", make_frames(3), 10);
  write_atomically(folder / "list.mp4", "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nsecret.avi\n#EXT-X-ENDLIST\n");
  write_atomically(folder / "list.mkv", "ffconcat version 1.0\nfile secret.avi\n");
  for (const char* name : {"list.mp4", "list.mkv"}) EXPECT_THROW((void)probe_image(folder / name), IoError) << name;
}

TEST(FrameStream, GivesTheSameFramesToWorkersInAnyOrder) {
  const TempFolder folder;
  const std::vector<ImageU8> frames = make_frames(40);
  testing_support::write_avi(folder / "clip.avi", frames, 10);
  std::vector<int> wanted;
  for (int i = 3; i < 40; i += 2) wanted.push_back(i);
  FrameStream stream(folder / "clip.avi", wanted);
  RunControl control;
  control.num_threads = 6;
  std::atomic<int> num_wrong{0};
  parallel_for(static_cast<std::int64_t>(wanted.size()), 1, control, [&](std::int64_t begin, std::int64_t) {
    const int i = wanted[begin];
    if (!(codes_of(stream.read(i)) == frames[i])) ++num_wrong;
  });
  EXPECT_EQ(num_wrong, 0);
}

TEST(FrameStream, GivesEveryFrameOfAnAnimatedGif) {
  const TempFolder folder;
  std::vector<ImageU8> frames;
  for (int i = 0; i < 5; ++i) {
    ImageU8 frame(32, 16, 3, 0);
    for (int x = 0; x < 32; ++x) {
      for (int y = 0; y < 16; ++y) frame.at(x, y, x / 4 == i ? 0 : 1) = 255;
    }
    frames.push_back(frame);
  }
  ASSERT_TRUE(testing_support::write_animation(folder / "a.gif", frames));
  ASSERT_EQ(probe_image(folder / "a.gif").num_frames, 5);
  FrameStream stream(folder / "a.gif", all_of(5));
  // The writer's palettes are its own; what another process decodes is what this one would.
  ImageDecoder here(folder / "a.gif");
  for (int i = 0; i < 5; ++i) {
    const DecodedImage expected = decoded(here.read(i), here.first_info(), "a.gif");
    EXPECT_EQ(stream.read(i).values, expected.values) << i;
    EXPECT_GT(expected.values.at(4 * i + 1, 8, 0), 0.5f) << i;
  }
}

TEST(FrameStreamRealData, EveryFourthFrameIsThePngThatCameWithTheMovie) {
  PATINATE_REQUIRE_DATA(data, "timelapse/copper_patinating");
  FrameStream stream(data / "copper_patinating.webp", all_of(100));
  for (int i = 0; i < 100; i += 4) {
    char name[32];
    std::snprintf(name, sizeof name, "frame_%03d.png", i);
    const ImageF expected = read_channels(data / "frames_every4" / name, {"R", "G", "B"});
    const ImageF found = stream.read(i).values;
    int num_different = 0;
    for (int y = 0; y < expected.height(); ++y) {
      for (int x = 0; x < expected.width(); ++x) {
        for (int c = 0; c < 3; ++c) num_different += expected.at(x, y, c) != found.at(x, y, c);
      }
    }
    EXPECT_EQ(num_different, 0) << i;
  }
}

TEST(CameraRaw, IsLinearLightOfTheCamerasPrimariesAndTheSameExposureInEveryFrame) {
  const TempFolder folder;
  // Patches, so that demosaicing has nothing to guess inside of them. The second photograph is half as bright.
  for (const float exposure : {1.0f, 0.5f}) {
    ImageF light(96, 64, 3);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 96; ++x) {
        light.at(x, y, 0) = exposure * (x < 48 ? 0.6f : 0.1f);
        light.at(x, y, 1) = exposure * 0.3f;
        light.at(x, y, 2) = exposure * (x < 48 ? 0.05f : 0.5f);
      }
    }
    testing_support::write_dng(folder / "photo.dng", light);
    const ImageInfo info = probe_image(folder / "photo.dng");
    EXPECT_TRUE(info.is_raw);
    const ImageF color = read_color(folder / "photo.dng", Response{});
    ASSERT_EQ(color.width(), 96);
    ASSERT_EQ(color.height(), 64);
    // libraw works in 16 bits, with a matrix of its own digits.
    for (const int x : {20, 75}) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(color.at(x, 30, c), light.at(x, 30, c), 0.004f) << x << " " << c;
    }
  }
}

TEST(DecoderProcess, WhatGoesWrongInADecoderIsOneErrorThatNamesTheFile) {
  const TempFolder folder;
  testing_support::write_avi(folder / "clip.avi", make_frames(3), 10);
  const struct {
    const char* body;
    const char* expected;
  } kCases[] = {{"kill -SEGV $$", "clip.avi: cannot be decoded; its decoder crashed (Segmentation fault)"},
                {"kill -XCPU $$", "clip.avi: cannot be decoded; its decoder did not finish in its time"},
                {"exit 7", "clip.avi: cannot be decoded; its decoder ended early (exit code 7)"},
                {"echo some words that are no answer", "clip.avi: its decoder answered with what makes no sense"},
                {"exec sleep 60", "clip.avi: cannot be decoded; its decoder gave nothing for 0.2 s"}};
  const Environment patience("PATINATE_DECODER_SECONDS", "0.2");
  for (const auto& c : kCases) {
    const Environment decoder("PATINATE_DECODER", write_script(folder, c.body).string());
    const std::string error = read_error(folder / "clip.avi");
    EXPECT_NE(error.find(c.expected), std::string::npos) << c.body << " gave: " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
}

TEST(DecoderProcess, AMissingDecoderSaysSo) {
  const TempFolder folder;
  testing_support::write_avi(folder / "clip.avi", make_frames(3), 10);
  const Environment decoder("PATINATE_DECODER", (folder / "nowhere").string());
  EXPECT_THROW((void)read_color(folder / "clip.avi"), CannotComplete);
}

TEST(DecoderProcess, DamagedMoviesAndRawAreNamed) {
  const TempFolder folder;
  testing_support::write_avi(folder / "whole.avi", make_frames(3), 10);
  ImageF light(64, 64, 3);
  testing_support::write_dng(folder / "whole.dng", light);
  for (const char* extension : {".avi", ".dng"}) {
    const std::string bytes = read_file(folder / (std::string("whole") + extension));
    for (const std::size_t size : {std::size_t{0}, std::size_t{5}, std::size_t{100}, bytes.size() / 2}) {
      const fs::path cut = folder / (std::string("cut") + extension);
      write_atomically(cut, bytes.substr(0, size));
      std::string error;
      try {
        const ImageInfo info = probe_image(cut);
        FrameStream stream(cut, all_of(3));
        for (int i = 0; i < 3; ++i) (void)stream.read(i);
        ADD_FAILURE() << extension << " cut to " << size << " was read, with " << info.num_frames << " images";
      } catch (const IoError& e) {
        error = e.what();
      }
      EXPECT_TRUE(error.starts_with(cut.string() + ": ")) << error;
    }
  }
}

}  // namespace
}  // namespace patinate
