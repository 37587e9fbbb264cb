#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "libcommon/controls/height.h"
#include "libcommon/controls/light_set.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "tests/libcommon/controls/control_shapes.h"

namespace patinate {
namespace {

using testing_support::groove;
using testing_support::make_patch;
using testing_support::plane;
using testing_support::side_by_side;
using testing_support::value_at;

constexpr double kPi = std::numbers::pi;
/// 1024 directions: beside a straight shadow a fixed even set errs by a few of them (256: 0.02).
constexpr double kDirections = 0.01;
constexpr std::array<double, 3> kUpZ{0, 0, 1};

TEST(ExposureMap, OfAFreePlaneIsTheHalfOfOnePlusCosine) {  // The part of the sky's half sphere above a tilted plane.
  const TexelMap map(plane(10), 8, 8);
  for (const double degrees : {0.0, 30.0, 60.0, 90.0, 120.0, 180.0}) {
    const double tilt = degrees * kPi / 180;
    const ControlMap control = exposure_map(map, {0.0, std::sin(tilt), std::cos(tilt)});
    for (TexelId t = 0; t < map.num_texels(); ++t) {
      EXPECT_NEAR(value_at(control, t), (1 + std::cos(tilt)) / 2, 0.004) << degrees;
    }
    EXPECT_EQ(control.unit, "share");
  }
}

TEST(ExposureMap, OfTheFloorOfARoundHoleIsTheFormFactorOfItsOpening) {
  for (const double depth : {0.5, 1.0, 2.0}) {
    const double radius = 1.0;
    const Mesh floor = make_patch(2, 2, [](double u, double v) { return Vec3(0.02 * (u - 0.5), 0.02 * (v - 0.5), 0); });
    const Mesh wall = make_patch(256, 8, [&](double u, double v) {
      return Vec3(radius * std::cos(2 * kPi * u), radius * std::sin(2 * kPi * u), depth * v);
    });
    const TexelMap map(side_by_side({floor, wall}), 16, 8);
    const ControlMap control = exposure_map(map, kUpZ, {.num_rays = 1024});
    EXPECT_NEAR(value_at(control, 4 * 16 + 4), radius * radius / (radius * radius + depth * depth), 0.01) << depth;
  }
}

/// Sky that a point at `d` from the bottom of a wall sees: in two dimensions, (sin a - sin b) / 2 for the angles a, b
/// from the normal between which it is open: a = 90 degrees, along the wall; b towards the top of the other wall. At
/// the bottom b is 90 degrees - phi, which makes (1 - cos phi) / 2; over a whole wall the mean is sin(phi / 2)
/// (Hottel's crossed strings).
double groove_exposure(double length, double phi, double d) {
  const Vec2 wall(-std::sin(phi / 2), std::cos(phi / 2)), normal(std::cos(phi / 2), std::sin(phi / 2));
  const Vec2 to_top = Vec2(length * std::sin(phi / 2), length * std::cos(phi / 2)) - d * wall;
  return (1.0 - std::sin(std::atan2(to_top.dot(wall), to_top.dot(normal)))) / 2.0;
}

TEST(ExposureMap, OfTheWallsOfAGrooveFollowsItsOpening) {
  constexpr int kSize = 65;
  for (const double degrees : {60.0, 90.0, 120.0}) {
    const double phi = degrees * kPi / 180;
    const TexelMap map(groove(10, phi), 2 * kSize, kSize);
    const ControlMap control = exposure_map(map, kUpZ, {.num_rays = 1024});
    double mean = 0.0;
    for (int x = 0; x < kSize; ++x) {
      const double seen = value_at(control, (kSize / 2) * 2 * kSize + x);
      EXPECT_NEAR(seen, groove_exposure(10, phi, 10 * (x + 0.5) / kSize), kDirections)
          << degrees << " deg, texel " << x;
      mean += seen / kSize;
    }
    EXPECT_NEAR(mean, std::sin(phi / 2), 0.005);
    EXPECT_NEAR(value_at(control, (kSize / 2) * 2 * kSize), (1 - std::cos(phi)) / 2, kDirections);
  }
}

TEST(ExposureMap, LeavesALowPolygonSphereWithoutFacets) {
  const TexelMap map(make_patch(24, 12,
                                [](double u, double v) {
                                  const double a = 2 * kPi * u, b = kPi * (v - 0.5);
                                  return Vec3(std::sin(a) * std::cos(b), std::sin(b), std::cos(a) * std::cos(b));
                                }),
                     96, 48);
  const ControlMap control = exposure_map(map);
  for (int y = 6; y < 42; ++y) {
    for (int x = 0; x < 96; ++x) {
      const double latitude = kPi * (0.5 - (y + 0.5) / 48);
      EXPECT_NEAR(control.values.at(x, y), (1 + std::sin(latitude)) / 2, 0.02) << x << ' ' << y;
    }
  }
}

TEST(ExposureMap, MixesSkyAndSunByTheirShares) {
  const TexelMap map(plane(10), 8, 8);
  const SunOptions sun{.direction = {0, 0.6, 0.8}, .radius_deg = 0};
  const ControlMap control = exposure_map(map, kUpZ, {.sun_share = 0.25}, sun);
  EXPECT_NEAR(value_at(control, 27), 0.75 * 1.0 + 0.25 * 0.8, 1e-5);
}

TEST(ExposureMap, OfAnEvenPanoramaIsOneWhereverASurfaceFaces) {
  const TexelMap map(plane(10), 4, 4);
  for (const std::array<double, 3> up : {std::array{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, -1.0}}) {
    const ControlMap control = exposure_map(map, up, {}, {}, ImageF(64, 32, 3, 0.5F));
    EXPECT_NEAR(value_at(control, 5), 1.0, 0.02);
  }
}

TEST(ExposureMap, TakesTheSunFromAPanorama) {
  // One bright pixel, 60 degrees above the horizon to the right (+x, y up), the up axis along z: (1/2, 0, sqrt(3)/2).
  ImageF panorama(360, 180, 3);
  for (float& v : panorama.pixel(270, 30)) v = 1000.0F;
  const LightSet sky = panorama_sky(Vec3::UnitZ(), 64, panorama);
  ASSERT_EQ(sky.directions.size(), 1u);
  EXPECT_NEAR((sky.directions[0] - Vec3(0.5, 0, std::sqrt(0.75))).norm(), 0.0, 0.02);  // pixels of one degree
  EXPECT_THROW((void)panorama_sky(Vec3::UnitZ(), 64, ImageF(8, 4, 3)), InvalidInput);
}

TEST(SunMap, ThrowsAShadowAsLongAsHeightOverTangent) {
  const double height = 2.0;
  const Mesh wall = make_patch(1, 1, [&](double u, double v) { return Vec3(0, 20 * (u - 0.5), height * v); });
  const TexelMap map(side_by_side({plane(10), wall}), 512, 64);
  for (const double degrees : {30.0, 45.0, 60.0}) {
    const double elevation = degrees * kPi / 180, length = height / std::tan(elevation);
    const ControlMap control =
        sun_map(map, kUpZ, {.direction = {std::cos(elevation), 0, std::sin(elevation)}, .radius_deg = 0});
    for (int x = 0; x < 256; ++x) {
      const double place = 10 * ((x + 0.5) / 256 - 0.5);
      if (std::abs(place) < 0.05 || std::abs(place + length) < 0.05) continue;  // the texel at the edge
      EXPECT_NEAR(control.values.at(x, 32), place < 0 && place > -length ? 0 : std::sin(elevation), 1e-5) << place;
    }
  }
}

TEST(SunMap, OverADayIsTheMeanOfTheCosine) {
  // Noon at 50 degrees: the mean of cos(hour) over +-90 degrees is 2 / pi.
  const TexelMap map(plane(10), 4, 4);
  const double noon = 50 * kPi / 180;
  const ControlMap control =
      sun_map(map, kUpZ, {.direction = {0, -std::cos(noon), std::sin(noon)}, .radius_deg = 0, .arc_deg = 180});
  EXPECT_NEAR(value_at(control, 5), std::sin(noon) * 2 / kPi, 2e-4);
}

TEST(SunMap, HasAHalfShadowWhereHalfTheDiscIsHidden) {
  const Mesh wall = make_patch(1, 1, [](double u, double v) { return Vec3(0, 20 * (u - 0.5), 2 * v); });
  const TexelMap map(side_by_side({plane(10), wall}), 512, 64);
  const double half = std::sqrt(0.5);
  const ControlMap control = sun_map(map, kUpZ, {.direction = {half, 0, half}, .radius_deg = 5});
  EXPECT_NEAR(control.values.at(77, 32), half / 2,
              0.03);  // x = -2, where the middle of the sun stands on the wall's edge
}

TEST(RayShareMap, IsWhatTheGrooveHidesAndNothingOnAPlane) {
  const TexelMap free(plane(10), 8, 8);
  const ControlMap none = ray_share_map(free);
  for (const float v : none.values.values()) EXPECT_EQ(v, 0.0F);
  const double phi = kPi / 2;
  const TexelMap map(groove(10, phi), 64, 33);
  const ControlMap control = ray_share_map(map, {.num_rays = 1024, .reach_mm = 1e6});
  for (int x = 0; x < 32; ++x) {
    EXPECT_NEAR(value_at(control, 16 * 64 + x), 1 - groove_exposure(10, phi, 10 * (x + 0.5) / 32), kDirections);
  }
}

TEST(RayShareMap, LooksNoFartherThanItsReach) {
  // From a plane, what lies above within the reach: a lid at height 1 and the cone of rays that meet it before 2, 1 -
  // (1/2)^2...
  const Mesh lid = make_patch(1, 1, [](double u, double v) { return Vec3(40 * (u - 0.5), 40 * (0.5 - v), 1); });
  const TexelMap map(side_by_side({plane(2), lid}), 64, 32);
  const auto middle = [&](double reach) {
    return value_at(ray_share_map(map, {.num_rays = 1024, .reach_mm = reach}), 16 * 64 + 16);
  };
  EXPECT_EQ(middle(0.9), 0.0);
  EXPECT_NEAR(middle(2.0), 0.75, 0.01);  // cosine > 1/2: sin^2(60 degrees)
  EXPECT_NEAR(middle(10.0), 0.99, 0.01);
}

TEST(HeightMap, IsExact) {
  const TexelMap map(make_patch(3, 5, [](double u, double v) { return Vec3(3 * u, 7 * v, 2 + 4 * u + v); }), 32, 32);
  const ControlMap control = height_map(map, {0, 0, 3});
  EXPECT_EQ(control.low, 0.0);
  EXPECT_EQ(control.high, 5.0);
  EXPECT_EQ(control.unit, "mm");
  for (TexelId t = 0; t < map.num_texels(); ++t) EXPECT_NEAR(value_at(control, t), map.position_mm(t).z() - 2, 1e-6);
  EXPECT_THROW((void)height_map(map, {0, 0, 0}), InvalidInput);
}

TEST(RayControls, AreTheSameForAnyNumberOfThreads) {
  const TexelMap map(groove(10, 1.0), 48, 40);
  for (const char* kind : {"exposure", "sun", "ray_share"}) {
    RunControl one, three;
    one.num_threads = 1, three.num_threads = 3;
    EXPECT_EQ(make_control(kind, map, {}, one).values, make_control(kind, map, {}, three).values) << kind;
  }
}

TEST(MakeControl, SaysWhenAMapIsEven) {
  const TexelMap map(plane(10), 8, 8);
  ControlKindOptions options;
  options.facing.direction = {0, 0, -1};
  const ControlMap away = make_control("facing", map, options);
  ASSERT_EQ(away.notes.size(), 1u);
  EXPECT_EQ(away.notes[0], "control `facing` is 0 on the whole surface; a map that is even guides nothing");
  EXPECT_EQ(make_control_expression("1 - 0.5*facing", map, options).notes.size(), 1u);
  ASSERT_EQ(make_control_expression("0.25", map).notes.size(), 1u);
  options.up = {0, 1, 0};
  EXPECT_TRUE(make_control("height", map, options).notes.empty());
}

}  // namespace
}  // namespace patinate
