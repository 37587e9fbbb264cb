#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "libcommon/controls/spray_path_io.h"
#include "patinate/core/error.h"
#include "tests/libcommon/controls/control_shapes.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::plane;
using testing_support::TempFolder;
using testing_support::value_at;

const SprayOptions kAll{.full_percent = 100};

SprayStroke stroke(double x, double flow) {
  return {.points = {{.position_mm = {x, -4, 5}, .dwell = 2, .aim_mm = {x, -4, 0}},
                     {.position_mm = {x, 4, 5}, .aim_mm = {x, 4, 0}}},
          .flow = flow};
}

TEST(SprayStrokes, AddUp) {
  const TexelMap map(plane(10), 24, 24);
  const SprayStroke a = stroke(-2, 1), b = stroke(3, 0.5);
  const ControlMap only_a = spray_map(map, stroke_stops({a}), kAll), only_b = spray_map(map, stroke_stops({b}), kAll),
                   both = spray_map(map, stroke_stops({a, b}), kAll);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    EXPECT_NEAR(value_at(both, t), value_at(only_a, t) + value_at(only_b, t), 1e-5 * both.high);
  }
}

TEST(SprayStrokes, PaintAsManyStopsOfTheSameTotal) {
  // The integral along the stroke by 2000 stops: midpoints err by the square of their distance.
  const TexelMap map(plane(10), 16, 16);
  std::vector<SprayStop> slow;
  for (int i = 0; i < 2000; ++i) {
    const double y = -4 + 8 * (i + 0.5) / 2000;
    slow.push_back({.position_mm = {1, y, 5}, .dwell = 3.0 * 2 / 2000, .aim_mm = {1, y, 0}});
  }
  const std::vector<SprayStop> stops = stroke_stops({stroke(1, 3)});
  EXPECT_EQ(stops.size(), 16u);  // 8 mm in steps of at most a tenth of 5 mm
  const ControlMap fast = spray_map(map, stops, kAll), exact = spray_map(map, slow, kAll);
  for (TexelId t = 0; t < map.num_texels(); ++t) EXPECT_NEAR(value_at(fast, t), value_at(exact, t), 0.003 * exact.high);
}

TEST(SprayStrokes, AreReadFromCsvAndJsonAlike) {
  const TempFolder folder;
  std::ofstream(folder / "a.csv")
      << "# two strokes\nstroke,x,y,z,direction_x,direction_y,direction_z,spread,flow,dwell\n"
         "left,-4,0,5,0,0,-1,10,2,3\r\nleft,-4,2,5,0,0,-1,20,,\n\ntop,1,1,9,,,,,,4\n";
  std::ofstream(folder / "a.json") << R"({"format": "patinate.strokes", "version": 1, "strokes": [
      {"name": "left", "flow": 2, "points": [{"position": [-4,0,5], "direction": [0,0,-1], "spread": 10, "dwell": 3},
                                             {"position": [-4,2,5], "direction": [0,0,-1], "spread": 20}]},
      {"points": [{"position": [1,1,9], "dwell": 4}]}]})";
  const Vec3 aim(0, 0, 0);
  const auto csv = read_spray_path(folder / "a.csv", aim), json = read_spray_path(folder / "a.json", aim);
  ASSERT_EQ(csv.size(), json.size());
  ASSERT_GT(csv.size(), 2u);
  double dwell = 0.0;
  for (std::size_t i = 0; i < csv.size(); ++i) {
    EXPECT_EQ(csv[i].position_mm, json[i].position_mm);
    EXPECT_EQ(csv[i].aim_mm, json[i].aim_mm);
    EXPECT_EQ(csv[i].dwell, json[i].dwell);
    EXPECT_EQ(csv[i].spread_deg, json[i].spread_deg);
    dwell += csv[i].dwell;
  }
  EXPECT_NEAR(dwell, 2 * 3 + 4, 1e-12);
  EXPECT_EQ(csv.back().aim_mm, aim);
  EXPECT_FALSE(csv.back().spread_deg);
  EXPECT_LT(csv.front().aim_mm.z(), 0.0);  // straight down, as far as the middle is away
}

TEST(SprayStrokes, NameTheLineOfAnError) {
  const TempFolder folder;
  const auto error_of = [&](const std::string& name, const std::string& text) -> std::string {
    std::ofstream(folder / name) << text;
    try {
      (void)read_spray_path(folder / name, Vec3::Zero());
    } catch (const IoError& e) {
      return e.what();
    }
    return "";
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(error_of("a.csv", "stroke,x,y,z,spred\na,1,2,3,4\n"),
                  "line 1: unknown column `spred`; did you mean `spread`?"));
  EXPECT_TRUE(has(error_of("a.csv", "stroke,x,y,z\na,1,2\n"), "line 2: found 3 values; expected 4"));
  EXPECT_TRUE(has(error_of("a.csv", "stroke,x,y,z,dwell\na,1,2,3,-1\n"), "line 2: the dwell is negative"));
  EXPECT_TRUE(has(error_of("a.csv", "stroke,x,y,z,spread\na,1,2,3,0\n"), "line 2: the spread is outside"));
  EXPECT_TRUE(has(error_of("a.csv", "stroke,x,y,z,flow\na,1,2,3,-2\n"), "flow that is not >= 0"));
  EXPECT_TRUE(has(error_of("a.csv", "stroke,x,y,z\n"), "holds no stroke"));
  EXPECT_TRUE(has(error_of("a.csv", "stroke,x,y,z,direction_x\na,1,2,3,1\n"), "all three are needed"));
  EXPECT_TRUE(
      has(error_of("a.json",
                   R"({"format": "patinate.strokes", "version": 1, "strokes": [{"points": [{"positon": [1,2,3]}]}]})"),
          "position"));
  EXPECT_NE(error_of("a.json", "{"), "");
}

TEST(SprayMap, SaysWhichStopsPaintNothing) {
  const TexelMap map(plane(10), 8, 8);
  const SprayStop good{.position_mm = {0, 0, 5}, .aim_mm = {0, 0, 0}},
      past{.position_mm = {0, 0, 5}, .aim_mm = {0, 0, 90}};
  const ControlMap control = spray_map(map, {good, past});
  ASSERT_EQ(control.notes.size(), 1u);
  EXPECT_NE(control.notes[0].find("1 of 2 stops paint nothing, the first is stop 2"), std::string::npos);
  EXPECT_TRUE(spray_map(map, {good}).notes.empty());
  const ControlMap far = spray_map(map, {{.position_mm = {0, 0, 5000}, .aim_mm = {0, 0, 0}}});
  ASSERT_EQ(far.notes.size(), 1u);
  EXPECT_NE(far.notes[0].find("the nozzle stays 350 times the object's size away"), std::string::npos) << far.notes[0];
  EXPECT_THROW((void)spray_map(map, {past}), InvalidInput);
}

}  // namespace
}  // namespace patinate
