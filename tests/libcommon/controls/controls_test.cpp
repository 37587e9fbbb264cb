#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "libcommon/controls/image_control.h"
#include "libcommon/controls/spray_path_io.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::make_patch;
using testing_support::TempFolder;

/// A plane of 10 x 10 mm, facing +z, that fills the atlas.
TexelMap plane_map(int size) {
  return TexelMap(make_patch(4, 4, [](double u, double v) { return Vec3(10 * u - 5, 10 * v - 5, 0); }), size, size);
}

/// A height field over [-5, 5]^2 mm that fills the atlas, facing +z.
template <class Height>
TexelMap relief_map(int size, int cells, Height&& height) {
  return TexelMap(make_patch(cells, cells,
                             [&](double u, double v) {
                               const double x = 10 * u - 5, y = 10 * v - 5;
                               return Vec3(x, y, height(x, y));
                             }),
                  size, size);
}

void expect_valid(const ControlMap& control, const TexelMap& map) {
  ASSERT_EQ(control.values.width(), map.width());
  ASSERT_EQ(control.values.height(), map.height());
  ASSERT_EQ(control.values.channels(), 1);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    const float v = control.values.values()[t];
    ASSERT_TRUE(v >= 0.0F && v <= 1.0F);
    ASSERT_TRUE(map.is_covered(t) || v == 0.0F);
  }
}

TEST(AccessibilityMap, IsOneInAGrooveAndZeroOnARidge) {
  const TexelMap map = relief_map(64, 40, [](double x, double) {
    return 0.6 * std::exp(-(x + 2.5) * (x + 2.5)) - 0.6 * std::exp(-(x - 2.5) * (x - 2.5));
  });
  const ControlMap control = accessibility_map(map, {.scale_mm = 0.4});
  expect_valid(control, map);
  EXPECT_EQ(control.unit, "1/mm");
  EXPECT_NEAR(control.high, -control.low, 0.03 * control.high);  // odd symmetry
  EXPECT_GT(control.values.at(47, 32), 0.97F);                   // x = 2.5: the groove
  EXPECT_LT(control.values.at(16, 32), 0.03F);                   // x = -2.5: the ridge
  EXPECT_NEAR(control.values.at(32, 32), 0.5F, 0.02F);
}

TEST(AccessibilityMap, RangeIsTheMeanCurvatureInReciprocalMillimetres) {
  // Bottom of a shallow wave a cos(k x): curvature a k^2 / 2, of which the step keeps 1 / (1 + t k^2).
  constexpr double kHeight = 0.05, kWave = std::numbers::pi / 2.5, kScale = 0.5;
  const TexelMap map = relief_map(64, 80, [](double x, double) { return kHeight * std::cos(kWave * x); });
  const ControlMap control = accessibility_map(map, {.scale_mm = kScale, .low_percent = 0, .high_percent = 100});
  const double expected = kHeight * kWave * kWave / 2 / (1 + kScale * kScale / 2 * kWave * kWave);
  EXPECT_NEAR(control.high, expected, 0.03 * expected);
  EXPECT_NEAR(control.low, -expected, 0.03 * expected);
}

TEST(AccessibilityMap, OfAPlaneIsEvenAndNotNoise) {
  const TexelMap map = plane_map(32);
  const ControlMap control = accessibility_map(map);
  for (float v : control.values.values()) EXPECT_NEAR(v, 0.5F, 1e-3F);
  EXPECT_GT(control.high, control.low);
}

TEST(AccessibilityMap, DefaultScaleIsTwoPercentOfTheDiagonal) {
  const TexelMap map = plane_map(8);
  EXPECT_NEAR(default_accessibility_scale_mm(map.mesh()), 0.02 * 10 * std::sqrt(2.0), 1e-12);
}

TEST(AccessibilityMap, RejectsOptionsOutOfRange) {
  const TexelMap map = plane_map(8);
  EXPECT_THROW((void)accessibility_map(map, {.scale_mm = 0.0}), InvalidInput);
  EXPECT_THROW((void)accessibility_map(map, {.scale_mm = std::nan("")}), InvalidInput);
  EXPECT_THROW((void)accessibility_map(map, {.scale_mm = 1.0, .low_percent = -1}), InvalidInput);
  EXPECT_THROW((void)accessibility_map(map, {.scale_mm = 1.0, .high_percent = 101}), InvalidInput);
}

TEST(AreaPercentiles, WeighTexelsByTheirArea) {
  // Left half of the atlas shows 1 mm, right half 9 mm of a strip: the median by area lies in the right half.
  const Mesh mesh =
      make_patch(2, 1, [](double u, double v) { return Vec3(u <= 0.5 ? 2 * u : 1 + 18 * (u - 0.5), v, 0); });
  const TexelMap map(mesh, 100, 4);
  ImageF values(100, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 100; ++x) values.at(x, y) = static_cast<float>(x);
  }
  const ValueRange range = area_percentiles(values, map, 10, 50);
  EXPECT_NEAR(range.low, 49.5, 1.0);  // all of the left half
  EXPECT_NEAR(range.high, 49.5 + 50 * 4.0 / 9.0, 1.0);
}

TEST(FacingMap, IsTheCosineAndZeroForWhatFacesAway) {
  for (double degrees : {0.0, 30.0, 60.0, 90.0, 150.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const TexelMap map = plane_map(8);
    const ControlMap control = facing_map(map, {.direction = {0, 7 * std::sin(angle), 7 * std::cos(angle)}});
    for (float v : control.values.values()) EXPECT_NEAR(v, std::max(0.0, std::cos(angle)), 1e-6);
  }
  EXPECT_THROW((void)facing_map(plane_map(8), {.direction = {0, 0, 0}}), InvalidInput);
}

TEST(SprayMap, FollowsTheConeTheCosineAndTheDistance) {
  const TexelMap map = plane_map(32);
  const std::vector<SprayStop> path{{.position_mm = {0, 0, 6}, .dwell = 2.0, .aim_mm = {0, 0, 0}}};
  const ControlMap control = spray_map(map, path, {.spread_deg = 20, .full_percent = 100});
  expect_valid(control, map);
  const double sigma = 20 * std::numbers::pi / 180;
  const auto paint = [&](const Vec3& p) {
    const double d = (Vec3(0, 0, 6) - p).norm(), cosine = 6 / d, angle = std::acos(cosine);
    return std::exp(-0.5 * angle * angle / sigma / sigma) * cosine / (d * d);
  };
  double most = 0.0;
  for (TexelId t = 0; t < map.num_texels(); ++t) most = std::max(most, paint(map.position_mm(t)));
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    EXPECT_NEAR(control.values.values()[t], paint(map.position_mm(t)) / most, 1e-5);
  }
  EXPECT_EQ(control.low, 0.0);
  EXPECT_EQ(control.unit, "relative");
}

TEST(SprayMap, AddsStopsByTheirDwell) {
  const TexelMap map = plane_map(16);
  const SprayStop a{.position_mm = {-3, 0, 4}, .dwell = 1, .aim_mm = {-3, 0, 0}},
      b{.position_mm = {3, 1, 4}, .dwell = 3, .aim_mm = {0, 0, 0}};
  const SprayOptions options{.full_percent = 100};
  const ControlMap only_a = spray_map(map, {a}, options), only_b = spray_map(map, {b}, options),
                   both = spray_map(map, {a, b}, options);
  for (std::size_t i = 0; i < both.values.values().size(); ++i) {
    const auto physical = [i](const ControlMap& m) { return static_cast<double>(m.values.values()[i]) * m.high; };
    EXPECT_NEAR(physical(both), physical(only_a) + physical(only_b), 1e-5 * both.high);
  }
}

/// A plane of 10 x 10 mm below a smaller one at z = 1 that faces up as well: left and right half of the atlas.
TexelMap table_map() {
  Mesh floor = make_patch(1, 1, [](double u, double v) { return Vec3(10 * u - 5, 10 * v - 5, 0); });
  const Mesh table = make_patch(1, 1, [](double u, double v) { return Vec3(4 * u - 2, 4 * v - 2, 1); });
  for (Vec2& uv : floor.uvs) uv.x() *= 0.5;
  const int offset = static_cast<int>(floor.positions.size());
  for (std::size_t i = 0; i < table.positions.size(); ++i) {
    floor.positions.push_back(table.positions[i]);
    floor.uvs.push_back(Vec2(0.5 + 0.5 * table.uvs[i].x(), table.uvs[i].y()));
  }
  for (const Triangle& t : table.triangles) floor.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  floor.uv_triangles = floor.triangles;
  floor.triangle_surface.assign(floor.triangles.size(), 0);
  return TexelMap(floor, 64, 32);
}

TEST(SprayMap, LeavesTheShadowOfAnObstacleUnpainted) {
  const TexelMap map = table_map();
  const std::vector<SprayStop> path{{.position_mm = {0, 0, 5}, .dwell = 1, .aim_mm = {0, 0, 0}}};
  const ControlMap shaded = spray_map(map, path, {.spread_deg = 40}),
                   open = spray_map(map, path, {.spread_deg = 40, .casts_shadows = false});
  int num_shaded = 0;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    const Vec3 p = map.position_mm(t);
    // The table's half width of 2 at z = 1 throws a shadow of 2.5 on the floor from a nozzle at z = 5.
    const double reach = std::max(std::abs(p.x()), std::abs(p.y()));
    const auto i = static_cast<std::size_t>(t);
    if (p.z() < 0.5 && reach < 2.4) {
      EXPECT_EQ(shaded.values.values()[i], 0.0F);
      EXPECT_GT(open.values.values()[i], 0.0F);
      ++num_shaded;
    } else if (p.z() > 0.5 || reach > 2.6) {
      EXPECT_GT(shaded.values.values()[i], 0.0F);
    }
  }
  EXPECT_GT(num_shaded, 100);
}

TEST(SprayMap, RejectsPathsThatPaintNothing) {
  const TexelMap map = plane_map(8);
  const auto error_of = [&](std::vector<SprayStop> path) -> std::string {
    try {
      (void)spray_map(map, path);
    } catch (const InvalidInput& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(error_of({}), "spray: the path has no stops");
  EXPECT_EQ(error_of({{.position_mm = {0, 0, 1}, .dwell = -1}}), "spray: stop 1 has a dwell that is not >= 0");
  EXPECT_EQ(error_of({{.position_mm = {0, 0, 0}, .dwell = 1}}), "spray: stop 1 aims at its own position");
  EXPECT_NE(error_of({{.position_mm = {0, 0, -5}, .dwell = 1}}).find("no paint arrives"), std::string::npos);  // behind
  EXPECT_NE(error_of({{.position_mm = {0, 0, std::nan("")}, .dwell = 1}}).find("not finite"), std::string::npos);
}

TEST(SprayMap, DefaultPathPaintsTheObjectFromAboveAndInFront) {
  TexelMap map(make_patch(24, 12,
                          [](double u, double v) {
                            const double a = 2 * std::numbers::pi * u, b = std::numbers::pi * (v - 0.5);
                            return Vec3(std::sin(a) * std::cos(b), std::sin(b), std::cos(a) * std::cos(b));
                          }),
               64, 32);
  const ControlMap control = spray_map(map, default_spray_path(map.mesh()));
  EXPECT_GT(control.values.at(0, 9), 0.9F);    // front, up
  EXPECT_EQ(control.values.at(32, 20), 0.0F);  // back, down
}

TEST(ImageMap, IsLaidOverTheAtlasByUv) {
  const TexelMap map = plane_map(8);
  ImageF same(8, 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) same.at(x, y) = static_cast<float>(x + 8 * y) / 64.0F;
  }
  EXPECT_EQ(image_map(map, same).values, same);
  // A linear ramp stays one under bilinear sampling (away from the repeated border).
  ImageF ramp(16, 2);
  for (int x = 0; x < 16; ++x) ramp.at(x, 0) = ramp.at(x, 1) = (static_cast<float>(x) + 0.5F) / 16.0F;
  const ControlMap control = image_map(map, ramp);
  for (int x = 0; x < 8; ++x) EXPECT_NEAR(control.values.at(x, 3), (static_cast<float>(x) + 0.5F) / 8.0F, 1e-6F);
}

TEST(ImageMap, KeepsPhysicalValuesAsItsRange) {
  const TexelMap map = plane_map(2);
  ImageF image(2, 2);
  image.at(0, 0) = -4.0F;
  image.at(1, 1) = 12.0F;
  const ControlMap control = image_map(map, image);
  EXPECT_EQ(control.low, -4.0);
  EXPECT_EQ(control.high, 12.0);
  EXPECT_EQ(control.values.at(1, 0), 0.25F);
  image.at(0, 1) = std::nanf("");
  EXPECT_THROW((void)image_map(map, image), InvalidInput);
  EXPECT_THROW((void)image_map(map, ImageF(2, 2, 3)), InvalidInput);
}

TEST(ReadSprayPath, ReadsEveryFormOfAStop) {
  const TempFolder folder;
  std::ofstream(folder / "a.csv") << "x,y,z,dwell\n1,2,3\r\n# pause\n\n4, 5 ,6,0.5\n7,8,9,2,1,1,-1";
  const std::vector<SprayStop> stops = read_spray_path(folder / "a.csv", Vec3(0, 0, 7));
  ASSERT_EQ(stops.size(), 3u);
  EXPECT_EQ(stops[0].position_mm, Vec3(1, 2, 3));
  EXPECT_EQ(stops[0].dwell, 1.0);
  EXPECT_EQ(stops[0].aim_mm, Vec3(0, 0, 7));
  EXPECT_EQ(stops[1].dwell, 0.5);
  EXPECT_EQ(stops[2].aim_mm, Vec3(1, 1, -1));
}

TEST(ReadSprayPath, NamesTheLineOfAnError) {
  const TempFolder folder;
  const auto error_of = [&](const std::string& text) -> std::string {
    std::ofstream(folder / "a.csv") << text;
    try {
      (void)read_spray_path(folder / "a.csv", Vec3::Zero());
    } catch (const IoError& e) {
      return std::string(e.what()).substr((folder / "a.csv").string().size() + 2);
    }
    return "";
  };
  EXPECT_EQ(error_of("1,2,3\n1,2\n"), "line 2: found 2 values; expected x,y,z[,dwell[,aim_x,aim_y,aim_z]]");
  EXPECT_EQ(error_of("1,2,nan\n"), "line 1: `nan` is not a finite number");
  EXPECT_EQ(error_of("1,2,3,-1\n"), "line 1: the dwell is negative; use >= 0");
  EXPECT_EQ(error_of("0,0,0\n"), "line 1: the nozzle aims at its own position");
  EXPECT_EQ(error_of("# nothing\n"), "holds no stop; expected lines of x,y,z[,dwell[,aim_x,aim_y,aim_z]]");
  EXPECT_THROW((void)read_spray_path(folder / "missing.csv", Vec3::Zero()), IoError);
}

TEST(MakeControl, KnowsEveryKindAndNamesOthers) {
  const TexelMap map = plane_map(16);
  const TempFolder folder;
  write_codes(folder / "map.png", ImageU8(4, 4, 1, std::uint8_t{51}));
  ControlKindOptions options;
  options.image = (folder / "map.png").string();
  options.distance_from = "boundary";
  for (const std::string& kind : control_kind_names()) expect_valid(make_control(kind, map, options), map);
  EXPECT_NEAR(make_control("image", map, options).values.at(3, 3), 0.2F, 1e-6F);
  EXPECT_EQ(control_input_files("image", options), std::vector<std::filesystem::path>{options.image});
  EXPECT_TRUE(control_input_files("facing", options).empty());
  EXPECT_THROW((void)make_control("image", map), ParseError);
  try {
    (void)make_control("acessibility", map);
    FAIL();
  } catch (const ParseError& e) {
    const std::string text = e.what();
    EXPECT_TRUE(text.starts_with("unknown kind of control `acessibility`; there are `accessibility`, `ray_share`, "));
    EXPECT_TRUE(text.ends_with("; did you mean `accessibility`?")) << text;
  }
}

TEST(MakeControl, EvaluatesExpressionsOfKindsAndFiles) {
  const TexelMap map = plane_map(16);
  const TempFolder folder;
  write_codes(folder / "map.png", ImageU8(16, 16, 1, std::uint8_t{51}));
  ControlKindOptions options;
  options.facing.direction = {0, 0, 1};
  const ControlMap control =
      make_control_expression("0.5*facing + \"" + (folder / "map.png").string() + "\"", map, options);
  for (float v : control.values.values()) EXPECT_NEAR(v, 0.7F, 1e-6F);
  EXPECT_THROW((void)make_control_expression("missing.png", map), IoError);
}

TEST(ControlMaps, AreTheSameForAnyNumberOfThreads) {
  const TexelMap map = relief_map(48, 10, [](double x, double y) { return std::sin(x) * std::cos(y); });
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  ControlKindOptions options;
  for (const std::string kind : {"accessibility", "facing", "spray"}) {
    options.facing.direction = {0.2, 0.1, 1};
    EXPECT_EQ(make_control(kind, map, options, one).values, make_control(kind, map, options, three).values);
  }
}

TEST(ControlMaps, OfTheMarbleBustHaveDarkNoseAndBrightCrevices) {
  PATINATE_REQUIRE_DATA(path, "meshes/marble_bust/marble_bust_01_1k.gltf");
  Mesh mesh = read_mesh(path);
  scale_mesh(mesh, 1000.0);
  const TexelMap map(mesh, 256, 256);
  const ControlMap control = accessibility_map(map);
  expect_valid(control, map);
  EXPECT_LT(control.low, 0.0);
  EXPECT_GT(control.high, 0.0);
  // The point that lies farthest in front (the nose) is convex.
  TexelId front = -1;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (map.is_covered(t) && (front < 0 || map.position_mm(t).z() > map.position_mm(front).z())) front = t;
  }
  EXPECT_LT(control.values.values()[front], 0.2F);
}

}  // namespace
}  // namespace patinate
