#include "capture/stability/frame_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libcommon/core/files.h"
#include "libcommon/core/median.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tests/capture/timelapse/ingest_folder.h"
#include "tests/support/temp_folder.h"

namespace patinate::capture {
namespace {

constexpr int kNoiseSide = 48;

/// A camera: variance = read + photon * light.
struct Camera {
  double read = 0.0, photon = 0.0;
};

/// How the surface ages at a place, from 0 to 1.
enum class Aging { None, Slow, Sudden };

struct Series {
  std::vector<double> times;
  std::vector<ImageF> truth, frames;
};

Series photograph(int num_frames, const Camera& camera, Aging aging, std::uint64_t seed) {
  RandomStream random(seed, 0);
  Series series;
  for (int i = 0; i < num_frames; ++i) {
    series.times.push_back(i + 0.3 * std::sin(2.0 * i));
    const double time = static_cast<double>(i) / (num_frames - 1);
    ImageF truth(kNoiseSide, kNoiseSide, 3), frame(kNoiseSide, kNoiseSide, 3);
    for (int y = 0; y < kNoiseSide; ++y) {
      for (int x = 0; x < kNoiseSide; ++x) {
        // A crack in every twelfth column opens at a time of its own.
        const bool has_crack = aging == Aging::Sudden && x % 12 == 5 && time > 0.1 + 0.8 * y / kNoiseSide;
        const double age = aging == Aging::Slow ? 0.5 * (1.0 - std::cos(3.1 * time)) : 0.0;
        for (int c = 0; c < 3; ++c) {
          const double fresh = 0.1 + 0.6 * x / kNoiseSide, aged = 0.25 - 0.05 * c;
          const double color = has_crack ? 0.03 : fresh + age * (aged - fresh);
          truth.at(x, y, c) = static_cast<float>(color);
          frame.at(x, y, c) =
              static_cast<float>(color + std::sqrt(camera.read + camera.photon * color) * random.normal());
        }
      }
    }
    series.truth.push_back(std::move(truth));
    series.frames.push_back(std::move(frame));
  }
  return series;
}

/// 1.4826 times the median of |frame - truth| / deviation over all frames.
double robust_z(const Series& series) {
  const SeriesNoise noise = estimate_noise(series.times, [&](int i) { return series.frames[i]; });
  std::vector<double> sizes;
  for (std::size_t f = 0; f < series.frames.size(); ++f) {
    const ImageF deviation = noise.deviation_of(series.frames[f]);
    for (std::int64_t i = 0; i < 3 * deviation.num_pixels(); ++i) {
      sizes.push_back(std::abs(static_cast<double>(series.frames[f].data()[i] - series.truth[f].data()[i])) /
                      static_cast<double>(deviation.data()[i]));
    }
  }
  return 1.4826 * median(std::move(sizes));
}

TEST(FrameNoise, DeviationsAreHonestForAnyCameraAndAging) {
  // 0.8 to 1.25 is what goals.md asks of stated deviations.
  for (const Camera& camera : {Camera{1e-4, 0.0}, Camera{1e-6, 4e-4}, Camera{2e-5, 1e-4}}) {
    for (Aging aging : {Aging::None, Aging::Slow, Aging::Sudden}) {
      for (int num_frames : {kMinForNoise, 12, 40}) {
        const double z = robust_z(photograph(num_frames, camera, aging, 7));
        EXPECT_GT(z, 0.8) << camera.photon << " " << static_cast<int>(aging) << " " << num_frames;
        EXPECT_LT(z, 1.25) << camera.photon << " " << static_cast<int>(aging) << " " << num_frames;
      }
    }
  }
}

TEST(FrameNoise, PhotonNoiseFollowsTheColorOfTheFrame) {
  // Aging to a quarter of the light halves the deviation of photon noise.
  Series series = photograph(20, {0.0, 4e-4}, Aging::Slow, 8);
  const SeriesNoise noise = estimate_noise(series.times, [&](int i) { return series.frames[i]; });
  const ImageF first = noise.deviation_of(series.truth.front()), last = noise.deviation_of(series.truth.back());
  const double expected =
      std::sqrt(static_cast<double>(series.truth.back().at(44, 20, 1) / series.truth.front().at(44, 20, 1)));
  EXPECT_NEAR(static_cast<double>(last.at(44, 20, 1) / first.at(44, 20, 1)), expected, 0.1 * expected);
}

TEST(FrameNoise, RefusesFewFramesAndOtherSizes) {
  Series series = photograph(4, {1e-4, 0.0}, Aging::None, 1);
  const auto read = [&](int i) { return series.frames[i]; };
  EXPECT_THROW((void)estimate_noise(series.times, read), InvalidInput);
  series = photograph(6, {1e-4, 0.0}, Aging::None, 1);
  series.frames[4] = ImageF(3, 3, 3);
  EXPECT_THROW((void)estimate_noise(series.times, read), InvalidInput);
}

TEST(IngestDeviations, AreWrittenWithTheFramesWhenAskedFor) {
  const testing_support::TempFolder folder;
  const Series series = photograph(6, {1e-5, 1e-5}, Aging::Slow, 3);
  std::filesystem::create_directories(folder / "frames");
  for (std::size_t i = 0; i < series.frames.size(); ++i)
    write_codes(folder / "frames" / (std::to_string(i) + ".png"), srgb8_from_linear(series.frames[i]));
  write_atomically(folder / "capture.json", R"({"format": "patinate.capture", "version": 1, "name": "noise",
    "kind": "fixed", "frames": {"pattern": "frames/*.png", "interval": 1}})");
  IngestOptions options;
  options.add_deviations = true;
  const HistoryReader history = testing_support::ingest(folder.path(), options);
  const auto deviation = history.read_frame_extra(2, "stddev");
  ASSERT_TRUE(deviation);
  EXPECT_EQ(deviation->channels(), 3);
  // Read noise and photons; 8-bit codes add a twelfth of a code squared, which is less.
  const double expected = std::sqrt(1e-5 + 1e-5 * static_cast<double>(series.truth[2].at(20, 20, 1)));
  EXPECT_NEAR(static_cast<double>(deviation->at(20, 20, 1)), expected, 0.4 * expected);
  const auto of_progress = history.read_control_deviation("progress");
  ASSERT_TRUE(of_progress);
  EXPECT_GT(*std::max_element(of_progress->values().begin(), of_progress->values().end()), 0.0f);
}

}  // namespace
}  // namespace patinate::capture
