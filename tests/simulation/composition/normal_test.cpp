#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "patinate/simulation/compose.h"
#include "simulation/composition/height_frames.h"
#include "tests/simulation/composition/compose_scene.h"
#include "tests/support/meshes.h"

namespace patinate::simulation {
namespace {

using testing_support::ComposeScene;
using testing_support::cut_plane;
using testing_support::unit_plane;

constexpr double kPlaneSide = 96.0;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kAmountPerMm = 0.125;  // 8 mm by amount 1: a quantum of amount is half a quantum of height

MaterialAppearance relief() {
  MaterialAppearance look;
  look.strength = 0.0;
  look.height_mm = 1.0 / kAmountPerMm;
  return look;
}

/// A plane whose UVs are moved by a linear map about (0.5, 0.5).
Mesh mapped_plane(const Eigen::Matrix2d& map) {
  Mesh mesh = unit_plane(kPlaneSide);
  for (Vec2& uv : mesh.uvs) uv = map * (uv - Vec2(0.5, 0.5)) + Vec2(0.5, 0.5);
  return mesh;
}

Eigen::Matrix2d matrix(double a, double b, double c, double d) {
  Eigen::Matrix2d m;
  m << a, b, c, d;
  return m;
}

struct NamedMesh {
  const char* name;
  Mesh mesh;
};

std::vector<NamedMesh> planes() {
  return {{"plain", unit_plane(kPlaneSide)},
          {"4:1", mapped_plane(matrix(1.0, 0.0, 0.0, 0.25))},
          {"1:4", mapped_plane(matrix(0.25, 0.0, 0.0, 1.0))},
          {"sheared", mapped_plane(matrix(0.6, 0.35, 0.0, 0.5))},
          {"turned", mapped_plane(matrix(0.5, -0.4, 0.4, 0.5))},
          {"mirrored", mapped_plane(matrix(-0.7, 0.2, 0.1, 0.7))},
          {"cut, half of it turned", cut_plane(kPlaneSide)}};
}

/// Angle between the normal that a composer estimates and another, degrees.
double angle_deg(const ComposeScene& scene, const Composer& composer, TexelIndex t, const Vec3& expected) {
  const Eigen::Matrix<double, 3, 2> step = scene.surface->mm_per_texel(scene.surface->triangle(t)).cast<double>();
  return std::acos(std::clamp(composer.perturbed_normal(t, Vec3(0, 0, 1), step).dot(expected), -1.0, 1.0)) / kDegree;
}

/// Whether a texel has neighbors in one direction only, as the last one in the corner of a turned square.
bool is_tip(const SurfaceAtlas& surface, TexelIndex t) {
  const std::array<TexelIndex, 4> n = surface.neighbors(t);
  return (n[0] == kNoTexel && n[1] == kNoTexel) || (n[2] == kNoTexel && n[3] == kNoTexel);
}

// Rounding: heights to 1/1024 mm on texels of 1 mm and more give 0.06 degrees, where texels are smaller or stretched up
// to four times that.
constexpr double kRoundingDeg = 0.25;

TEST(ComposedNormals, ARampOfTenDegreesTiltsThemByTen) {
  for (const double azimuth : {0.0, 90.0, 200.0}) {
    const Vec3 uphill(std::cos(azimuth * kDegree), std::sin(azimuth * kDegree), 0.0);
    const double slope = std::tan(10.0 * kDegree);
    const Vec3 expected = Vec3(-slope * uphill.x(), -slope * uphill.y(), 1.0).normalized();
    for (const NamedMesh& plane : planes()) {
      ComposeScene scene(plane.mesh, 96, {relief()});
      scene.set(0, [&](int, int, const Vec3& p) {
        return kAmountPerMm * (15.0 + slope * uphill.dot(p - Vec3(kPlaneSide / 2, kPlaneSide / 2, 0)));
      });
      Composer composer = scene.composer();
      (void)composer.compose(*scene.atlas, {});
      double worst = 0.0;
      int num_tips = 0;
      for (TexelIndex t = 0; t < scene.surface->grid().num_texels(); ++t) {
        if (!scene.surface->is_covered(t)) continue;
        if (is_tip(*scene.surface, t)) {
          ++num_tips;
          continue;
        }
        worst = std::max(worst, angle_deg(scene, composer, t, expected));  // also at seams and where the surface ends
        // The map says the same in the frame of glTF: T along +u, B toward +v.
        const composition::TexelFrame frame =
            composition::texel_frame(scene.surface->mm_per_texel(scene.surface->triangle(t)).cast<double>());
        const std::array<double, 3> in_frame{expected.dot(frame.t), expected.dot(frame.b), expected.z()};
        for (std::uint32_t c = 0; c < 3; ++c) {
          const std::uint8_t code = composer.normals()[TileGrid::tile_of(t) * 192 + c * 64 + t % 64];
          ASSERT_NEAR(code, 127.5 + 127.5 * in_frame[c], 1.0) << plane.name << " " << t;
        }
      }
      EXPECT_LT(worst, kRoundingDeg) << plane.name << " " << azimuth;
      EXPECT_LE(num_tips, 4) << plane.name;
    }
  }
}

TEST(ComposedNormals, FollowTheConventionOfGltf) {
  // Uphill along +u: the normal leans to -u, and red is below 128. Uphill along +v (up in the picture): green is below
  // 128.
  for (const bool is_along_u : {true, false}) {
    ComposeScene scene(unit_plane(kPlaneSide), 96, {relief()});
    scene.set(0, [&](int, int, const Vec3& p) { return kAmountPerMm * 0.2 * (is_along_u ? p.x() : p.y()); });
    Composer composer = scene.composer();
    (void)composer.compose(*scene.atlas, {});
    const ImageU8 normal = composer.normal8();
    const double length = std::sqrt(1.04);
    EXPECT_EQ(normal.at(40, 40, is_along_u ? 0 : 1), std::lround(127.5 - 127.5 * 0.2 / length));
    EXPECT_EQ(normal.at(40, 40, is_along_u ? 1 : 0), 128);
    EXPECT_EQ(normal.at(40, 40, 2), std::lround(127.5 + 127.5 / length));
  }
}

TEST(ComposedNormals, AFlatSurfaceIsExactlyBlue) {
  MaterialAppearance paint = relief();
  paint.strength = 1.0;
  ComposeScene scene(cut_plane(kPlaneSide), 96, {paint});
  scene.set(0, [](int, int, const Vec3&) { return 0.37; });  // raised alike everywhere
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  const ImageU8 normal = composer.normal8();
  for (int i = 0; i < 96 * 96; ++i) {
    ASSERT_EQ(normal.data()[3 * i], 128);
    ASSERT_EQ(normal.data()[3 * i + 1], 128);
    ASSERT_EQ(normal.data()[3 * i + 2], 255);
  }
}

/// Largest difference (degrees) to the normals of waves of 24 mm and 1 mm: of texels at the cut, and of all others but
/// the plane's own edge.
std::pair<double, double> wave_errors(int resolution) {
  ComposeScene scene(cut_plane(kPlaneSide), resolution, {relief()});
  const double k = 2.0 * std::numbers::pi / 24.0;
  scene.set(0,
            [&](int, int, const Vec3& p) { return kAmountPerMm * (4.0 + std::sin(k * p.x()) * std::cos(k * p.y())); });
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  double at_seam = 0.0, inside = 0.0;
  const TileGrid& grid = scene.surface->grid();
  for (TexelIndex t = 0; t < grid.num_texels(); ++t) {
    if (!scene.surface->is_covered(t)) continue;
    const Vec3 p = scene.map->position_mm(std::int64_t{grid.y(t)} * resolution + grid.x(t));
    const Vec3 gradient(k * std::cos(k * p.x()) * std::cos(k * p.y()), -k * std::sin(k * p.x()) * std::sin(k * p.y()),
                        0.0);
    const double error = angle_deg(scene, composer, t, (Vec3(0, 0, 1) - gradient).normalized());
    const double texel = scene.surface->median_texel_size_mm();
    const double from_edge = std::min({p.x(), p.y(), kPlaneSide - p.x(), kPlaneSide - p.y()});
    if (from_edge < 1.5 * texel) continue;
    (std::abs(p.x() - kPlaneSide / 2) < texel ? at_seam : inside) =
        std::max(std::abs(p.x() - kPlaneSide / 2) < texel ? at_seam : inside, error);
  }
  return {at_seam, inside};
}

TEST(ComposedNormals, OfWavesConvergeAtSeamsAsTheyDoInside) {
  const auto [seam_coarse, inside_coarse] = wave_errors(64);
  const auto [seam_fine, inside_fine] = wave_errors(256);
  // Central differences: second order, to the rounding of heights and amounts. Across a cut texels do not line up:
  // first order.
  EXPECT_LT(inside_fine, inside_coarse / 16.0 * 1.2 + 0.5 * kRoundingDeg);
  EXPECT_LT(seam_fine, seam_coarse / 4.0 * 1.2 + 0.5 * kRoundingDeg);
  EXPECT_LT(seam_coarse, 2.0 * inside_coarse);
}

TEST(ComposedNormals, ANeighborOverASeamCountsWhereItIs) {
  const ComposeScene scene(cut_plane(kPlaneSide), 96, {relief()});
  for (const TexelIndex t : scene.surface->border()) {
    const std::array<Vec2, 4> steps = composition::neighbor_steps(scene.scene_mesh, *scene.surface, t);
    const std::array<TexelIndex, 4> around = scene.surface->neighbors(t);
    const auto position = [&](TexelIndex i) {
      return scene.map->position_mm(std::int64_t{scene.surface->grid().y(i)} * 96 + scene.surface->grid().x(i));
    };
    const Eigen::Matrix<double, 3, 2> mm = scene.surface->mm_per_texel(scene.surface->triangle(t)).cast<double>();
    for (std::size_t k = 0; k < 4; ++k) {
      if (around[k] == kNoTexel) continue;
      EXPECT_NEAR((mm * steps[k] - (position(around[k]) - position(t))).norm(), 0.0, 1e-4);  // float steps
    }
  }
}

}  // namespace
}  // namespace patinate::simulation
