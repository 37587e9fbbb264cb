// Pieces that stand off a surface in pictures.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "patinate/core/error.h"
#include "patinate/output/render_surface.h"
#include "tests/libcommon/output/bare_render.h"

namespace patinate {
namespace {

/// A square in the plane z that faces +z.
Mesh square(double half, double z) {
  Mesh mesh;
  mesh.positions = {{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = mesh.uv_triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangle_surface = {0, 0};
  mesh.surfaces = {{"square", ""}};
  return mesh;
}

std::shared_ptr<const SurfacePieces> red_square(double half, double z) {
  SurfacePieces pieces{.mesh = square(half, z), .materials = {0, 0}, .maps = {}};
  ImageF red(1, 1, 3);
  red.at(0, 0, 0) = 1.0F;
  pieces.maps.push_back({.color = red});
  return std::make_shared<const SurfacePieces>(std::move(pieces));
}

RenderOptions from_the_front() {
  RenderOptions o = testing_support::bare(200, 4);
  o.azimuth_deg = o.elevation_deg = 0.0;
  o.light = 1.0;
  o.light_azimuth_deg = -45.0;
  o.light_elevation_deg = 0.0;
  o.fov_deg = 1.0;
  return o;
}

struct Counts {
  double red = 0.0, dark = 0.0, white = 0.0;
};
Counts counts(const ImageF& picture) {
  Counts all;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const std::span<const float> p = picture.pixel(x, y);
      constexpr float kLit = 0.35F;  // Half of the light at 45 degrees.
      if (p[0] > kLit && p[1] < kLit) ++all.red;
      if (p[0] < kLit) ++all.dark;
      if (p[0] > kLit && p[1] > kLit) ++all.white;
    }
  }
  return all;
}

TEST(SurfacePieces, ShowTheirOwnColorAndCastAShadowOfTheirSize) {
  // Light from 45 degrees on the left throws the shadow of a square 0.6 above a plane by 0.6 to the right: beside the
  // square of side 0.4, as large.
  constexpr double kSide = 0.4;
  const SurfaceMaps maps{.color = testing_support::kWhite, .pieces = red_square(0.5 * kSide, 0.6)};
  const Counts all = counts(SurfaceView(square(1.0, 0.0), maps, from_the_front()).picture());
  const Counts bare =
      counts(SurfaceView(square(1.0, 0.0), {.color = testing_support::kWhite}, from_the_front()).picture());
  EXPECT_EQ(bare.red + bare.dark, 0.0);
  const double pixels_a_side = (1.0 - 0.08) * 200.0 / 2.0;  // RenderOptions::margin.
  const double expected = kSide * kSide * pixels_a_side * pixels_a_side;
  const double rim = 4.0 * kSide * pixels_a_side;  // A pixel along the outline.
  EXPECT_NEAR(all.red, expected, rim);
  EXPECT_NEAR(all.dark, all.red, rim);
}

TEST(SurfacePieces, NoneIsTheSurfaceAlone) {
  const auto none = std::make_shared<const SurfacePieces>();
  const SurfaceMaps with{.color = testing_support::kWhite, .pieces = none};
  const SurfaceMaps without{.color = testing_support::kWhite};
  EXPECT_EQ(SurfaceView(square(1.0, 0.0), with, from_the_front()).picture(),
            SurfaceView(square(1.0, 0.0), without, from_the_front()).picture());
}

TEST(SurfacePieces, AreThoseOfTheMapsThatAreShown) {
  const SurfaceMaps with{.color = testing_support::kWhite, .pieces = red_square(0.2, 0.6)};
  SurfaceView view(square(1.0, 0.0), {.color = testing_support::kWhite}, from_the_front());
  view.show(with);
  EXPECT_EQ(view.picture(), SurfaceView(square(1.0, 0.0), with, from_the_front()).picture());
}

TEST(SurfacePieces, WithoutMapsAreRefused) {
  SurfacePieces pieces = *red_square(0.2, 0.6);
  pieces.materials = {0, 1};
  const SurfaceMaps maps{.color = testing_support::kWhite,
                         .pieces = std::make_shared<const SurfacePieces>(std::move(pieces))};
  EXPECT_THROW(SurfaceView(square(1.0, 0.0), maps, from_the_front()), InvalidInput);
}

}  // namespace
}  // namespace patinate
