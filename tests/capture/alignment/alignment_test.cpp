#include "capture/alignment/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "capture/timelapse/ingest.h"
#include "datasets_synthetic/crackle_io.h"
#include "libcommon/core/files.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate::capture {
namespace {

namespace fs = std::filesystem;

ImageF light_of(const ImageF& color) {
  ImageF light(color.width(), color.height());
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) light.at(x, y) = luminance(color.pixel(x, y));
  }
  return light;
}

/// Largest distance of an image's corners in the reference.
double corner_error(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b, int width, int height) {
  double worst = 0.0;
  for (const double x : {0.0, width - 1.0}) {
    for (const double y : {0.0, height - 1.0}) {
      const Eigen::Vector3d p = a * Eigen::Vector3d(x, y, 1.0), q = b * Eigen::Vector3d(x, y, 1.0);
      worst = std::max(worst, (p.head<2>() / p.z() - q.head<2>() / q.z()).norm());
    }
  }
  return worst;
}

/// Turned by `degrees`, `scale` times as large, in perspective, about the middle.
Eigen::Matrix3d view(double degrees, double scale, double perspective, int width, int height) {
  const double angle = degrees * M_PI / 180.0;
  Eigen::Matrix3d to_middle = Eigen::Matrix3d::Identity(), turn = Eigen::Matrix3d::Identity();
  to_middle(0, 2) = -0.5 * width;
  to_middle(1, 2) = -0.5 * height;
  turn.topLeftCorner<2, 2>() << scale * std::cos(angle), -scale * std::sin(angle), scale * std::sin(angle),
      scale * std::cos(angle);
  turn(0, 2) = 12.3;
  turn(1, 2) = -7.6;
  turn(2, 0) = perspective;
  turn(2, 1) = -0.6 * perspective;
  Eigen::Matrix3d h = to_middle.inverse() * turn * to_middle;
  return h / h(2, 2);
}

class CrackleAlignment : public testing::Test {
 protected:
  void SetUp() override { make(options(), "crackle"); }
  void make(const datasets::CrackleOptions& options, const std::string& name) {
    (void)run_job(datasets::plan_crackle(options, folder_ / name), {}, {});
    frame_ = light_of(read_color(folder_ / name / "frames/0005.png"));
    backlight_ = light_of(read_color(folder_ / name / "backlight.png"));
  }
  static datasets::CrackleOptions options() {
    datasets::CrackleOptions o;
    o.width = 360;
    o.height = 300;
    o.num_frames = 6;
    return o;
  }
  testing_support::TempFolder folder_;
  ImageF frame_, backlight_;
};

TEST_F(CrackleAlignment, FindsAKnownViewToHalfAPixelAtTheCorners) {
  const struct {
    double degrees, scale, perspective, noise;
  } kCases[] = {{0, 1.0, 0, 0}, {7, 0.9, 1e-4, 0}, {-25, 1.2, -2e-4, 0.01}, {170, 0.8, 1e-4, 0.01}};
  for (int seed = 1; seed <= 2; ++seed) {
    datasets::CrackleOptions large = options();
    large.width = 480;
    large.height = 400;
    large.seed = static_cast<decltype(large.seed)>(seed);
    make(large, "seed" + std::to_string(seed));
    for (const auto& c : kCases) {
      const Eigen::Matrix3d image_from_reference =
          view(c.degrees, c.scale, c.perspective, frame_.width(), frame_.height());
      ImageF image = warp_image(backlight_, image_from_reference, frame_.width(), frame_.height()).values;
      RandomStream random(7, 0);
      for (float& v : image.values())
        v = std::max(0.0f, v + static_cast<float>(c.noise * (random.uniform() + random.uniform() - 1.0)));
      const ImageAlignment found = align_images(frame_, image);
      ASSERT_EQ(found.status, AlignmentStatus::Converged) << c.degrees << ": " << alignment_status_text(found.status);
      EXPECT_LT(
          corner_error(found.reference_from_image, image_from_reference.inverse(), frame_.width(), frame_.height()),
          0.5)
          << c.degrees;
      EXPECT_GT(found.num_inliers, 30);
      EXPECT_LT(found.residual_px, 2.0);
    }
  }
}

TEST_F(CrackleAlignment, ThicknessFromAnotherPoseIsThatFromTheFramesPose) {
  const fs::path folder = folder_ / "crackle";
  const auto thickness = [&](const std::string& photo, const std::string& blank, const std::string& align) {
    write_atomically(folder / "capture.json",
                     R"({"format": "patinate.capture", "version": 1, "name": "crackle", "kind": "fixed",
                        "frames": {"pattern": "frames/*.png", "interval": 1}, "scale": 0.5, "transmission": {"photo": ")" +
                         photo + R"(", "blank": ")" + blank + R"(", "align": )" + align + "}}");
    (void)run_job(plan_ingest(read_capture_project(folder / "capture.json"), {}, folder / align.substr(1, 4)), {}, {});
    return HistoryReader(folder / align.substr(1, 4));
  };
  const HistoryReader same = thickness("backlight.png", "backlight_blank.png", "\"none\"");
  const Eigen::Matrix3d image_from_reference = view(7, 0.8, 1e-4, frame_.width(), frame_.height());
  for (const std::string name : {"backlight", "backlight_blank"}) {
    write_srgb8(
        folder / (name + "_turned.png"),
        warp_image(read_color(folder / (name + ".png")), image_from_reference, frame_.width(), frame_.height()).values);
  }
  const HistoryReader turned = thickness("backlight_turned.png", "backlight_blank_turned.png", "\"auto\"");
  const ImageU8 mask = turned.read_mask();
  const auto physical = [](const HistoryReader& history, int x, int y) {
    const ControlFacts& c = history.control("thickness");
    return c.low + static_cast<double>(history.read_control("thickness").at(x, y)) * (c.high - c.low);
  };
  // Only ratios mean something, and the ranges are those of different masks.
  const double there = physical(turned, 90, 75) / physical(same, 90, 75);
  for (const auto& [x, y] : {std::pair{40, 40}, {120, 50}, {60, 110}, {140, 100}}) {
    ASSERT_EQ(mask.at(x, y), 255);
    EXPECT_NEAR(physical(turned, x, y) / physical(same, x, y) / there, 1.0, 0.03) << x << " " << y;
  }
}

TEST_F(CrackleAlignment, RefusesPhotographsOfOtherThings) {
  datasets::CrackleOptions other = options();
  other.seed = 99;
  (void)run_job(datasets::plan_crackle(other, folder_ / "other"), {}, {});
  EXPECT_NE(align_images(frame_, light_of(read_color(folder_ / "other/backlight.png"))).status,
            AlignmentStatus::Converged);
  ImageF flat(200, 200);
  for (float& v : flat.values()) v = 0.5f;
  EXPECT_EQ(align_images(frame_, flat).status, AlignmentStatus::TooFewDetails);
}

TEST(AlignPoints, FourPairsGiveTheirHomography) {
  const Eigen::Matrix3d truth = view(30, 1.3, 3e-4, 640, 480);
  std::vector<PointPair> pairs;
  for (const auto& [x, y] : {std::pair{3.0, 8.0}, {600.0, 20.0}, {580.0, 470.0}, {12.0, 440.0}}) {
    const Eigen::Vector3d p = truth * Eigen::Vector3d(x, y, 1.0);
    pairs.push_back({{x, y}, p.head<2>() / p.z()});
  }
  EXPECT_LT(corner_error(align_points(pairs).reference_from_image, truth, 640, 480), 1e-2);  // Points are floats.
  pairs[2] = {{301.5, 14.0}, {400.0, 14.0}};
  pairs[1] = {{600.0, 20.0}, {600.0, 20.0}};  // Three on a line.
  EXPECT_THROW((void)align_points(pairs), InvalidInput);
  pairs.pop_back();
  EXPECT_THROW((void)align_points(pairs), InvalidInput);
}

TEST(WarpImage, AShiftMovesPixelsAndLeavesAnEdgeUncovered) {
  ImageF image(20, 10);
  for (int x = 0; x < 20; ++x) {
    for (int y = 0; y < 10; ++y) image.at(x, y) = static_cast<float>(x + 20 * y);
  }
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = 3;
  const WarpedImage warped = warp_image(image, shift, 20, 10);
  EXPECT_EQ(warped.coverage.at(2, 5), 0);
  EXPECT_EQ(warped.values.at(2, 5), 0.0f);
  EXPECT_EQ(warped.coverage.at(3, 5), 255);
  EXPECT_NEAR(warped.values.at(10, 5), image.at(7, 5), 1e-3f);
}

}  // namespace
}  // namespace patinate::capture
