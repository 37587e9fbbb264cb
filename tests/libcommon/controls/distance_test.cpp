#include "patinate/controls/distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "libcommon/controls/distance_io.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "tests/libcommon/controls/control_shapes.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::make_patch;
using testing_support::plane;
using testing_support::side_by_side;
using testing_support::TempFolder;
using testing_support::value_at;

constexpr double kFloat = 2e-5;  ///< Maps are float; the distances themselves are exact on a plane.

TEST(DistanceMap, OfAPointOnAPlaneIsExact) {
  const TexelMap map(plane(10, 3), 32, 32);
  const Vec3 point(1.3, -2.1, 0);
  const ControlMap control = distance_map(map, {.curves = {{point}}});
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    EXPECT_NEAR(value_at(control, t), (map.position_mm(t) - point).norm(), kFloat * 10);
  }
  EXPECT_EQ(control.low, 0.0);
  EXPECT_EQ(control.unit, "mm");
}

TEST(DistanceMap, OfTheBoundaryOfAPlaneIsExact) {
  const TexelMap map(plane(10, 3), 32, 32);
  const ControlMap control = distance_map(map, {.edges = DistanceSource::Edges::Boundary}, {.range_mm = 8.0});
  EXPECT_EQ(control.high, 8.0);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    const Vec3 p = map.position_mm(t);
    EXPECT_NEAR(value_at(control, t), 5 - std::max(std::abs(p.x()), std::abs(p.y())), kFloat * 10);
  }
}

/// Three quarters of a cylinder of radius 4 and height 10; u is the angle, v the height.
Mesh cylinder() {
  return make_patch(96, 12, [](double u, double v) {
    const double a = 1.5 * std::numbers::pi * u;
    return Vec3(4 * std::cos(a), 10 * v, -4 * std::sin(a));
  });
}

TEST(DistanceMap, OnACylinderIsThatOfItsUnrolledPlane) {
  const TexelMap map(cylinder(), 48, 24);
  const ControlMap control = distance_map(map, {.curves = {{Vec3(4, 3, 0)}}});
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    const double u = (static_cast<double>(t % 48) + 0.5) / 48, v = 1 - (static_cast<double>(t / 48) + 0.5) / 24;
    const double expected = std::hypot(4 * 1.5 * std::numbers::pi * u, 10 * v - 3);
    EXPECT_NEAR(value_at(control, t), expected, 0.004 * expected)
        << t;  // chords in place of arcs, and curved edges between
  }
}

TEST(DistanceMap, StraightThroughTheAirIsShorter) {
  const TexelMap map(cylinder(), 48, 24);
  const Vec3 point(4, 3, 0);
  const ControlMap control = distance_map(map, {.curves = {{point}}}, {.metric = DistanceMetric::Euclidean});
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    EXPECT_NEAR(value_at(control, t), (map.position_mm(t) - point).norm(),
                0.02);  // the surface between the corners is curved
  }
}

TEST(DistanceMap, BendsRoundACorner) {
  // An L of three squares: from (1, 9) to a point (9, y) the way goes over the corner (5, 5).
  Mesh mesh = side_by_side({make_patch(4, 4, [](double u, double v) { return Vec3(5 * u, 5 + 5 * v, 0); }),
                            make_patch(4, 4, [](double u, double v) { return Vec3(5 * u, 5 * v, 0); }),
                            make_patch(4, 4, [](double u, double v) { return Vec3(5 + 5 * u, 5 * v, 0); })});
  // One surface: positions that are equal are one.
  for (Triangle& t : mesh.triangles) {
    for (int& corner : t) {
      for (int i = 0; i < corner; ++i) {
        if ((mesh.positions[i] - mesh.positions[corner]).norm() < 1e-12) corner = i;
      }
    }
  }
  const TexelMap map(mesh, 48, 16);
  const Vec3 start(1, 9, 0), bend(5, 5, 0);
  const ControlMap control = distance_map(map, {.curves = {{start}}});
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    const Vec3 p = map.position_mm(t);
    const bool is_hidden = p.x() > 5 && p.x() + p.y() > 10;
    const double expected = is_hidden ? (start - bend).norm() + (p - bend).norm() : (p - start).norm();
    // Fronts take a little of what the corner hides for seen.
    EXPECT_LE(value_at(control, t), 1.001 * expected) << p.transpose();
    EXPECT_GE(value_at(control, t), (is_hidden ? 0.92 : 0.999) * expected) << p.transpose();
  }
}

TEST(DistanceMap, KnowsRidgesFromValleys) {
  // A step of three planes: a ridge at x = 4, z = 3 and a valley at x = 4, z = 0.
  const Mesh mesh = make_patch(2, 2, [](double u, double v) {
    return Vec3(u < 0.4 ? -4 : u > 0.6 ? 4 : 0, 4 * v, u < 0.4 || u > 0.6 ? 0 : 3);
  });
  const TexelMap map(mesh, 32, 16);  // a roof
  const ControlMap control = distance_map(map, {.edges = DistanceSource::Edges::Ridges});
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    EXPECT_NEAR(value_at(control, t), std::abs(map.position_mm(t).x()) * 1.25, 1e-3);  // 5 mm of slope over 4 mm
  }
  EXPECT_THROW((void)distance_map(map, {.edges = DistanceSource::Edges::Valleys}), InvalidInput);
}

TEST(DistanceMap, OfAPaintedPatchIsZeroInIt) {
  const TexelMap map(plane(10), 20, 20);
  ImageF mask(20, 20);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 5; ++x) mask.at(x, y) = 1.0F;
  }
  const ControlMap control = distance_map(map, {.mask = mask});
  for (int x = 0; x < 20; ++x) EXPECT_NEAR(value_at(control, 7 * 20 + x), std::max(0.0, (x - 4) * 0.5), 1e-4);
  EXPECT_THROW((void)distance_map(map, {.mask = ImageF(20, 20)}), InvalidInput);
  EXPECT_THROW((void)distance_map(map, {.mask = ImageF(8, 20)}), InvalidInput);
}

TEST(DistanceMap, SaysWhatItDoesNotReach) {
  const Mesh far = make_patch(2, 2, [](double u, double v) { return Vec3(20 + u, v, 0); });
  const TexelMap map(side_by_side({plane(10), far}), 32, 16);
  const ControlMap control = distance_map(map, {.curves = {{Vec3(0, 0, 0)}}});
  ASSERT_EQ(control.notes.size(), 1u);
  EXPECT_NE(control.notes[0].find("no way over the surface leads to 50 %"), std::string::npos) << control.notes[0];
  EXPECT_EQ(control.values.at(24, 8), 1.0F);
  EXPECT_THROW((void)distance_map(map, {.curves = {{Vec3(0, 900, 0)}}}), InvalidInput);
}

TEST(DistanceMap, NeedsToBeToldFromWhat) {
  const TexelMap map(plane(10), 8, 8);
  EXPECT_THROW((void)make_control("distance", map), ParseError);
  ControlKindOptions options;
  options.distance_from = "creses";
  EXPECT_THROW((void)make_control("distance", map, options), ParseError);
  EXPECT_THROW((void)control_input_files("distance", options), ParseError);
  options.distance_from = "line.csv";
  EXPECT_EQ(control_input_files("distance", options).size(), 1u);
  options.distance_from = "boundary";
  EXPECT_TRUE(control_input_files("distance", options).empty());
  EXPECT_EQ(make_control("distance", map, options).unit, "mm");
}

TEST(ReadCurves, EmptyLinesEndCurves) {
  const TempFolder folder;
  std::ofstream(folder / "a.csv") << "x,y,z\n1,2,3\r\n4,5,6\n# still the same\n7,8,9\n\n-1,0,0";
  const auto curves = read_curves(folder / "a.csv");
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_EQ(curves[0].size(), 3u);
  EXPECT_EQ(curves[1], std::vector<Vec3>{Vec3(-1, 0, 0)});
  for (const char* wrong : {"", "# nothing\n", "1,2\n", "1,2,x\n", "1,2,nan\n"}) {
    std::ofstream(folder / "b.csv") << wrong;
    EXPECT_THROW((void)read_curves(folder / "b.csv"), IoError) << wrong;
  }
}

}  // namespace
}  // namespace patinate
