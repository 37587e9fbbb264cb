#include "patinate/output/render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "libcommon/output/orbit_camera.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/libcommon/output/ball.h"
#include "tests/libcommon/output/bare_render.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::ball;
using testing_support::kWhite;
using testing_support::plate;

RenderOptions bare_of_one_sample() { return testing_support::bare(96, 1); }

struct Extent {
  int x0 = 1 << 20, x1 = -1, y0 = 1 << 20, y1 = -1;
};

Extent extent(const ImageU8& mask) {
  Extent e;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask.at(x, y) == 0) continue;
      e.x0 = std::min(e.x0, x), e.x1 = std::max(e.x1, x), e.y0 = std::min(e.y0, y), e.y1 = std::max(e.y1, y);
    }
  }
  return e;
}

// White furnace: all that a convex white body sees is the ambient light.
TEST(Render, ShowsAConvexWhiteBodyInWhiteLightAsWhite) {
  RenderOptions o = bare_of_one_sample();
  o.ambient = 1.0;
  o.occlusion_samples = 32;
  const ImageF picture = render(ball(1.0, 24), kWhite, o);
  for (const float value : picture.values()) EXPECT_NEAR(value, 1.0f, 1e-5f);
}

/// @param light_distance  From the middle of the sphere; 0 = far.
void shade_a_sphere(double light_distance) {
  RenderOptions o = bare_of_one_sample();
  o.light = 1.0;
  o.azimuth_deg = o.elevation_deg = 0.0;
  o.light_azimuth_deg = 30.0;
  o.light_elevation_deg = 25.0;
  o.light_distance = light_distance;
  o.width = o.height = 128;
  const Mesh mesh = ball(1.0, 128);
  const RenderView view(mesh, o);
  const ImageF picture = view.shade(kWhite);
  const ImageU8 mask = view.coverage();
  const OrbitCamera camera = fitted_camera(mesh, o);
  const double a = 30.0 * M_PI / 180.0, e = 25.0 * M_PI / 180.0;
  const Vec3 light(std::cos(e) * std::sin(a), std::sin(e), std::cos(e) * std::cos(a));
  int num_checked = 0;
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      const Vec3 d = camera.direction((x + 0.5) / 128, (y + 0.5) / 128);
      // Closed form: nearer intersection with the unit sphere; its normal is its position.
      const double b = camera.position.dot(d), disc = b * b - camera.position.squaredNorm() + 1.0;
      if (disc < 0.02 || mask.at(x, y) == 0) continue;
      const Vec3 n = camera.position + (-b - std::sqrt(disc)) * d;
      // A near light's own direction and distance; 1 / distance^2 is 1 in the middle.
      const Vec3 way = light_distance > 0.0 ? Vec3(light_distance * light - n) : light;
      const double facing = n.dot(way.normalized());
      const double strength = light_distance > 0.0 ? light_distance * light_distance / way.squaredNorm() : 1.0;
      if (std::abs(facing) < 0.03) continue;  // The facets' own shadow line.
      // The facets lie up to 1 - cos(pi / 128) = 3e-4 inside; seen obliquely that moves the hit, and the normal, by
      // more.
      EXPECT_NEAR(picture.at(x, y, 0), strength * std::max(0.0, facing), 0.01 * strength) << x << " " << y;
      ++num_checked;
    }
  }
  EXPECT_GT(num_checked, 5000);
}

TEST(Render, ShadesASphereByLambertsLaw) { shade_a_sphere(0.0); }
TEST(Render, ANearLightFallsOffWithTheSquareOfItsDistance) { shade_a_sphere(2.5); }

TEST(Render, FramesTheMeshFromEverySide) {
  Mesh mesh = ball(1.0, 24);
  for (Vec3& p : mesh.positions) p = Vec3(3.0 * p.x() + 40.0, 0.5 * p.y() - 7.0, p.z() + 11.0);
  for (const double azimuth : {0.0, 70.0, 200.0}) {
    for (const double elevation : {-80.0, 0.0, 35.0}) {
      RenderOptions o = bare_of_one_sample();
      o.width = 200, o.height = 120, o.samples = 4, o.margin = 0.1;
      o.azimuth_deg = azimuth, o.elevation_deg = elevation;
      const Extent e = extent(RenderView(mesh, o).coverage());
      // 5 % stay free on both sides of the tighter axis: 10 of 200 or 6 of 120 pixels; a pixel for its partial cover.
      const bool is_wide = e.x0 <= 11;
      EXPECT_GE(e.x0, 9);
      EXPECT_LE(e.x1, 190);
      EXPECT_GE(e.y0, 5);
      EXPECT_LE(e.y1, 114);
      if (is_wide) {
        EXPECT_NEAR(e.x0, 10, 1.01);
        EXPECT_NEAR(e.x1, 189, 1.01);
      } else {
        EXPECT_NEAR(e.y0, 6, 1.01);
        EXPECT_NEAR(e.y1, 113, 1.01);
      }
      EXPECT_NEAR(e.x0 + e.x1, 199, 3.0);
      EXPECT_NEAR(e.y0 + e.y1, 119, 3.0);
    }
  }
}

TEST(Render, ZUpIsTheSamePictureOfATurnedMesh) {
  Mesh mesh = ball(1.0, 12);
  for (Vec3& p : mesh.positions) p = Vec3(2.0 * p.x(), p.y(), 0.5 * p.z());
  Mesh turned = mesh;
  for (Vec3& p : turned.positions) p = Vec3(p.x(), -p.z(), p.y());
  for (Vec3& n : turned.normals) n = Vec3(n.x(), -n.z(), n.y());
  RenderOptions o = bare_of_one_sample();
  o.light = 1.0;
  const ImageF a = render(mesh, kWhite, o);
  o.up = UpAxis::Z;
  const ImageF b = render(turned, kWhite, o);
  int num_different = 0;
  for (std::size_t i = 0; i < a.values().size(); ++i)
    num_different += std::abs(a.values()[i] - b.values()[i]) > 1e-4f ? 1 : 0;
  EXPECT_LE(num_different, static_cast<int>(a.values().size() / 500));  // Rounding at outlines.
}

Mesh both(Mesh mesh, const Mesh& other) {
  const int offset = static_cast<int>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  mesh.uvs.insert(mesh.uvs.end(), other.uvs.begin(), other.uvs.end());
  for (Triangle t : other.triangles) {
    for (int& i : t) i += offset;
    mesh.triangles.push_back(t);
    mesh.uv_triangles.push_back(t);
    mesh.triangle_surface.push_back(0);
  }
  return mesh;
}

// A small plate at height 1 above the middle of a large one.
Mesh table() { return both(plate(4.0, 0.0), plate(1.0, 1.0)); }

// Value that the picture shows at a place in the world.
float seen(const ImageF& picture, const OrbitCamera& camera, const Vec3& p) {
  const Vec3 q = p - camera.position;
  const double z = -q.dot(camera.backward);
  const double u = 0.5 * (1.0 + q.dot(camera.right) / (z * camera.tan_x));
  const double v = 0.5 * (1.0 - q.dot(camera.up) / (z * camera.tan_y));
  return picture.at(static_cast<int>(u * picture.width()), static_cast<int>(v * picture.height()), 0);
}

TEST(Render, CastsTheShadowOfOnePlateOnAnother) {
  RenderOptions o = bare_of_one_sample();
  o.light = 1.0;
  o.light_elevation_deg = 90.0;
  o.elevation_deg = 35.0;
  o.azimuth_deg = 0.0;
  const OrbitCamera camera = fitted_camera(table(), o);
  const ImageF picture = render(table(), kWhite, o);
  EXPECT_NEAR(seen(picture, camera, {0.0, 0.0, 0.4}), 0.0f, 1e-6f);  // Under the small plate.
  EXPECT_NEAR(seen(picture, camera, {0.0, 1.0, 0.0}), 1.0f, 1e-6f);  // On it.
  EXPECT_NEAR(seen(picture, camera, {1.5, 0.0, 0.4}), 1.0f, 1e-6f);  // Beside its shadow.
}

// Errors of neighbors that are independent keep a third of their size in the mean of 3 x 3 pixels; those of a dither
// cancel.
TEST(Render, NeighborsInAPenumbraMakeUpForEachOther) {
  RenderOptions o = bare_of_one_sample();
  o.light = 1.0;
  o.light_size_deg = 20.0;
  o.light_elevation_deg = 90.0;
  o.elevation_deg = 35.0;
  o.azimuth_deg = 0.0;
  const ImageF picture = render(table(), kWhite, o);
  o.samples = 256;
  const ImageF truth = render(table(), kWhite, o);
  double alone = 0.0, together = 0.0;
  int count = 0;
  for (int y = 1; y + 1 < o.height; ++y) {
    for (int x = 1; x + 1 < o.width; ++x) {
      double sum = 0.0;
      bool is_penumbra = true;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const double lit = static_cast<double>(truth.at(x + dx, y + dy, 0));
          is_penumbra = is_penumbra && lit > 0.2 && lit < 0.8;
          sum += static_cast<double>(picture.at(x + dx, y + dy, 0)) - lit;
        }
      }
      if (!is_penumbra) continue;
      const double error = static_cast<double>(picture.at(x, y, 0)) - static_cast<double>(truth.at(x, y, 0));
      alone += error * error;
      together += sum * sum / 81.0;
      ++count;
    }
  }
  ASSERT_GT(count, 100);
  EXPECT_GT(alone / count, 1e-4);  // One sample a pixel errs.
  EXPECT_LT(std::sqrt(together / alone), 1.0 / 3.0);
}

// Part of a disc of radius 1 that is seen beside a straight edge, `x` from its middle.
double lit_share(double x) {
  const double c = std::clamp(x, -1.0, 1.0);
  return 1.0 - (std::acos(c) - c * std::sqrt(1.0 - c * c)) / std::numbers::pi;
}

// Points that are spread evenly over a disc err at a straight edge by their number^-3/4 at most: 64 of a pixel.
TEST(Render, TheGroundShowsASmoothPenumbra) {
  // A roof over one side, and a speck on the ground that says where that is.
  constexpr double kRoof = 8.0;
  Mesh roof = plate(kRoof, 1.0);
  for (Vec3& p : roof.positions) p.x() -= 0.5 * kRoof;
  const Mesh mesh = both(std::move(roof), plate(0.01, 0.0));
  RenderOptions o = bare_of_one_sample();
  o.samples = 4;
  o.light = 1.0;
  o.light_size_deg = 20.0;
  o.light_elevation_deg = 90.0;
  o.ground = true;
  o.elevation_deg = 20.0;
  o.azimuth_deg = 90.0;
  o.target = Vec3(0.0, 0.0, 0.0);
  o.distance = 1.5;
  const OrbitCamera camera = fitted_camera(mesh, o);
  const ImageF picture = render(mesh, kWhite, o);
  double errors = 0.0;
  int count = 0;
  for (int y = 0; y < o.height; ++y) {
    for (int x = 0; x < o.width; ++x) {
      const Vec3 direction = camera.direction((x + 0.5) / o.width, (y + 0.5) / o.height);
      if (!(direction.y() < -0.05)) continue;
      const Vec3 place = camera.position - camera.position.y() / direction.y() * direction;
      const double share = lit_share(place.x() / std::tan(o.light_size_deg * std::numbers::pi / 180.0));
      if (share < 0.02 || share > 0.98 || std::abs(place.z()) < 0.03) continue;
      const double error = static_cast<double>(picture.at(x, y, 0)) - share;
      errors += error * error;
      ++count;
    }
  }
  ASSERT_GT(count, 500);
  EXPECT_LT(std::sqrt(errors / count), std::pow(64.0, -0.75));
}

TEST(Render, AmbientLightIsWeakerUnderARoof) {
  RenderOptions o = bare_of_one_sample();
  o.ambient = 1.0;
  o.occlusion_samples = 256;
  o.elevation_deg = 20.0;
  o.azimuth_deg = 0.0;
  const OrbitCamera camera = fitted_camera(table(), o);
  const ImageF picture = render(table(), kWhite, o);
  EXPECT_LT(seen(picture, camera, {0.0, 0.0, 0.4}), 0.85f);
  EXPECT_GT(seen(picture, camera, {1.8, 0.0, 1.8}), 0.97f);
}

TEST(Render, ReadsTheTextureUpright) {
  // v is up: the texture's upper half is the half of the plate with v > 0.5, which is the far one.
  ImageF texture(2, 2, 3, 0.0f);
  texture.at(0, 0, 0) = texture.at(1, 0, 0) = 1.0f;
  RenderOptions o = bare_of_one_sample();
  o.ambient = 1.0;
  o.azimuth_deg = 0.0;
  o.elevation_deg = 90.0;
  o.backdrop = Backdrop::Studio;
  o.background = 0.0;
  const ImageF picture = render(plate(2.0, 0.0), texture, o);
  EXPECT_NEAR(picture.at(48, 15, 0), 1.0f, 1e-4f);
  EXPECT_NEAR(picture.at(48, 80, 0), 0.0f, 1e-4f);
}

// A plate in the xy plane, u along x and v along y: its tangent space is the world. Where its normals point to the lamp
// it is fully lit, whatever its own direction; the lamp's direction is that of the options.
TEST(Render, NormalsOfATextureAreLitInTheirTangentSpace) {
  RenderOptions o = bare_of_one_sample();
  o.light = 1.0;
  o.azimuth_deg = o.elevation_deg = 0.0;
  const double azimuth = o.light_azimuth_deg * std::numbers::pi / 180.0,
               elevation = o.light_elevation_deg * std::numbers::pi / 180.0;
  const Vec3 lamp(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                  std::cos(elevation) * std::cos(azimuth));
  for (const Vec3& normal : {lamp, Vec3(0, 0, 1), Vec3(-lamp.x(), lamp.y(), lamp.z())}) {
    for (const bool is_mirrored : {false, true}) {
      Mesh mesh = testing_support::unit_plane(2.0);
      SurfaceDetail detail{.normals = ImageF(1, 1, 3)};
      for (int c = 0; c < 3; ++c) detail.normals.at(0, 0, c) = static_cast<float>(normal[c]);
      if (is_mirrored) {
        for (Vec2& uv : mesh.uvs) uv.x() = 1.0 - uv.x();
        detail.normals.at(0, 0, 0) *= -1.0f;
      }
      const ImageF picture = RenderView(mesh, o, detail).shade(kWhite);
      EXPECT_NEAR(picture.at(48, 48, 1), std::max(0.0, normal.dot(lamp)), 1e-5);
    }
  }
}

TEST(Render, FlatDetailIsNoDetail) {
  RenderOptions o = bare_of_one_sample();
  o.light = o.specular = 1.0;
  o.roughness = 0.3;
  SurfaceDetail flat{.normals = ImageF(1, 1, 3), .roughness = ImageF(1, 1, 1, 0.3f)};
  flat.normals.at(0, 0, 2) = 1.0f;
  const Mesh mesh = testing_support::cut_plane(2.0);
  const ImageF with = RenderView(mesh, o, flat).shade(kWhite), without = RenderView(mesh, o).shade(kWhite);
  for (std::size_t i = 0; i < with.values().size(); ++i)
    ASSERT_NEAR(with.data()[i], without.data()[i], 1e-5f);  // Rounding of 0.3f.
  flat.roughness.at(0, 0) = 0.9f;
  EXPECT_NE(RenderView(mesh, o, flat).shade(kWhite), without);
  EXPECT_THROW(RenderView(mesh, o, {.roughness = ImageF(1, 1, 3)}), InvalidInput);
}

TEST(Render, DoesNotDependOnThreads) {
  RenderOptions o;
  o.width = o.height = 64;
  o.occlusion_samples = 8;
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  EXPECT_EQ(render(ball(1.0, 24), kWhite, o, one), render(ball(1.0, 24), kWhite, o, three));
}

TEST(Render, ShowsTheMarbleBustWhole) {
  PATINATE_REQUIRE_DATA(folder, "meshes/marble_bust");
  const Mesh mesh = read_mesh(folder / "marble_bust_01_1k.gltf");
  RenderOptions o;
  o.width = o.height = 128;
  o.samples = 4;
  o.occlusion_samples = 16;
  const RenderView view(mesh, o);
  const Extent e = extent(view.coverage());
  EXPECT_NEAR(e.y0, 5, 1.01);  // 4 % of 128 stay free above and below: it is taller than wide.
  EXPECT_NEAR(e.y1, 122, 1.01);
  const ImageF picture = view.shade(read_color(folder / "textures/marble_bust_01_diff_1k.jpg"));
  // Marble is nearly gray and neither black nor burnt out on average.
  double sum[3] = {0.0, 0.0, 0.0}, count = 0.0;
  const ImageU8 mask = view.coverage();
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      if (mask.at(x, y) == 0) continue;
      for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(picture.at(x, y, c));
      count += 1.0;
    }
  }
  EXPECT_GT(sum[1] / count, 0.15);
  EXPECT_LT(sum[1] / count, 0.6);
  EXPECT_NEAR(sum[0] / sum[2], 1.0, 0.4);
}

TEST(Render, RefusesWhatItCannotShow) {
  Mesh mesh = ball(1.0, 12);
  RenderOptions o = bare_of_one_sample();
  o.width = 3;
  EXPECT_THROW((void)render(mesh, kWhite, o), InvalidInput);
  o = bare_of_one_sample();
  o.zoom = std::nan("");
  EXPECT_THROW((void)render(mesh, kWhite, o), InvalidInput);
  EXPECT_THROW((void)render(mesh, ImageF(), bare_of_one_sample()), InvalidInput);
  o = bare_of_one_sample();
  o.width = o.height = 8192;
  o.samples = 256;
  EXPECT_THROW((void)render(mesh, kWhite, o), InvalidInput);
  mesh.uv_triangles.clear();
  EXPECT_THROW((void)render(mesh, kWhite, bare_of_one_sample()), InvalidInput);
}

}  // namespace
}  // namespace patinate
