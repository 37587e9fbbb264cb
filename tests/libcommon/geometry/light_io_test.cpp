#include "libcommon/geometry/light_io.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <string>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::has;
using testing_support::TempFolder;

constexpr double kLightRounding = 1e-12;

Camera some_camera() {
  CameraParameters p;
  p.width = 640, p.height = 480;
  p.fx = p.fy = 700, p.cx = 320, p.cy = 240;
  p.rotation = Eigen::AngleAxisd(0.7, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  p.translation = {12.0, -7.0, 150.0};
  return Camera(p);
}

/// The error of reading a file of this text; "" when there is none.
std::string lights_error(const std::string& text, const LightRows& rows = {.frame = LightRows::Frame::Scanner},
                         const char* name = "lights.lp") {
  const TempFolder folder;
  write_atomically(folder / name, text);
  try {
    (void)read_lights(folder / name, 1.0, nullptr, rows);
  } catch (const IoError& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    return e.what();
  }
  return "";
}

TEST(LightIo, DirectionsOfAnLpFileAreTurnedIntoTheScannersFrame) {
  const TempFolder folder;
  write_atomically(folder / "dome.lp",
                   "3\r\nC:\\shots\\a picture 01.jpg 1 0 0\r\nb.jpg\t0 1 0\r\nc.jpg 0.0 0.0 1.0\r\n\r\n");
  const Camera camera = some_camera();
  const std::vector<Light> lights = read_lights(folder / "dome.lp", 1000.0, &camera);
  ASSERT_EQ(lights.size(), 3u);
  EXPECT_EQ(lights[0].name, "C:\\shots\\a picture 01.jpg");
  // Right, up and toward the viewer, in a camera whose y is down and z forward.
  const Eigen::Matrix3d& r = camera.parameters().rotation;
  EXPECT_LT((lights[0].direction - r.row(0).transpose()).norm(), kLightRounding);
  EXPECT_LT((lights[1].direction + r.row(1).transpose()).norm(), kLightRounding);
  EXPECT_LT((lights[2].direction + r.row(2).transpose()).norm(), kLightRounding);
  for (const Light& light : lights) {
    EXPECT_EQ(light.kind, Light::Kind::Directional);
    EXPECT_FALSE(light.is_intensity_known);
  }
}

TEST(LightIo, LpFilesOfVirtualDomesHaveAZeroAfterTheCountAndNumbersForNames) {
  const LightRows rows{.frame = LightRows::Frame::Scanner};
  const TempFolder folder;
  write_atomically(folder / "targets.lp", "2 0 \n0001.png 0.6 0.0000 0.8\n0002.png 0.0000 0.0000 1.0000\n\n");
  EXPECT_EQ(read_lights(folder / "targets.lp", 1.0, nullptr, rows).size(), 2u);
  // Four decimals of a direction at most 3e-5 longer or shorter than 1; a name of digits is no fourth number.
  write_atomically(
      folder / "icosphere.lp",
      "3\n00000001 0.2764 -0.8506 0.4472\n00000002 -0.7236 -0.5257 0.4472\n00000003 0.0 8.03142613720921e-14 1.0\n");
  const std::vector<Light> lights = read_lights(folder / "icosphere.lp", 1.0, nullptr, rows);
  ASSERT_EQ(lights.size(), 3u);
  EXPECT_EQ(lights[1].name, "00000002");
  EXPECT_NEAR(lights[1].direction.x(), -0.7236, 1e-4);
  EXPECT_TRUE(
      has(lights_error("2 1\na 0 0 1 5\nb 0 0 1 6\n"), "expected `NAME x y z`"));  // Further parameters are not known.
  EXPECT_TRUE(has(lights_error("3 0\na 0 0 1\nb 0 0 1\n"), "says 3 lights, but 2 follow"));
}

TEST(LightIo, PositionsOfAnLpFileAreSeenWhereTheCameraPutsThem) {
  const TempFolder folder;
  write_atomically(folder / "dome.lp", "1\na.jpg 0.05 0.02 -0.4\n");
  const Camera camera = some_camera();
  const std::vector<Light> lights =
      read_lights(folder / "dome.lp", 1000.0, &camera, {.kind = LightRows::Kind::Positions});
  // 400 mm in front of the camera, 50 to the right, 20 up: at fx X / Z + cx, and above the center.
  const auto seen = camera.project(lights[0].position);
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->x(), 700.0 * 50 / 400 + 320, 1e-9);
  EXPECT_NEAR(seen->y(), 700.0 * -20 / 400 + 240, 1e-9);
}

TEST(LightIo, LpFilesReadBack) {
  const TempFolder folder;
  const Camera camera = some_camera();
  std::vector<Light> lights(2);
  for (Light& light : lights) light.kind = Light::Kind::Directional;
  lights[0].direction = Vec3(0.1, -0.7, 0.4).normalized(), lights[0].name = "first.png";
  lights[1].direction = Vec3(-3, 2, 1).normalized();
  write_atomically(folder / "own.lp", lp_text(lights, camera));
  const std::vector<Light> back = read_lights(folder / "own.lp", 1.0, &camera);
  ASSERT_EQ(back.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_LT((back[i].direction - lights[i].direction).norm(), kLightRounding);
  EXPECT_EQ(back[0].name, "first.png");
}

TEST(LightIo, TablesByRowsAndByColumnsHoldTheSameLights) {
  const TempFolder folder;
  write_atomically(folder / "rows.txt", "# x y z\n0.6 0 0.8\n0 -0.6 0.8\n0 0 1\n0.36 0.48 0.8\n");
  write_atomically(folder / "columns.txt", " 0.6 0 0 0.36\n 0 -0.6 0 0.48\n 0.8 0.8 1 0.8\n");
  const LightRows rows{.frame = LightRows::Frame::Scanner};
  const std::vector<Light> a = read_lights(folder / "rows.txt", 1, nullptr, rows),
                           b = read_lights(folder / "columns.txt", 1, nullptr, rows);
  ASSERT_EQ(a.size(), 4u);
  ASSERT_EQ(b.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((a[i].direction - b[i].direction).norm(), kLightRounding);
}

TEST(LightIo, ThreeByThreeTablesAreReadTheWayInWhichLightsHaveLengthOne) {
  const TempFolder folder;
  const LightRows rows{.frame = LightRows::Frame::Scanner};
  write_atomically(folder / "columns.txt", "0.6 0 0\n0 0.6 0\n0.8 0.8 1\n");
  EXPECT_LT((read_lights(folder / "columns.txt", 1, nullptr, rows)[1].direction - Vec3(0, 0.6, 0.8)).norm(),
            kLightRounding);
  write_atomically(folder / "rows.txt", "0.6 0 0.8\n0 0.6 0.8\n0 0 1\n");
  EXPECT_LT((read_lights(folder / "rows.txt", 1, nullptr, rows)[1].direction - Vec3(0, 0.6, 0.8)).norm(),
            kLightRounding);
  EXPECT_TRUE(has(lights_error("0.6 -0.8 0\n0.8 0.6 0\n0 0 1\n"), "by rows or by columns"));
  EXPECT_EQ(lights_error("3\n0.6 -0.8 0\n0.8 0.6 0\n0 0 1\n"), "");
}

TEST(LightIo, MistakesAreNamedWithTheirLine) {
  EXPECT_TRUE(has(lights_error(""), "holds no light"));
  EXPECT_TRUE(has(lights_error("2\na 0 0 1\n"), "line 1 says 2 lights, but 1 follow"));
  EXPECT_TRUE(has(lights_error("0\n"), "no number of lights"));
  EXPECT_TRUE(has(lights_error("# dome\n2\na 0 0 1\nb 0 0 0\n"), "line 4: the direction has length 0"));
  EXPECT_TRUE(has(lights_error("2\na 0 0 1\nb 0 0 nan\n"), "line 3"));
  EXPECT_TRUE(has(lights_error("1\na 0 1\n"), "line 2: expected `NAME x y z`"));
  EXPECT_TRUE(has(lights_error("1\na 0 300 400\n"), "length 500; expected 1, or \"kind\": \"positions\""));
  EXPECT_TRUE(has(lights_error("1\na 0 0 1\n", {}), "there is no camera"));
  EXPECT_TRUE(has(lights_error(std::string("1\na 0 0 1\0\n", 11)), "no text file"));
}

TEST(LightIo, TheProjectsFormHasItsUnitAndStrengths) {
  Json json = Json::parse(
      R"([{"position": [0.1, 0.2, 0.3], "intensity": [1e5, 2e5, 3e5], "name": "left"}, {"direction": [0, 3, 4]}])");
  const std::vector<Light> lights = read_lights(JsonReader("capture.json", json), 1000.0);
  EXPECT_LT((lights[0].position - Vec3(100, 200, 300)).norm(), 1e-10);
  EXPECT_EQ(lights[0].intensity, Vec3(1e5, 2e5, 3e5));
  EXPECT_TRUE(lights[0].is_intensity_known);
  EXPECT_EQ(lights[0].name, "left");
  EXPECT_LT((lights[1].direction - Vec3(0, 0.6, 0.8)).norm(), kLightRounding);
  EXPECT_FALSE(lights[1].is_intensity_known);
  json = json_of(lights);
  EXPECT_EQ(read_lights(JsonReader("again.json", json), 1.0)[0].position, lights[0].position);
}

TEST(LightIo, StrengthsOfSomeLightsAloneAreRefused) {
  const auto error = [](const char* text) {
    const Json json = Json::parse(text);
    const JsonReader reader("capture.json", json, "/lights");
    try {
      expect_strengths_of_all_or_none(read_lights(reader, 1.0), reader);
    } catch (const IoError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const std::string said = error(R"([{"position": [1,2,3], "intensity": [1,1,1]}, {"position": [1,2,4]}])");
  EXPECT_TRUE(has(said, "capture.json: /lights") && has(said, "an `intensity` of light 1 too")) << said;
  EXPECT_EQ(error(R"([{"position": [1,2,3]}, {"position": [1,2,4]}])"), "");
  EXPECT_EQ(error(R"([{"position": [1,2,3], "intensity": [1,1,1]}])"), "");
}

TEST(LightIo, BadProjectLightsAreRefused) {
  const auto error = [](const char* text) {
    const Json json = Json::parse(text);
    try {
      (void)read_lights(JsonReader("capture.json", json, "/lights"), 1.0);
    } catch (const IoError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_TRUE(has(error(R"([])"), "at least one light"));
  EXPECT_TRUE(has(error(R"([{"position": [1,2,3], "intensity": [0,1,1]}])"), "> 0"));
  EXPECT_TRUE(has(error(R"([{"position": [1,2,3], "intensity": [-1,1,1]}])"), "/lights/0/intensity"));
  EXPECT_TRUE(has(error(R"([{"position": [1,2,3], "direction": [0,0,1]}])"), "either `position` or `direction`"));
  EXPECT_TRUE(has(error(R"([{"direction": [0,0,0]}])"), "length above 0"));
  EXPECT_TRUE(has(error(R"([{"position": [1,2]}])"), "/lights/0/position"));
  EXPECT_TRUE(has(error(R"([{"position": [1,2,3], "color": 1}])"), "color"));
  EXPECT_TRUE(has(error(R"({"file": "a.lp", "kind": "places"})"), "did you mean") ||
              has(error(R"({"file": "a.lp", "kind": "places"})"), "directions"));
  EXPECT_TRUE(has(error(R"("missing.lp")"), "missing.lp"));
}

TEST(LightIo, ACalibrationOfOursSaysItsUnit) {
  const TempFolder folder;
  write_atomically(
      folder / "rig.json",
      R"({"format": "patinate.calibration", "version": 1, "unit": "cm", "lights": [{"position": [1, 2, 3]}], "more": 1})");
  EXPECT_EQ(read_lights(folder / "rig.json", 1000.0)[0].position, Vec3(10, 20, 30));
}

TEST(LightIo, ReadsTheTablesOfPublishedData) {
  PATINATE_REQUIRE_DATA(uw, "photometric/uw_psm/lights.txt");
  PATINATE_REQUIRE_DATA(cat, "photometric/psbox_cat/light_directions.txt");
  const LightRows rows{.frame = LightRows::Frame::Scanner};
  const std::vector<Light> by_rows = read_lights(uw, 1, nullptr, rows), by_columns = read_lights(cat, 1, nullptr, rows);
  ASSERT_EQ(by_rows.size(), 12u);
  ASSERT_EQ(by_columns.size(), 12u);
  constexpr double kPrinted = 1e-5;
  EXPECT_LT((by_rows[11].direction - Vec3(-0.16119, 0.354617, 0.921013)).norm(), kPrinted);
  EXPECT_LT((by_columns[1].direction - Vec3(-0.2333886619, 0.3514283789, 0.9066575026).normalized()).norm(), kPrinted);
}

}  // namespace
}  // namespace patinate
