#include "patinate/atlas/texel_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

#include "libcommon/atlas/raster.h"
#include "libcommon/core/random.h"
#include "patinate/atlas/dilate.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::cut_plane;
using testing_support::square_offsets;
using testing_support::unit_plane;

TEST(TexelMap, PlacesTexelCentersByTheUvConvention) {
  const TexelMap map(unit_plane(64.0), 64, 64);
  EXPECT_EQ(map.num_covered(), 64 * 64);
  EXPECT_EQ(map.num_overlapping(), 0);
  EXPECT_NEAR(map.median_texel_size_mm(), 1.0, 1e-6);  // float rounding
  // Texel (x, y): u = (x + 0.5) / 64, v = 1 - (y + 0.5) / 64.
  const Vec3 p = map.position_mm(10 * 64 + 3);
  EXPECT_NEAR(p.x(), 3.5, 1e-5);
  EXPECT_NEAR(p.y(), 64.0 - 10.5, 1e-5);
  EXPECT_NEAR(map.normal(0).z(), 1.0, 1e-12);
}

// Three quarters of the surface take one quarter of the texels: 48 mm are 16 texels wide there, and 16 mm 48 beyond.
TEST(TexelMap, TexelsAreWeighedBySurface) {
  Mesh mesh = unit_plane(64.0, 4);
  for (Vec2& uv : mesh.uvs) uv.x() = uv.x() <= 0.75 ? uv.x() / 3.0 : 1.0 - 3.0 * (1.0 - uv.x());
  const TexelMap map(mesh, 64, 64);
  EXPECT_NEAR(map.share_of_larger_texels(1.0), 0.75, 1e-12);
  EXPECT_EQ(map.share_of_larger_texels(2.0), 0.0);
  EXPECT_NEAR(map.median_texel_size_mm(), std::sqrt(1.0 / 3.0),
              1e-6);  // 48 of 64 columns lie on a third of it, 1 mm high
  EXPECT_NEAR(map.median_texel_size_by_area_mm(), std::sqrt(3.0), 1e-6);
}

// Points are not stored: the truth is the rule that drew the texels, and 24 bits of it.
TEST(TexelMap, APointIsWhereItsTexelWasDrawn) {
  const TexelMap map(cut_plane(64.0), 100, 73);
  struct Drawn {
    int triangle = -1;
    float b1 = 0.0f, b2 = 0.0f;
  };
  std::vector<Drawn> drawn(static_cast<std::size_t>(map.num_texels()));
  for (int t = 0; t < map.mesh().num_triangles(); ++t) {
    std::array<Vec2, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = texel_from_uv(map.mesh().uvs[map.mesh().uv_triangles[static_cast<std::size_t>(t)][k]], 100, 73);
    for_each_texel(
        p, map.rect(),
        [&](int x, int y, double b1, double b2, double) {
          Drawn& point = drawn[TexelId{y} * 100 + x];
          if (point.triangle < 0) point = {t, static_cast<float>(b1), static_cast<float>(b2)};
        },
        [] {});
  }
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    const SurfacePoint point = map.point(t);
    const Drawn& expected = drawn[t];
    ASSERT_EQ(point.triangle, expected.triangle) << t;
    ASSERT_EQ(point.b1, static_cast<double>(expected.b1)) << t;
    ASSERT_EQ(point.b2, static_cast<double>(expected.b2)) << t;
  }
}

TEST(TexelMap, HalvedIsTheMapOfHalfTheSize) {
  const TexelMap map(cut_plane(64.0), 101, 64), half = map.halved(), expected(cut_plane(64.0), 50, 32);
  ASSERT_EQ(half.width(), 50);
  ASSERT_EQ(half.height(), 32);
  EXPECT_EQ(half.num_covered(), expected.num_covered());
  EXPECT_EQ(half.num_overlapping(), expected.num_overlapping());
  EXPECT_EQ(half.median_texel_size_mm(), expected.median_texel_size_mm());
  EXPECT_EQ(&half.mesh(), &map.mesh());
  for (TexelId t = 0; t < half.num_texels(); ++t) ASSERT_EQ(half.triangle(t), expected.triangle(t)) << t;
  EXPECT_THROW((void)TexelMap(unit_plane(1.0), 1, 8).halved(), InvalidInput);
}

// Oracle: the sizes of all texels, sorted. Charts of a patchwork differ in density.
TEST(TexelMap, MedianSizeIsThatOfTheTexelInTheMiddle) {
  for (const int n : {1, 3, 6}) {
    const TexelMap map(testing_support::patchwork_plane(40.0, n), 61, 61);
    std::vector<float> sizes;
    for (TexelId t = 0; t < map.num_texels(); ++t) {
      if (!map.is_covered(t)) continue;
      const auto step = map.mm_per_texel(map.triangle(t));
      sizes.push_back(static_cast<float>(std::sqrt(step.col(0).cross(step.col(1)).norm())));
    }
    std::sort(sizes.begin(), sizes.end());
    EXPECT_NEAR(map.median_texel_size_mm(), static_cast<double>(sizes[sizes.size() / 2]), 1e-5) << n;  // float rounding
  }
}

TEST(TexelMap, TangentsFollowTexelStepsAndKnowTheirSize) {
  const TexelMap map(unit_plane(128.0), 64, 32);  // 2 mm per texel across, 4 mm down.
  const auto j = map.mm_per_texel(0);
  EXPECT_NEAR(j(0, 0), 2.0, 1e-12);
  EXPECT_NEAR(j(1, 1), -4.0, 1e-12);
  const Eigen::Matrix2d texels = map.texels_per_mm(0, map.tangents(0));
  EXPECT_NEAR(texels(0, 0), 0.5, 1e-12);
  EXPECT_NEAR(texels(1, 1), 0.25, 1e-12);
}

TEST(TexelMap, WithoutUvsOrWithUvsOutsideIsInvalid) {
  Mesh mesh = unit_plane(1.0);
  mesh.uvs[0] = Vec2(1.7, 0.0);
  EXPECT_THROW(TexelMap(mesh, 64, 64), InvalidInput);
  mesh.uvs.clear();
  mesh.uv_triangles.clear();
  EXPECT_THROW(TexelMap(mesh, 64, 64), InvalidInput);
  EXPECT_THROW(TexelMap(unit_plane(1.0), 0, 64), InvalidInput);
}

TEST(TexelMap, LabelsCharts) {
  const TexelMap map(cut_plane(64.0), 128, 128);
  std::set<int> charts;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (map.is_covered(t)) charts.insert(map.chart(t));
  }
  EXPECT_EQ(charts.size(), 2u);
}

// On a plane, whatever its charts, the neighbor at an offset lies at that offset: closed form. The tolerance is the
// atlas's own grid: half a texel in each direction for the neighbor, plus one where the nearest covered texel is not
// the nearest one.
TEST(TexelMap, GatherCrossesASeamStraight) {
  constexpr double kSide = 64.0;
  const TexelMap map(cut_plane(kSide), 128, 128);
  const double texel_mm = map.median_texel_size_mm();
  const std::vector<Vec2> offsets = square_offsets(3, texel_mm);
  const FlowFrames frames = uv_frames(map);
  std::vector<TexelNeighbor> found(offsets.size());
  std::int64_t num_crossing = 0;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    map.gather(t, frames, offsets, found);
    const FlowFrame& frame = frames[map.triangle(t)];
    for (std::size_t k = 0; k < offsets.size(); ++k) {
      const Vec3 expected = map.position_mm(t) + frame * offsets[k];
      const bool is_on_plane = expected.x() > 0.0 && expected.y() > 0.0 && expected.x() < kSide && expected.y() < kSide;
      if (!is_on_plane) continue;
      ASSERT_GE(found[k].texel, 0) << t << " " << k;
      EXPECT_LT((map.position_mm(found[k].texel) - expected).norm(), 1.6 * texel_mm);
      num_crossing += map.chart(found[k].texel) != map.chart(t);
    }
  }
  EXPECT_GT(num_crossing, 500);
}

TEST(TexelMap, GatherEndsWhereTheSurfaceEnds) {
  const TexelMap map(unit_plane(32.0), 32, 32);
  std::vector<TexelNeighbor> found(1);
  map.gather(5, uv_frames(map), std::vector<Vec2>{{0.0, -3.0}}, found);  // Up from the top row.
  EXPECT_EQ(found[0].texel, -1);
}

TEST(TexelMap, WalkRoundACubeComesBack) {
  // Four faces of a cube's belt, 10 mm each: 40 mm straight on is where one started.
  Mesh mesh;
  mesh.surfaces.push_back({"", ""});
  const Vec3 ring[4] = {{0, 0, 0}, {10, 0, 0}, {10, 0, -10}, {0, 0, -10}};
  for (const Vec3& p : ring) {
    mesh.positions.push_back(p);
    mesh.positions.push_back(p + Vec3(0, 10, 0));
  }
  for (int i = 0; i < 4; ++i) {
    const int a = 2 * i, b = 2 * ((i + 1) % 4);
    for (const Triangle& t : {Triangle{a, b, b + 1}, Triangle{a, b + 1, a + 1}}) {
      Triangle uv{};
      for (std::size_t k = 0; k < 3; ++k) {
        const bool is_right = t[k] / 2 != i;
        uv[k] = static_cast<int>(mesh.uvs.size());
        mesh.uvs.emplace_back(0.05 + 0.24 * i + (is_right ? 0.2 : 0.0), t[k] % 2 ? 0.5 : 0.3);
      }
      mesh.triangles.push_back(t);
      mesh.uv_triangles.push_back(uv);
      mesh.triangle_surface.push_back(0);
    }
  }
  const TexelMap map(mesh, 256, 256);
  const SurfacePoint start{0, 0.3, 0.25};
  const SurfacePoint end = map.walk(start, Vec3(40, 0, 0));
  EXPECT_EQ(end.triangle, start.triangle);
  EXPECT_NEAR(end.b1, start.b1, 1e-9);
  EXPECT_NEAR(end.b2, start.b2, 1e-9);
}

TEST(Dilate, FillsFromTheNearestCoveredTexel) {
  // Oracle: brute force over all covered texels; distances are compared, since several may be as near.
  constexpr int kSize = 40;
  ImageF image(kSize, kSize);
  ImageU8 coverage(kSize, kSize);
  RandomStream random(3, 0);
  for (int i = 0; i < 25; ++i) {
    const int x = static_cast<int>(random.below(kSize)), y = static_cast<int>(random.below(kSize));
    coverage.at(x, y) = 255;
    image.at(x, y) = static_cast<float>(y * kSize + x + 1);
  }
  const ImageF before = image;
  dilate(image, coverage, -1);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      double nearest = 1e9;
      for (int j = 0; j < kSize; ++j) {
        for (int i = 0; i < kSize; ++i) {
          if (coverage.at(i, j)) nearest = std::min(nearest, std::hypot(i - x, j - y));
        }
      }
      const int from = static_cast<int>(image.at(x, y)) - 1;
      ASSERT_GE(from, 0);
      EXPECT_EQ(std::hypot(from % kSize - x, from / kSize - y), nearest);
      if (coverage.at(x, y)) {
        EXPECT_EQ(image.at(x, y), before.at(x, y));
      }
    }
  }
}

// Oracle: the map that finds all of its texels at once; asked here in another order, each a second time.
}  // namespace
}  // namespace patinate
