#include "libcommon/geometry/camera_text_io.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <opencv2/core/persistence.hpp>
#include <string>

#include "libcommon/core/files.h"
#include "libcommon/geometry/opencv_file.h"
#include "patinate/core/error.h"
#include "patinate/geometry/camera_io.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::TempFolder;

constexpr double kTextRounding = 1e-12;

// Written by COLMAP 3.8 (`colmap model_converter --output_type TXT`) from a model with these values.
const char* const kColmapCameras = R"(# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
# Number of cameras: 4
1 PINHOLE 640 480 700.25 690.5 320.5 240.5
2 OPENCV 1024 768 900.125 901 511.75 383.25 -0.20999999999999999 0.080000000000000002 0.0015 -0.00089999999999999998
3 SIMPLE_RADIAL 800 600 750 400 300 -0.050000000000000003
4 OPENCV_FISHEYE 800 600 750 750 400 300 0.01 0.02 0.029999999999999999 0.040000000000000001
)";
const char* const kColmapImages = R"(# Image list with two lines of data per image:
#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME
#   POINTS2D[] as (X, Y, POINT3D_ID)
# Number of images: 4, mean observations per image: 0.5
1 0.89999999999238756 0.099999999999154168 -0.19999999999830834 0.37416573869683517 12 -7 150 1 first.png
100.5 200.25 1 300 400 -1
2 1 0 0 0 0 0 100 2 second.png

3 0.5 0.5 0.5 0.5 1 2 3 3 sub/third.jpg
10 20 1
4 1 0 0 0 0 0 1 4 fish.jpg

)";
// Our numbers in the layout of the multi-view benchmark's files: fixed point, 20 digits of the rotation.
const char* const kMiddlebury = R"(2
dish0001.png 3300.500000 0.000000 316.750000 0.000000 3325.500000 200.250000 0.000000 0.000000 1.000000 1.00000000000000000000 0.00000000000000000000 0.00000000000000000000 0.00000000000000000000 -1.00000000000000000000 0.00000000000000000000 0.00000000000000000000 0.00000000000000000000 -1.00000000000000000000 -0.0104 -0.0294 0.673
dish0002.png 3300.500000 0.000000 316.750000 0.000000 3325.500000 200.250000 0.000000 0.000000 1.000000 0.36000000000000000000 0.48000000000000000000 -0.80000000000000000000 -0.80000000000000000000 0.60000000000000000000 0.00000000000000000000 0.48000000000000000000 0.64000000000000000000 0.60000000000000000000 0.25 -0.5 0.75
)";

struct ColmapModel {
  explicit ColmapModel(const std::string& cameras = kColmapCameras, const std::string& images = kColmapImages) {
    write_atomically(folder / "cameras.txt", cameras);
    write_atomically(folder / "images.txt", images);
  }
  TempFolder folder;
};

TEST(ColmapCamera, ReadsEveryLensModelOfAFileThatColmapWrote) {
  const ColmapModel model;
  const CameraParameters pinhole = read_colmap_camera(model.folder.path(), "first.png");
  EXPECT_EQ(pinhole.width, 640);
  EXPECT_EQ(pinhole.fx, 700.25);
  EXPECT_EQ(pinhole.fy, 690.5);
  // The center of COLMAP's first pixel is (0.5, 0.5), that of ours (0, 0).
  EXPECT_EQ(pinhole.cx, 320.0);
  EXPECT_EQ(pinhole.cy, 240.0);
  const Eigen::Matrix3d turn = Eigen::Quaterniond(0.9, 0.1, -0.2, 0.3741657387).normalized().toRotationMatrix();
  EXPECT_LT((pinhole.rotation - turn).norm(), 1e-9);
  EXPECT_EQ(pinhole.translation, Vec3(12, -7, 150));
  const CameraParameters opencv = read_colmap_camera(model.folder / "images.txt", "second.png");
  EXPECT_EQ(opencv.distortion, (std::array<double, 5>{-0.21, 0.08, 1.5e-3, -0.9e-3, 0}));
  EXPECT_EQ(opencv.fy, 901.0);
  const CameraParameters radial = read_colmap_camera(model.folder.path(), "third.jpg");
  EXPECT_EQ(radial.fy, 750.0);
  EXPECT_EQ(radial.distortion, (std::array<double, 5>{-0.05, 0, 0, 0, 0}));
  EXPECT_LT((radial.rotation * Vec3(1, 2, 3) - Vec3(3, 1, 2)).norm(), kTextRounding);
}

TEST(ColmapCamera, NamesWhatItCannotRead) {
  const ColmapModel model;
  const auto error = [&](const char* image) {
    return error_of<IoError>([&] { (void)read_colmap_camera(model.folder.path(), image); });
  };
  EXPECT_TRUE(has(error("fish.jpg"), "cameras.txt: line 7: the lens model `OPENCV_FISHEYE` is not read"));
  EXPECT_TRUE(has(error("other.jpg"), "no image `other.jpg`; expected one of first.png, second.png"));
  EXPECT_TRUE(has(error(""), "several images"));
  const auto changed = [](const std::string& cameras, const std::string& images) {
    const ColmapModel bad(cameras, images);
    return error_of<IoError>([&] { (void)read_colmap_camera(bad.folder.path()); });
  };
  EXPECT_TRUE(has(changed(kColmapCameras, "1 1 0 0 0 0 0 1 9 a.png\n\n"), "no camera 9"));
  EXPECT_TRUE(has(changed(kColmapCameras, "1 1 0 0 0 0 0 1 1\n\n"), "line 1: expected IMAGE_ID"));
  EXPECT_TRUE(has(changed(kColmapCameras, "1 2 0 0 0 0 0 1 1 a.png\n\n"), "length 1"));
  EXPECT_TRUE(has(changed("1 PINHOLE 640 480 700 700 320\n", "1 1 0 0 0 0 0 1 1 a.png\n\n"), "line 1: ends too early"));
  EXPECT_TRUE(has(changed("1 PINHOLE 0 480 700 700 320 240\n", "1 1 0 0 0 0 0 1 1 a.png\n\n"), "out of range"));
  EXPECT_EQ(changed("1 PINHOLE 640 480 700 700 320 240\n", "1 1 0 0 0 0 0 1 1 a.png"), "");
}

TEST(MiddleburyCamera, ReadsMatricesRowByRow) {
  const TempFolder folder;
  write_atomically(folder / "dish_par.txt", kMiddlebury);
  const CameraParameters p = read_middlebury_camera(folder / "dish_par.txt", "dish0002.png", 640, 480);
  EXPECT_EQ(p.fx, 3300.5);
  EXPECT_EQ(p.cx, 316.75);
  EXPECT_EQ(p.cy, 200.25);
  EXPECT_LT((p.rotation.row(0) - Eigen::RowVector3d(0.36, 0.48, -0.8)).norm(), kTextRounding);
  // P = K [R t], as the benchmark's page has it, for a point in front of the camera.
  const Vec3 world(0.01, 0.02, 0.03), seen = p.rotation * world + Vec3(0.25, -0.5, 0.75);
  const auto pixel = Camera(p).project(world);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 3300.5 * seen.x() / seen.z() + 316.75, 1e-9);
  EXPECT_NEAR(pixel->y(), 3325.5 * seen.y() / seen.z() + 200.25, 1e-9);
}

TEST(MiddleburyCamera, MistakesAreNamedWithTheirLine) {
  const TempFolder folder;
  const auto error = [&](const std::string& text) {
    write_atomically(folder / "a_par.txt", text);
    return error_of<IoError>([&] { (void)read_middlebury_camera(folder / "a_par.txt", "", 640, 480); });
  };
  const std::string rest = " 3300 0 316 0 3300 200 0 0 1 1 0 0 0 1 0 0 0 1 0 0 1\n";
  EXPECT_EQ(error("1\na.png" + rest), "");
  EXPECT_TRUE(has(error("2\na.png" + rest), "says 2 images, but 1 follow"));
  EXPECT_TRUE(has(error("a.png" + rest), "line 1: expected the number of images first"));
  EXPECT_TRUE(has(error("1\na.png 3300 0 316 0 3300 200 0 0 1 1 0 0 0 1 0 0 0 1 0 0\n"), "line 2: ends too early"));
  EXPECT_TRUE(has(error("1\na.png 3300 5 316 0 3300 200 0 0 1 1 0 0 0 1 0 0 0 1 0 0 1\n"), "K is not"));
  EXPECT_TRUE(has(error("1\na.png 3300 0 316 0 3300 200 0 0 1 1 0 0 0 1 0 0 0 -1 0 0 1\n"), "R is no rotation"));
  EXPECT_TRUE(has(error("1\na.png 3300 0 x16 0 3300 200 0 0 1 1 0 0 0 1 0 0 0 1 0 0 1\n"), "`x16` is no number"));
}

TEST(CameraIo, OneImageOfSeveralIsChosenInTheProject) {
  const ColmapModel model;
  write_atomically(model.folder / "dish_par.txt", kMiddlebury);
  const auto camera = [&](const std::string& text) {
    const Json json = Json::parse(text);
    return read_camera(JsonReader((model.folder / "capture.json").string(), json), 1000.0);
  };
  EXPECT_EQ(camera(R"({"file": "images.txt", "image": "second.png"})").parameters().translation, Vec3(0, 0, 100000));
  EXPECT_EQ(
      camera(R"({"file": "dish_par.txt", "image": "dish0001.png", "width": 640, "height": 480})").parameters().height,
      480);
  EXPECT_TRUE(
      has(error_of<IoError>([&] { (void)camera(R"({"file": "dish_par.txt", "image": "dish0001.png"})"); }), "width"));
}

TEST(CameraIo, WhatWeWriteOpenCvReads) {
  const TempFolder folder;
  CameraParameters p;
  p.width = 640, p.height = 480;
  p.fx = 700, p.fy = 2.0 / 3.0, p.cx = 1e6, p.cy = -236.25;
  p.distortion = {-0.21, 0, 1.5e-300, 0, 3};
  p.rotation = Eigen::AngleAxisd(0.7, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  p.translation = {12, -7, 1e-9};
  const Camera camera(p);
  write_atomically(folder / "own.yml", opencv_text(camera));
  EXPECT_EQ(read_camera(folder / "own.yml").text(), camera.text());
  const cv::FileStorage storage((folder / "own.yml").string(), cv::FileStorage::READ);
  cv::Mat k, t;
  storage["camera_matrix"] >> k;
  storage["translation"] >> t;
  EXPECT_EQ(k.at<double>(1, 1), 2.0 / 3.0);
  EXPECT_EQ(k.at<double>(0, 2), 1e6);
  EXPECT_EQ(t.at<double>(0, 0), 12.0);
}

TEST(CameraIo, ACalibrationOfOursSaysItsUnit) {
  const TempFolder folder;
  CameraParameters p;
  p.width = 640, p.height = 480;
  p.fx = p.fy = 700, p.cx = 320, p.cy = 240;
  p.translation = {1, 2, 3};
  Json json{{"format", "patinate.calibration"}, {"version", 1}, {"unit", "cm"}};
  json["camera"] = json_of(Camera(p));
  save_json(folder / "camera.json", json);
  EXPECT_EQ(read_camera(folder / "camera.json", 1000.0).parameters().translation, Vec3(10, 20, 30));
}

TEST(OpenCvFile, NestingHiddenInStringsAndCommentsDoesNotMatter) {
  const TempFolder folder;
  const std::string deep(400'000, '[');
  const auto reads = [&](const char* name, const std::string& text) {
    write_atomically(folder / name, text);
    return OpenCvFile(folder / name).numbers("a").value_or(std::vector<double>());
  };
  EXPECT_EQ(reads("a.yml", "%YAML:1.0\n---\nb: \"" + deep + "\"\na: [1, 2.5] # " + deep + "\n"),
            (std::vector<double>{1, 2.5}));
  EXPECT_EQ(
      reads("a.yml", "%YAML:1.0\n---\nb: " + deep.substr(0, 50) + std::string(50, ']') + "\na:\n   - 1\n   - +2.\n"),
      (std::vector<double>{1, 2}));
  std::string bullets = "%YAML:1.0\n---\na: 7\nb:\n", tags = "<?xml version=\"1.0\"?><opencv_storage><!-- ";
  for (int i = 0; i < 100'000; ++i) bullets += " - ", tags += "<a>";
  EXPECT_EQ(reads("a.yml", bullets), (std::vector<double>{7}));
  EXPECT_EQ(reads("a.xml", tags + " --><a>1 2</a></opencv_storage>"), (std::vector<double>{1, 2}));
  EXPECT_TRUE(has(error_of<IoError>([&] { (void)reads("a.xml", tags + " --><a><b><c>" + tags.substr(40)); }),
                  "no OpenCV calibration"));
}

TEST(OpenCvFile, ReadsEveryFormThatOpenCvWrites) {
  const TempFolder folder;
  for (const char* name : {"a.yml", "a.xml", "a.json"}) {
    cv::FileStorage storage((folder / name).string(), cv::FileStorage::WRITE);
    cv::Mat m(2, 3, CV_64F);
    for (int i = 0; i < 6; ++i) m.at<double>(i / 3, i % 3) = 0.1 * i - 0.25;
    storage << "date"
            << "Tue 05 Nov: [not a list]"
            << "matrix" << m << "list"
            << "[" << 1 << 2.5 << "]"
            << "count" << 3;
    storage << "points"
            << "{"
            << "x" << 1 << "inner"
            << "{"
            << "y" << 2 << "}"
            << "}";
    storage.release();
    const OpenCvFile file(folder / name);
    const auto matrix = file.numbers("matrix");
    ASSERT_TRUE(matrix) << name;
    ASSERT_EQ(matrix->size(), 6u);
    for (int i = 0; i < 6; ++i) EXPECT_EQ((*matrix)[i], 0.1 * i - 0.25);
    EXPECT_EQ(file.numbers("list"), (std::vector<double>{1, 2.5})) << name;
    EXPECT_EQ(file.numbers("count"), (std::vector<double>{3})) << name;
    EXPECT_FALSE(file.numbers("points")) << name;
    EXPECT_FALSE(file.numbers("date")) << name;
  }
}

TEST(OpenCvFile, AMatrixOfAnotherSizeIsRefused) {
  const TempFolder folder;
  write_atomically(folder / "a.yml",
                   "%YAML:1.0\n---\na: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1, 2 ]\n");
  EXPECT_FALSE(OpenCvFile(folder / "a.yml").numbers("a"));
}

}  // namespace
}  // namespace patinate
