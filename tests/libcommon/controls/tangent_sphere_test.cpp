#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "patinate/controls/accessibility.h"
#include "patinate/core/error.h"
#include "tests/libcommon/controls/control_shapes.h"

namespace patinate {
namespace {

using testing_support::make_icosphere;
using testing_support::make_patch;
using testing_support::plane;
using testing_support::side_by_side;
using testing_support::value_at;

TEST(TangentSphereMap, TouchesBothWallsOfADihedralEdge) {
  // At distance d from an edge of angle phi the sphere that touches both walls has radius d tan(phi / 2).
  for (const double degrees : {60.0, 90.0, 120.0}) {
    const double phi = degrees * std::numbers::pi / 180, x = 10 * std::sin(phi / 2), z = 10 * std::cos(phi / 2);
    const TexelMap map(
        side_by_side({make_patch(4, 4, [=](double u, double v) { return Vec3(-u * x, 10 * (1 - v), u * z); }),
                      make_patch(4, 4, [=](double u, double v) { return Vec3(u * x, 10 * v, u * z); })}),
        64, 33);
    const ControlMap control = tangent_sphere_map(map, {.largest_mm = 1000, .full_percent = 100});
    for (int column = 4; column < 30; ++column) {
      const double d = 10 * (column + 0.5) / 32, expected = d * std::tan(phi / 2);
      // Points are up to e = 0.07 mm apart, so the touched one lies up to e / 2 beside: a second-order error.
      EXPECT_NEAR(1.0 / value_at(control, 16 * 64 + column), expected, 0.01 * expected) << degrees << " deg, d " << d;
    }
    EXPECT_EQ(control.unit, "1/mm");
  }
}

TEST(TangentSphereMap, SaturatesWhereNothingIsNear) {
  const TexelMap map(plane(10), 16, 16);
  const ControlMap control = tangent_sphere_map(map, {.largest_mm = 7});
  EXPECT_NEAR(control.low, 1.0 / 7, 1e-12);
  for (const float v : control.values.values()) EXPECT_NEAR(v, 0.0F, 1e-6F);  // maps are float
  EXPECT_THROW((void)tangent_sphere_map(map, {.largest_mm = 0}), InvalidInput);
}

TEST(TangentSphereMap, InsideAHollowSphereIsItsRadius) {
  const double radius = 3.0;
  const TexelMap map(make_patch(48, 24,
                                [&](double u, double v) {
                                  const double a = -2 * std::numbers::pi * u,
                                               b = std::numbers::pi * (0.05 + 0.9 * v - 0.5);
                                  return Vec3(radius * std::sin(a) * std::cos(b), radius * std::sin(b),
                                              radius * std::cos(a) * std::cos(b));
                                }),
                     16, 8);  // few texels: all points of a sphere are equally near its middle, the worst case
  const ControlMap control = tangent_sphere_map(map, {.full_percent = 100});
  for (int y = 2; y < 6; ++y) EXPECT_NEAR(1.0 / value_at(control, y * 16 + 7), radius, 0.05 * radius);
}

}  // namespace
}  // namespace patinate
