#include "patinate/output/render_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "libcommon/geometry/ray_scene.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/cushions.h"
#include "libcommon/output/orbit_camera.h"
#include "libcommon/output/plantlets.h"
#include "libcommon/output/relief.h"
#include "libcommon/output/surface_material.h"
#include "patinate/core/error.h"
#include "tests/libcommon/output/ball.h"
#include "tests/libcommon/output/bare_render.h"
#include "tests/support/meshes.h"

namespace patinate {
namespace {

using testing_support::ball;
using testing_support::kWhite;
using testing_support::plate;

RenderOptions bare_of_many_samples() { return testing_support::bare(64, 16); }

ImageF one(float value) { return {1, 1, 1, value}; }

ImageF normal_map(const Vec3& n) {
  ImageF map(1, 1, 3);
  for (int c = 0; c < 3; ++c) map.at(0, 0, c) = static_cast<float>(n[c]);
  return map;
}

double mean(const ImageF& picture) {
  double sum = 0.0;
  for (const float v : picture.values()) sum += static_cast<double>(v);
  return sum / static_cast<double>(picture.values().size());
}

/// A wave over the texels, so that no two neighbors are equal.
ImageF waves(int side, double size) {
  ImageF height(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) height.at(x, y) = static_cast<float>(size * std::sin(1.7 * x + 0.9 * y));
  }
  return height;
}

// White furnace: a convex white body in white light cannot be told from it, whatever it is made of. Without the energy
// that single scattering loses, the roughest metal would be at 1 - ln 2 = 0.31 in the middle.
TEST(SurfaceView, ShowsAConvexWhiteBodyInWhiteLightAsWhiteWhateverItIsMadeOf) {
  for (const float metal : {0.0f, 0.5f, 1.0f}) {
    for (const float roughness : {0.05f, 0.4f, 1.0f}) {
      for (const float wet : {0.0f, 0.6f}) {
        RenderOptions o = bare_of_many_samples();
        o.ambient = 1.0;
        o.specular = 0.04;
        const SurfaceMaps maps{
            .color = kWhite, .roughness = one(roughness), .metalness = one(metal), .wetness = one(wet)};
        const ImageF picture = SurfaceView(ball(1.0, 48), maps, o).picture();
        // The table of energies is good to 1.2 %; the mean over the picture has a white backdrop in a quarter of it.
        EXPECT_NEAR(mean(picture), 1.0, 0.012) << metal << " " << roughness << " " << wet;
      }
    }
  }
}

TEST(SurfaceView, ShowsAWhiteBodyInWhiteSurroundingsAsWhite) {
  RenderOptions o = bare_of_many_samples();
  const SurfaceMaps maps{.color = kWhite, .roughness = one(0.5f)};
  const ImageF picture =
      SurfaceView(ball(1.0, 48), maps, o, {.environment_light = 1.0}, ImageF(16, 8, 3, 7.0f)).picture();
  EXPECT_NEAR(mean(picture), 1.0, 0.012);
}

// Every column and row of the surroundings has a color of its own; a smooth metal ball shows the one in the mirror
// direction.
TEST(SurfaceView, AMirrorShowsTheSurroundingsInTheMirrorDirection) {
  ImageF sky(64, 32, 3, 0.1f);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) {
      sky.at(x, y, 0) = static_cast<float>(0.5 + 0.4 * std::sin(2.0 * std::numbers::pi * (x + 0.5) / 64));
      sky.at(x, y, 1) = static_cast<float>((y + 0.5) / 32);
    }
  }
  for (const UpAxis up : {UpAxis::Y, UpAxis::Z}) {
    RenderOptions o = bare_of_many_samples();
    o.width = o.height = 96;
    o.azimuth_deg = 40.0;
    o.elevation_deg = 10.0;
    o.up = up;
    const Mesh mesh = ball(1.0, 96);
    const SurfaceMaps maps{.color = kWhite, .roughness = one(0.05f), .metalness = one(1.0f)};
    const SurfaceView view(mesh, maps, o, {.environment_light = 0.0}, sky);
    const ImageF picture = view.picture();
    const OrbitCamera camera = fitted_camera(mesh, o);
    int num_checked = 0;
    for (int y = 8; y < 96; y += 4) {
      for (int x = 8; x < 96; x += 4) {
        const Vec3 d = camera.direction((x + 0.5) / 96, (y + 0.5) / 96);
        const double b = camera.position.dot(d), disc = b * b - camera.position.squaredNorm() + 1.0;
        if (disc < 0.2) continue;  // Grazing pixels see too many directions.
        const Vec3 n = camera.position + (-b - std::sqrt(disc)) * d;
        const Vec3 r = d - 2.0 * d.dot(n) * n;
        // In the camera's upright axes: the middle of the sky is what the camera looks toward.
        const Vec3 upright = up == UpAxis::Y ? Vec3(Vec3::UnitY()) : Vec3(Vec3::UnitZ());
        const Vec3 back = camera.right.cross(upright);
        const double u = 0.5 + std::atan2(r.dot(camera.right), -r.dot(back)) / (2.0 * std::numbers::pi);
        const double v = std::acos(r.dot(upright)) / std::numbers::pi;
        if (v < 0.1 || v > 0.9) continue;
        // Facets turn reflections by up to 2 pi / 192, twice; the sky's own pixels are 1 / 64 of a turn: 0.04.
        EXPECT_NEAR(picture.at(x, y, 0), 0.5 + 0.4 * std::sin(2.0 * std::numbers::pi * u), 0.06);
        EXPECT_NEAR(picture.at(x, y, 1), v, 0.04);
        ++num_checked;
      }
    }
    EXPECT_GT(num_checked, 100);
  }
}

// A bright spot in black surroundings is a lamp: a plate that faces it is lit as by a lamp of its irradiance.
TEST(SurfaceView, ABrightSpotOfTheSurroundingsIsALamp) {
  ImageF sky(64, 32, 3);
  for (int c = 0; c < 3; ++c) sky.at(10, 7, c) = 500.0f;
  const double pi = std::numbers::pi;
  const double solid_angle = 2.0 * pi / 64 * (std::cos(pi * 7 / 32) - std::cos(pi * 8 / 32));
  RenderOptions o = bare_of_many_samples();
  o.elevation_deg = 90.0;
  const SurfaceMaps maps{.color = kWhite, .roughness = one(1.0f)};
  const ImageF picture = SurfaceView(plate(2.0, 0.0), maps, o, {.environment_light = 0.0}, sky).picture();
  // A pixel is 6 degrees high: its middle's cosine is off by less than 0.3 %; the smooth rest is 4 times the mean.
  EXPECT_NEAR(picture.at(32, 32, 0), 500.0 * solid_angle * std::cos(pi * 7.5 / 32) / pi,
              0.01 * 500.0 * solid_angle / pi);
}

TEST(SurfaceView, FlatNormalsAndNoHeightAreNoMaps) {
  RenderOptions o = bare_of_many_samples();
  o.light = 1.0, o.ambient = 0.3, o.specular = 0.04;
  const Mesh mesh = testing_support::cut_plane(2.0);
  const ImageF without = SurfaceView(mesh, {.color = kWhite}, o).picture();
  const ImageF flat = SurfaceView(mesh, {.color = kWhite, .normals = normal_map({0, 0, 1})}, o).picture();
  const ImageF level = SurfaceView(mesh, {.color = kWhite, .height = ImageF(8, 8, 1)}, o).picture();
  for (std::size_t i = 0; i < flat.values().size(); ++i) {
    ASSERT_NEAR(flat.data()[i], without.data()[i], 1e-5f);   // Rounding.
    ASSERT_NEAR(level.data()[i], without.data()[i], 1e-4f);  // Smaller triangles: rays begin at other last digits.
  }
}

TEST(SurfaceView, NormalsAreLitInTheirTangentSpace) {
  RenderOptions o = bare_of_many_samples();
  o.light = 1.0;
  o.azimuth_deg = o.elevation_deg = 0.0;
  const double a = o.light_azimuth_deg * std::numbers::pi / 180.0, e = o.light_elevation_deg * std::numbers::pi / 180.0;
  const Vec3 lamp(std::cos(e) * std::sin(a), std::sin(e), std::cos(e) * std::cos(a));
  for (const Vec3& normal : {lamp, Vec3(0, 0, 1), Vec3(-lamp.x(), lamp.y(), lamp.z())}) {
    const SurfaceMaps maps{.color = kWhite, .normals = normal_map(normal)};
    const ImageF picture = SurfaceView(testing_support::unit_plane(2.0), maps, o).picture();
    EXPECT_NEAR(picture.at(32, 32, 1), std::max(0.0, normal.dot(lamp)), 1e-5);
  }
}

TEST(SurfaceView, ShowsOtherMapsAsAFreshViewDoes) {
  RenderOptions o = bare_of_many_samples();
  o.light = 1.0;
  o.samples = 1;
  const Mesh plane = testing_support::unit_plane(2.0);
  const auto maps_of = [](int side, float amplitude) {
    return SurfaceMaps{.color = kWhite, .height = waves(side, amplitude)};
  };
  SurfaceView view(plane, maps_of(32, 0.1f), o);
  for (const int side : {32, 48}) {  // Heights of the same size, and of another.
    view.show(maps_of(side, 0.2f));
    EXPECT_EQ(view.picture(), SurfaceView(plane, maps_of(side, 0.2f), o).picture());
  }
}

/// The mesh refined to the map's texels and displaced by it.
Mesh moved_by(Mesh mesh, const ImageF& height, double factor) {
  std::vector<float> open(mesh.positions.size(), 1.0f);
  Mesh refined = refined_to_texels(std::move(mesh), height, 100'000, open);
  EXPECT_EQ(open.size(), refined.positions.size());
  return displaced(std::move(refined), height, factor, ReliefNormals::Turned);
}

TEST(Relief, OfAConstantHeightIsTheSurfaceMovedByIt) {
  const Mesh plane = with_normals(testing_support::cut_plane(2.0));
  const Mesh moved = moved_by(plane, ImageF(64, 64, 1, 0.25f), 2.0);
  EXPECT_GT(moved.num_triangles(), plane.num_triangles());
  for (const Vec3& p : moved.positions) EXPECT_NEAR(p.z(), 0.5, 1e-12);
  for (const Vec3& n : moved.normals) EXPECT_NEAR(n.z(), 1.0, 1e-12);
}

TEST(Relief, FollowsTheTexelsOfARamp) {
  ImageF ramp(32, 32, 1);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) ramp.at(x, y) = static_cast<float>(0.1 * (x + 0.5) / 32);
  }
  const Mesh mesh = moved_by(with_normals(testing_support::unit_plane(2.0)), ramp, 1.0);
  const double edge = 1.0 / 32;  // The ramp ends half a texel before the rim.
  for (const Vec3& p : mesh.positions) {
    if (p.x() / 2.0 < edge || p.x() / 2.0 > 1.0 - edge) continue;
    EXPECT_NEAR(p.z(), 0.1 * p.x() / 2.0, 1e-6);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3& p = mesh.positions[mesh.triangles[t][0]];
    if (p.x() < 0.2 || p.x() > 1.8) continue;
    const Vec3& n = mesh.normals[mesh.normal_triangles[t][0]];
    EXPECT_NEAR(n.x() / n.z(), -0.05, 1e-6);
  }
}

// A ball whose positions are not shared along the seam of its UVs, and whose map does not fit together there.
TEST(Relief, OfAClosedBodyLetsNoRayOutAlongItsSeams) {
  Mesh closed = ball(1.0, 24);
  for (Vec3& p : closed.positions) {
    for (double& x : p) x = std::round(x * 1e9) * 1e-9;  // Both ends of the seam are where sine says but for rounding.
  }
  const Mesh mesh = moved_by(with_shared_positions(std::move(closed)), waves(96, 0.03), 1.0);
  const RayScene scene(mesh);
  constexpr int kRays = 20000;
  for (int i = 0; i < kRays; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / kRays, a = 2.399963 * i, r = std::sqrt(1.0 - z * z);
    ASSERT_TRUE(scene.first_hit({0.01, 0.02, 0.03}, Vec3(r * std::cos(a), z, r * std::sin(a)))) << i;
  }
  // Straight at the seam, which lies at x = 0, z > 0.
  for (int i = 0; i < kRays; ++i) {
    const double e = std::numbers::pi * ((i + 0.5) / kRays - 0.5);
    ASSERT_TRUE(scene.first_hit(Vec3::Zero(), Vec3(0.0, std::sin(e), std::cos(e)))) << i;
  }
}

TEST(WetSurface, IsDarkerUnlessItIsWhiteAndKeepsBlack) {
  EXPECT_NEAR(wet_albedo(Vec3::Ones()).x(), 1.0, 1e-12);
  EXPECT_EQ(wet_albedo(Vec3::Zero()).x(), 0.0);
  for (const double albedo : {0.1, 0.3, 0.5, 0.8}) EXPECT_LT(wet_albedo(Vec3::Constant(albedo)).x(), 0.95 * albedo);
  // By hand: p = 1 - (1 - 0.066) / 1.33^2 = 0.472; (1 - p) 0.5 / (1 - p 0.5).
  EXPECT_NEAR(wet_albedo(Vec3::Constant(0.5)).x(), 0.3456, 1e-4);
}

TEST(WetSurface, IsDarkerAndShinesInAPicture) {
  RenderOptions o = bare_of_many_samples();
  o.light = 1.0, o.light_size_deg = 5.0;
  o.roughness = 0.9, o.specular = 0.04;
  const ImageF gray(1, 1, 3, 0.3f);
  const ImageF dry = SurfaceView(ball(1.0, 48), {.color = gray}, o).picture();
  const ImageF wet = SurfaceView(ball(1.0, 48), {.color = gray, .wetness = one(1.0f)}, o).picture();
  EXPECT_LT(wet.at(32, 32), 0.8f * dry.at(32, 32));
  float brightest_dry = 0.0f, brightest_wet = 0.0f;
  for (int y = 16; y < 48; ++y) {
    for (int x = 16; x < 48; ++x) {
      brightest_dry = std::max(brightest_dry, dry.at(x, y));
      brightest_wet = std::max(brightest_wet, wet.at(x, y));
    }
  }
  EXPECT_GT(brightest_wet, 2.0f * brightest_dry);
}

TEST(WetSurface, HalfWetIsDarkerAndNoShinier) {
  const auto material = [](double wetness) {
    SeenPoint point;
    point.normal = point.smooth = point.view = Vec3::UnitZ();
    point.color = Vec3::Constant(0.3);
    point.specular = Vec3::Constant(0.04);
    point.roughness = 0.9;
    point.wetness = wetness;
    return SurfaceMaterial(point);
  };
  EXPECT_LT(material(0.5).diffuse().x(), 0.85 * material(0.0).diffuse().x());
  EXPECT_DOUBLE_EQ(material(0.5).reflected(), material(0.0).reflected());
  EXPECT_GT(material(0.75).reflected(), material(0.0).reflected());
}

// 36 rays a pixel, of which a fifth falls below the surface and counts 0: independent ones would spread by 0.065 of the
// mean; four times that. Rays of one sequence with gaps lay in one place, and pixels were black.
TEST(SurfaceView, EveryPixelOfARoughMetalIsNearTheMean) {
  RenderOptions o = bare_of_many_samples();
  o.samples = 9;
  o.ambient = 1.0;
  const SurfaceMaps maps{.color = ImageF(1, 1, 3, 0.2f), .roughness = one(0.7f), .metalness = one(1.0f)};
  const ImageF picture = SurfaceView(ball(1.0, 48), maps, o).picture();
  const double middle = mean(crop(picture, 24, 24, 16, 16));
  for (int y = 24; y < 40; ++y) {
    for (int x = 24; x < 40; ++x) EXPECT_NEAR(picture.at(x, y), middle, 0.26 * middle) << x << " " << y;
  }
}

// A red plate beside a mirror: the mirror is red where the plate is reflected, by one bounce.
TEST(SurfaceView, ReflectsWhatStandsBesideIt) {
  Mesh mesh = plate(2.0, 0.0);
  Mesh wall = plate(2.0, 0.0);
  const int offset = static_cast<int>(mesh.positions.size());
  for (Vec3& p : wall.positions) p = Vec3(p.x(), p.z() + 1.0, -1.0);  // Stands at the far side, faces +z.
  for (Vec2& uv : wall.uvs) uv.x() = 2.0;                             // The last texel.
  for (Vec2& uv : mesh.uvs) uv.x() = -1.0;                            // The first.
  mesh.positions.insert(mesh.positions.end(), wall.positions.begin(), wall.positions.end());
  mesh.uvs.insert(mesh.uvs.end(), wall.uvs.begin(), wall.uvs.end());
  for (Triangle t : wall.triangles) {
    for (int& i : t) i += offset;
    mesh.triangles.push_back(t);
    mesh.uv_triangles.push_back(t);
    mesh.triangle_surface.push_back(0);
  }
  SurfaceMaps maps{.color = ImageF(2, 1, 3, 1.0f), .roughness = one(0.05f), .metalness = ImageF(2, 1, 1)};
  maps.metalness.at(0, 0) = 1.0f;
  maps.color.at(1, 0, 1) = maps.color.at(1, 0, 2) = 0.0f;
  RenderOptions o = bare_of_many_samples();
  o.ambient = 1.0;
  o.azimuth_deg = 0.0, o.elevation_deg = 30.0;
  const OrbitCamera camera = fitted_camera(mesh, o);
  const Vec3 q = Vec3(0.0, 0.0, -0.6) - camera.position;  // On the mirror, near the wall.
  const double z = -q.dot(camera.backward);
  const int x = static_cast<int>(32.0 * (1.0 + q.dot(camera.right) / (z * camera.tan_x)));
  const int y = static_cast<int>(32.0 * (1.0 - q.dot(camera.up) / (z * camera.tan_y)));
  const ImageF picture = SurfaceView(mesh, maps, o).picture();
  EXPECT_NEAR(picture.at(x, y, 0), 1.0f, 0.03f);
  EXPECT_LT(picture.at(x, y, 1), 0.1f);
}

TEST(SurfaceView, DoesNotDependOnThreadsAndTurnsWithTheCamera) {
  RenderOptions o;
  o.width = o.height = 48;
  o.samples = 4;
  o.occlusion_samples = 8;
  const SurfaceMaps maps{.color = kWhite, .height = waves(64, 0.02), .wetness = one(0.5f)};
  RunControl one_thread, three_threads;
  one_thread.num_threads = 1;
  three_threads.num_threads = 3;
  const ImageF sky(32, 16, 3, 0.5f);
  const SurfaceView view(ball(1.0, 16), maps, o, {}, sky, one_thread);
  EXPECT_EQ(view.picture(one_thread),
            SurfaceView(ball(1.0, 16), maps, o, {}, sky, three_threads).picture(three_threads));
  EXPECT_EQ(view.picture(o.azimuth_deg, o.elevation_deg), view.picture());
  EXPECT_NE(view.picture(o.azimuth_deg + 90.0, o.elevation_deg), view.picture());
}

TEST(SurfaceView, LooksAtItsTargetFromItsDistance) {
  RenderOptions o;
  o.target = Vec3(1.0, 2.0, 3.0);
  o.distance = 7.0;
  const OrbitCamera camera = fitted_camera(ball(1.0, 8), o);
  EXPECT_NEAR((camera.position - *o.target).norm(), 7.0, 1e-12);
  EXPECT_NEAR((camera.position + 7.0 * camera.direction(0.5, 0.5) - *o.target).norm(), 0.0, 1e-12);
}

TEST(SurfaceView, ACoarseBallIsAsRoundAsItsNormals) {
  RenderOptions o;
  o.width = o.height = 96;
  o.samples = 4;
  o.occlusion_samples = 0;
  o.ground = false;
  o.backdrop = Backdrop::White;
  const auto covered = [&](int segments) {
    const ImageF picture = SurfaceView(ball(1.0, segments), {.color = ImageF(1, 1, 3, 0.0f)}, o, {}).picture();
    double sum = 0.0;
    for (int y = 0; y < o.height; ++y) {
      for (int x = 0; x < o.width; ++x) sum += picture.at(x, y, 1) < 0.5f ? 1.0 : 0.0;
    }
    return sum;
  };
  // Its flat triangles leave out a tenth of the disk: 1 - sin(pi / 4) / (pi / 4).
  EXPECT_NEAR(covered(8) / covered(64), 1.0, 0.02);
}

TEST(Plants, StandWhereTheAmountIsHighAndStayWhenItGrows) {
  const Mesh mesh = plate(2.0, 0.0);
  SurfaceMaps maps{.color = kWhite, .plants = ImageF(2, 1, 1)};
  maps.plants.at(0, 0) = 0.55f;  // Plants of the left half; nothing grows on the right one's far side.
  const SurfaceOptions surface{.plant_size = 0.05};
  const std::vector<Plant> few = find_plants(mesh, maps, {}, surface);
  maps.plants.at(0, 0) = 0.9f;
  const std::vector<Plant> many = find_plants(mesh, maps, {}, surface);
  EXPECT_GT(few.size(), 10u);
  EXPECT_GT(many.size(), 2 * few.size());
  for (const Plant& plant : many) EXPECT_LT(plant.root.x(), 0.7);  // Bilinear: 0.18 of 0.9 is at u = 0.65 at most.
  std::size_t found = 0;
  int grown = 0;
  for (const Plant& plant : few) {
    for (const Plant& other : many) {
      if (plant.root != other.root || plant.turn != other.turn) continue;
      ++found;
      EXPECT_EQ(plant.kind, other.kind);
      EXPECT_GE(other.size, plant.size);
      grown += other.size > plant.size ? 1 : 0;
    }
  }
  EXPECT_GT(grown, static_cast<int>(few.size()) / 4);
  EXPECT_EQ(found, few.size());
  // All of them at most: 1.5 for each square of a plant's height, 4 sigma; each triangle rounds by itself.
  maps.plants = one(1.0f);
  const double expected = 1.5 * 4.0 / (0.05 * 0.05);
  EXPECT_NEAR(static_cast<double>(find_plants(mesh, maps, {}, surface).size()), expected, 4.0 * std::sqrt(128 * 0.25));
  EXPECT_TRUE(find_plants(mesh, maps, {}, {.plants = 0.0}).empty());
}

TEST(Plants, StandInCushionsThatAreTallInTheirMiddle) {
  const Mesh mesh = plate(2.0, 0.0);
  const double size = 0.02;
  const SurfaceOptions options{.plant_size = size, .plant_cushion = 12.0};
  SurfaceMaps maps{.color = kWhite, .plants = one(0.4f)};
  // Amount 0.4 suffices where 0.18 + 0.57 (0.7 (1 - depth) + 0.3 chance) does: never below a depth of 0.44.
  const std::vector<Plant> few = find_plants(mesh, maps, {}, options);
  ASSERT_GT(few.size(), 100u);
  for (const Plant& plant : few) EXPECT_GT(cushion_at(plant.root, 12.0 * size).depth, 0.44);
  // Where all stand: 1 + 1.4 height times as tall, 0.5 to 1.5 by chance. Above 0.5 more than 1.7 in the mean, below
  // 0.2 less than 1.28, each to 0.29 / sqrt(100).
  maps.plants = one(1.0f);
  double tall = 0.0, low = 0.0;
  int num_tall = 0, num_low = 0;
  for (const Plant& plant : find_plants(mesh, maps, {}, options)) {
    const double height = cushion_at(plant.root, 12.0 * size).height;
    if (height > 0.5) tall += plant.size, ++num_tall;
    if (height < 0.2) low += plant.size, ++num_low;
  }
  ASSERT_GT(num_tall, 100);
  ASSERT_GT(num_low, 100);
  EXPECT_GT(tall / num_tall, 1.3 * low / num_low);
  // Without cushions none is taller than by chance.
  for (const Plant& plant : find_plants(mesh, maps, {}, {.plant_size = size, .plant_cushion = 0.0}))
    EXPECT_LE(plant.size, 1.5 * size);
}

TEST(Cushions, AreBallsOfDifferentSizesWithTheirMiddleInside) {
  double highest = 0.0;
  int outside = 0;
  for (int i = 0; i < 20000; ++i) {
    const CushionPlace at = cushion_at({0.013 * i, 1.7, -0.4}, 1.0);
    ASSERT_LE(at.outward.norm(), 1.0);
    ASSERT_GE(at.height, 0.0);
    highest = std::max(highest, at.height);
    outside += at.height == 0.0 ? 1 : 0;
    EXPECT_NEAR(at.depth, at.height == 0.0 ? 0.0 : 1.0 - at.outward.squaredNorm(), 1e-12);
  }
  EXPECT_GT(highest, 0.5);
  EXPECT_GT(outside, 2000);
}

TEST(SurfaceView, RefusesWhatItCannotShow) {
  const Mesh mesh = ball(1.0, 8);
  EXPECT_THROW(SurfaceView(mesh, {}, bare_of_many_samples()), InvalidInput);
  EXPECT_THROW(SurfaceView(mesh, {.color = kWhite, .height = kWhite}, bare_of_many_samples()), InvalidInput);
  EXPECT_THROW(SurfaceView(mesh, {.color = kWhite}, bare_of_many_samples(), {.relief = std::nan("")}), InvalidInput);
  EXPECT_THROW(SurfaceView(mesh, {.color = kWhite}, bare_of_many_samples(), {}, ImageF(8, 4, 3)),
               InvalidInput);  // Black.
  RenderOptions o = bare_of_many_samples();
  o.distance = -1.0;
  EXPECT_THROW(SurfaceView(mesh, {.color = kWhite}, o), InvalidInput);
}

}  // namespace
}  // namespace patinate
