#include "patinate/geometry/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core/persistence.hpp>
#include <random>
#include <string>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/geometry/camera_io.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::TempFolder;

CameraParameters lens() {
  CameraParameters p;
  p.width = 640, p.height = 480;
  p.fx = 700.0, p.fy = 690.0, p.cx = 322.5, p.cy = 236.25;
  p.distortion = {-0.21, 0.08, 1.5e-3, -0.9e-3, -0.012};
  p.rotation = Eigen::AngleAxisd(0.7, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  p.translation = {12.0, -7.0, 150.0};
  return p;
}

TEST(Camera, RaysLeadBackToTheirPixels) {
  const Camera camera(lens());
  constexpr double kTolerancePx = 1e-6;
  for (int y = -5; y < 490; y += 11) {
    for (int x = -5; x < 650; x += 13) {
      const Vec2 pixel(x + 0.25, y);
      const auto ray = camera.ray(pixel);
      ASSERT_TRUE(ray);
      EXPECT_NEAR(ray->direction.norm(), 1.0, 1e-14);
      for (double distance : {1.0, 150.0, 4000.0}) {
        const auto seen = camera.project(ray->origin + distance * ray->direction);
        ASSERT_TRUE(seen);
        EXPECT_LT((*seen - pixel).norm(), kTolerancePx);
      }
    }
  }
}

TEST(Camera, SeesPointsWhereTheFormulaOfOpenCvSaysSo) {
  const CameraParameters p = lens();
  const Camera camera(p);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> side(-30.0, 30.0);
  for (int i = 0; i < 200; ++i) {
    const Vec3 world(side(random), side(random), side(random));
    const auto component = [&](int r) {
      return p.rotation(r, 0) * world[0] + p.rotation(r, 1) * world[1] + p.rotation(r, 2) * world[2] + p.translation[r];
    };
    // Formula of OpenCV's documentation of projectPoints, term by term.
    const double x = component(0) / component(2), y = component(1) / component(2), r = std::hypot(x, y);
    const double k1 = -0.21, k2 = 0.08, p1 = 1.5e-3, p2 = -0.9e-3, k3 = -0.012;
    const double radial = 1 + k1 * std::pow(r, 2) + k2 * std::pow(r, 4) + k3 * std::pow(r, 6);
    const double u = 700.0 * (x * radial + 2 * p1 * x * y + p2 * (r * r + 2 * x * x)) + 322.5;
    const double v = 690.0 * (y * radial + p1 * (r * r + 2 * y * y) + 2 * p2 * x * y) + 236.25;
    const auto seen = camera.project(world);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x(), u, 1e-9);
    EXPECT_NEAR(seen->y(), v, 1e-9);
  }
}

TEST(Camera, SeesNothingBehindItOrWhereTheLensModelFoldsBack) {
  CameraParameters p = lens();
  p.rotation.setIdentity();
  p.translation.setZero();
  p.distortion = {-0.5, 0, 0, 0, 0};  // r (1 - r^2 / 2) rises up to r = sqrt(2 / 3), where it is 0.544.
  const Camera camera(p);
  EXPECT_FALSE(camera.project({0, 0, -1}));
  EXPECT_FALSE(camera.project({0, 0, 0}));
  EXPECT_TRUE(camera.project({0.816, 0, 1}));
  EXPECT_FALSE(camera.project({0.817, 0, 1}));
  EXPECT_TRUE(camera.ray({322.5 + 0.544 * 700.0, 236.25}));
  EXPECT_FALSE(camera.ray({322.5 + 0.545 * 700.0, 236.25}));
}

TEST(Camera, ScalesWithItsWorld) {
  const Camera camera(lens()), scaled = camera.scaled(1000.0);
  EXPECT_LT((scaled.center() - 1000.0 * camera.center()).norm(), 1e-7);
  EXPECT_LT((*scaled.project({3000, -4000, 5000}) - *camera.project({3, -4, 5})).norm(), 1e-9);
}

// Newton's search halves its start until it is within the lens, and half of infinity is infinite: at the ends of what
// is allowed it still ends.
TEST(Camera, RaysOfExtremeCamerasEnd) {
  const CameraParameters plain = lens();
  for (const double f : {0.64, 6.4e8}) {
    for (const double c : {-6.4e6, 6.4e6}) {
      for (const double k : {-1e12, 0.0, 1e12}) {
        CameraParameters p = plain;
        p.fx = p.fy = f, p.cx = p.cy = c, p.distortion = {k, -k, 0, 0, k};
        const auto ray = Camera(p).ray({0, 639});
        if (ray) {
          EXPECT_NEAR(ray->direction.norm(), 1.0, 1e-12);
        }
      }
    }
  }
  EXPECT_FALSE(Camera(plain).ray({INFINITY, 0}).has_value());
  EXPECT_FALSE(Camera(plain).ray({0, std::nan("")}).has_value());
}

TEST(Camera, RefusesParametersThatAreNoCamera) {
  const auto error = [](auto change) {
    CameraParameters p = lens();
    change(p);
    return error_of([&] { (void)Camera(p); });
  };
  EXPECT_TRUE(has(error([](auto& p) { p.fx = 0; }), "focal lengths"));
  EXPECT_TRUE(has(error([](auto& p) { p.fy = std::nan(""); }), "focal lengths"));
  EXPECT_TRUE(
      has(error([](auto& p) { p.fx = 1e-320; }), "focal lengths 1e-320, 690 are out of range; use 0.64 to 640000000"));
  EXPECT_TRUE(has(error([](auto& p) { p.fy = 1e300; }), "focal lengths"));
  EXPECT_TRUE(has(error([](auto& p) { p.cx = INFINITY; }), "principal point"));
  EXPECT_TRUE(has(error([](auto& p) { p.cy = -1e300; }), "principal point"));
  EXPECT_TRUE(has(error([](auto& p) { p.distortion[0] = 1e300; }), "distortion"));
  EXPECT_TRUE(has(error([](auto& p) { p.translation[2] = -1e300; }), "translation"));
  EXPECT_TRUE(has(error([](auto& p) { p.distortion[4] = INFINITY; }), "distortion"));
  EXPECT_TRUE(has(error([](auto& p) { p.width = 65537; }), "65537"));
  EXPECT_TRUE(has(error([](auto& p) { p.translation[1] = std::nan(""); }), "translation"));
  EXPECT_TRUE(has(error([](auto& p) { p.rotation(0, 0) += 1e-4; }), "orthonormal"));
  EXPECT_TRUE(has(error([](auto& p) { p.rotation.row(0) *= -1; }), "mirrors"));
  EXPECT_EQ(error([](auto& p) { p.rotation(0, 0) += 1e-8; }), "");
}

void write_calibration(const std::filesystem::path& file, const CameraParameters& p, const std::string& without = "") {
  cv::FileStorage storage(file.string(), cv::FileStorage::WRITE);
  const auto matrix = [&](const char* name, int rows, int cols, auto value) {
    cv::Mat m(rows, cols, CV_64F);
    for (int i = 0; i < rows * cols; ++i) m.at<double>(i / cols, i % cols) = value(i);
    if (name != without) storage << name << m;
  };
  if (without != "image_width") storage << "image_width" << p.width;
  storage << "image_height" << p.height;
  const double k[] = {p.fx, 0, p.cx, 0, p.fy, p.cy, 0, 0, 1};
  matrix("camera_matrix", 3, 3, [&](int i) { return k[i]; });
  matrix("distortion_coefficients", 1, 5, [&](int i) { return p.distortion[i]; });
  matrix("rotation", 3, 3, [&](int i) { return p.rotation(i / 3, i % 3); });
  matrix("translation", 3, 1, [&](int i) { return p.translation[i]; });
}

TEST(CameraIo, ReadsWhatOpenCvWrites) {
  const TempFolder folder;
  for (const char* name : {"camera.yml", "camera.xml"}) {
    write_calibration(folder / name, lens());
    EXPECT_EQ(read_camera(folder / name).text(), Camera(lens()).text()) << name;
  }
}

TEST(CameraIo, NamesTheKeyThatIsMissing) {
  const TempFolder folder;
  for (const char* key : {"image_width", "camera_matrix", "distortion_coefficients", "rotation", "translation"}) {
    write_calibration(folder / "camera.yml", lens(), key);
    const std::string error = error_of([&] { (void)read_camera(folder / "camera.yml"); });
    EXPECT_TRUE(has(error, std::string("has no `") + key + "`")) << error;
  }
}

TEST(CameraIo, DamagedFilesAreOneErrorAndNothingIsPrinted) {
  const TempFolder folder;
  testing::internal::CaptureStderr();
  for (const char* name : {"camera.yml", "camera.xml"}) {
    write_calibration(folder / name, lens());
    const std::string bytes = read_file(folder / name);
    for (std::size_t size = 0; size + 20 < bytes.size(); size += 17) {
      write_atomically(folder / name, bytes.substr(0, size));
      const std::string error = error_of([&] { (void)read_camera(folder / name); });
      EXPECT_TRUE(has(error, name)) << size;
      EXPECT_EQ(error.find('\n'), std::string::npos);
    }
    for (std::size_t at = 0; at < bytes.size(); at += 7) {
      std::string flipped = bytes;
      flipped[at] = static_cast<char>(flipped[at] ^ 0x15);
      write_atomically(folder / name, flipped);
      (void)error_of([&] { (void)read_camera(folder / name); });
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(CameraIo, FilesNestedTooDeepAreAnError) {
  const TempFolder folder;
  const std::string head = "%YAML:1.0\n---\nimage_width: ";
  for (const std::string part : {"[", "{a: ", "- ", "a: ", "<a>", "{\"a\":"}) {
    std::string text = part == "<a>" ? "<?xml version=\"1.0\"?>\n<opencv_storage>" : part == "{\"a\":" ? "" : head;
    for (int i = 0; i < 100000; ++i) text += part;
    write_atomically(folder / "camera.yml", text);
    const std::string error = error_of([&] { (void)read_camera(folder / "camera.yml"); });
    EXPECT_TRUE(has(error, "no OpenCV calibration") || has(error, "`image_width` does not hold what it should"))
        << part;
  }
}

TEST(CameraIo, TheInlineFormEqualsTheFile) {
  const TempFolder folder;
  write_calibration(folder / "camera.yml", lens());
  const CameraParameters p = lens();
  const Eigen::AngleAxisd turn(p.rotation);
  const Vec3 axis = turn.angle() * turn.axis();
  Json json{{"width", 640}, {"height", 480}, {"distortion", p.distortion}};
  json["matrix"] = {{700.0, 0, 322.5}, {0, 690.0, 236.25}, {0, 0, 1}};
  json["rotation"] = {axis[0], axis[1], axis[2]};
  json["translation"] = {12.0, -7.0, 150.0};
  const Camera from_file = read_camera(folder / "camera.yml");
  const Camera inline_form = read_camera(JsonReader("capture.json", json));
  EXPECT_LT((*from_file.project({3, 4, 5}) - *inline_form.project({3, 4, 5})).norm(), 1e-9);
  json.erase("translation");
  EXPECT_TRUE(has(error_of([&] { (void)read_camera(JsonReader("capture.json", json)); }), "translation"));
  json["translation"] = {12.0, -7.0, 150.0};
  json["matrix"] = {{700.0, 0.5, 322.5}, {0, 690.0, 236.25}, {0, 0, 1}};
  EXPECT_TRUE(has(error_of([&] { (void)read_camera(JsonReader("capture.json", json)); }), "matrix"));
}

}  // namespace
}  // namespace patinate
