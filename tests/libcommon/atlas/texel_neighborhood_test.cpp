#include "libcommon/atlas/texel_neighborhood.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "patinate/atlas/direction_field.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/libcommon/atlas/up.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::kUp;
using testing_support::square_offsets;

std::shared_ptr<const FlowFrames> downward(const TexelMap& map) {
  return std::make_shared<const FlowFrames>(direction_frames(map, DirectionKind::Gravity, kUp));
}

// Expects the neighbors that gather() finds, to the texel and 1/256 pixel.
void expect_equal_to_gather(const TexelMap& map, const std::shared_ptr<const FlowFrames>& frames, double step_mm,
                            std::int64_t& num_missing) {
  std::vector<Vec2> offsets = square_offsets(2, step_mm);
  const TexelNeighborhood neighborhood(map, offsets, frames, step_mm);
  TexelNeighborhood::Cursor cursor(neighborhood);
  offsets.resize(neighborhood.size());  // And the eight texels beside.
  std::vector<TexelNeighbor> expected(offsets.size());
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    const Eigen::Matrix2d to_mm = neighborhood.pixels_per_texel(map.triangle(t)) * step_mm;
    for (int i = 0, k = static_cast<int>(neighborhood.first_adjacent()); i < 9; ++i) {
      if (i != 4) offsets[k++] = to_mm * Vec2(i % 3 - 1, i / 3 - 1);
    }
    map.gather(t, *frames, offsets, expected);
    const auto found = cursor.at(t);
    for (std::size_t k = 0; k < offsets.size(); ++k) {
      ASSERT_EQ(found[k].texel, expected[k].texel) << t << " " << k;
      num_missing += found[k].texel < 0;
      if (found[k].texel < 0) continue;
      EXPECT_NEAR(found[k].x / 256.0, expected[k].offset_mm.x() / step_mm, 0.51 / 256.0);
      EXPECT_NEAR(found[k].y / 256.0, expected[k].offset_mm.y() / step_mm, 0.51 / 256.0);
    }
  }
}

TEST(TexelNeighborhood, EqualsGatherForEveryTexelAndStoresOnlyBands) {
  const TexelMap map(testing_support::cut_plane(64.0), 128, 128);
  std::int64_t num_missing = 0;
  expect_equal_to_gather(map, downward(map), map.median_texel_size_mm(), num_missing);
  const TexelNeighborhood neighborhood(map, square_offsets(2, map.median_texel_size_mm()), downward(map), 1.0);
  EXPECT_LT(neighborhood.num_stored(), map.num_covered() / 3);
}

// In a band of r texels beside a seam a texel at distance d has (r + 1 - d) of 2 r + 1 rows of neighbors beyond it: of
// r = 2, less than a third of them all. And its row says which.
TEST(TexelNeighborhood, StoresOnlyNeighborsThatLeaveTheGridWhereTrianglesAreLarge) {
  constexpr std::int64_t kNeighbors = 24 + 8, kBytes = 8, kRowBytes = 24;
  for (const auto& [cells, is_large] : {std::pair{8, true}, std::pair{64, false}}) {
    const TexelMap map(testing_support::cut_plane(64.0, cells), 256, 256);
    std::int64_t num_missing = 0;
    expect_equal_to_gather(map, downward(map), map.median_texel_size_mm(), num_missing);
    const TexelNeighborhood neighborhood(map, square_offsets(2, map.median_texel_size_mm()), downward(map), 1.0);
    const std::int64_t all = neighborhood.num_stored() * kNeighbors * kBytes,
                       rows = neighborhood.num_stored() * kRowBytes;
    if (is_large) {
      EXPECT_LT(neighborhood.stored_bytes(), all / 2 + rows);
    } else {
      EXPECT_EQ(neighborhood.stored_bytes(), all + rows);
    }
  }
}

TEST(TexelNeighborhood, EqualsGatherOnARealAtlas) {
  PATINATE_REQUIRE_DATA(file, "meshes/marble_bust/marble_bust_01_1k.gltf");
  Mesh mesh = read_mesh(file);
  scale_mesh(mesh, 1000.0);
  const TexelMap map(mesh, 256, 256);
  std::int64_t num_missing = 0;
  expect_equal_to_gather(map, downward(map), map.median_texel_size_mm(), num_missing);
  // The bust is closed but for its base: nearly every neighbor exists.
  EXPECT_LT(static_cast<double>(num_missing), 0.02 * static_cast<double>(map.num_covered() * 24));
}

// A plane in charts that are turned, mirrored and of other sizes: where neighbors lie in the plane is known. That the
// frames agree over every seam is what makes it exact.
TEST(TexelNeighborhood, NeighborsLieWhereTheySayWhateverTheChartsDo) {
  const TexelMap map(testing_support::patchwork_plane(64.0, 4), 256, 256);
  const std::shared_ptr<const FlowFrames> frames = downward(map);
  const double step_mm = 1.5 * map.median_texel_size_mm();
  const std::vector<Vec2> offsets = square_offsets(3, step_mm);
  std::vector<TexelNeighbor> found(offsets.size());
  std::int64_t num_found = 0, num_far = 0, num_crossing = 0;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    map.gather(t, *frames, offsets, found);
    for (std::size_t k = 0; k < offsets.size(); ++k) {
      const TexelNeighbor& n = found[k];
      if (n.texel < 0) continue;
      const Vec3 step = map.position_mm(n.texel) - map.position_mm(t);
      ASSERT_LT((Vec2(step.x(), -step.y()) - n.offset_mm).norm(), 1e-3)
          << t << " " << k;  // Frames lean by up to 2e-4 to their UVs.
      // Half a texel of the chart over there, in each direction.
      const double texel_mm = map.mm_per_texel(map.triangle(n.texel)).col(0).norm();
      num_far += (n.offset_mm - offsets[k]).norm() > 0.7072 * texel_mm ? 1 : 0;
      num_crossing += map.chart(n.texel) != map.chart(t) ? 1 : 0;
      ++num_found;
    }
  }
  EXPECT_GT(num_crossing, num_found / 20);
  // Only where the nearest texel's center lies just outside the chart is the next one taken.
  EXPECT_LT(static_cast<double>(num_far), 0.15 * static_cast<double>(num_crossing));
}

/// A plane of 51.2 texels a side in an atlas of 64, with a slit of one texel upward, in column 17, and one across, in
/// row 41: 1.28 texels, of which one shows its center.
Mesh slit_plane() {
  constexpr int kCells = 40, kColumn = 8, kRow = 12;
  Mesh mesh = testing_support::unit_plane(64.0, kCells);
  for (Vec2& uv : mesh.uvs) uv = Vec2(0.1, 0.1) + 0.8 * uv;
  const Mesh whole = mesh;
  mesh.triangles.clear();
  mesh.uv_triangles.clear();
  mesh.triangle_surface.clear();
  for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
    const int column = static_cast<int>(t / 2) % kCells, row = static_cast<int>(t / 2) / kCells;
    if ((column == kColumn && row >= 18 && row < 30) || (row == kRow && column >= 15 && column < 33)) continue;
    mesh.triangles.push_back(whole.triangles[t]);
    mesh.uv_triangles.push_back(whole.uv_triangles[t]);
    mesh.triangle_surface.push_back(0);
  }
  return mesh;
}

constexpr int kSlitSide = 64;

// Nothing of the surface lies in the slit, and the straight way over it ends there: seen from both sides.
TEST(TexelNeighborhood, ASlitOfOneTexelEndsTheSurfaceFromBothSides) {
  const TexelMap map(slit_plane(), kSlitSide, kSlitSide);
  const double step = map.median_texel_size_mm();
  const std::vector<Vec2> offsets{{2.0 * step, 0.0}, {-2.0 * step, 0.0}, {0.0, 2.0 * step}, {0.0, -2.0 * step}};
  const auto neighbor = [&](int x, int y, std::size_t k) {
    std::vector<TexelNeighbor> found(offsets.size());
    map.gather(TexelId{y} * kSlitSide + x, uv_frames(map), offsets, found);
    return found[k].texel;
  };
  ASSERT_FALSE(map.is_covered(TexelId{25} * kSlitSide + 17));
  ASSERT_TRUE(map.is_covered(TexelId{25} * kSlitSide + 16) && map.is_covered(TexelId{25} * kSlitSide + 18));
  EXPECT_EQ(neighbor(16, 25, 0), -1);
  EXPECT_EQ(neighbor(18, 25, 1), -1);
  ASSERT_FALSE(map.is_covered(TexelId{41} * kSlitSide + 35));
  ASSERT_TRUE(map.is_covered(TexelId{40} * kSlitSide + 35) && map.is_covered(TexelId{42} * kSlitSide + 35));
  EXPECT_EQ(neighbor(35, 40, 2), -1);
  EXPECT_EQ(neighbor(35, 42, 3), -1);
}

// Oracle: the same chart mirrored in the atlas has the same neighbors, mirrored, whichever of the two finds them.
TEST(TexelNeighborhood, AMirroredChartHasMirroredNeighbors) {
  constexpr int kRadius = 3, kLast = kSlitSide - 1;
  const Mesh mesh = slit_plane();
  struct Mirror {
    const char* name;
    Vec2 (*uv)(const Vec2&);
    std::array<int, 2> (*offset)(int, int);  // Offset of texels; places mirror likewise, about the atlas's middle.
  };
  const std::array<Mirror, 3> mirrors{Mirror{"left and right", [](const Vec2& p) { return Vec2(1.0 - p.x(), p.y()); },
                                             [](int x, int y) {
                                               return std::array{-x, y};
                                             }},
                                      Mirror{"up and down", [](const Vec2& p) { return Vec2(p.x(), 1.0 - p.y()); },
                                             [](int x, int y) {
                                               return std::array{x, -y};
                                             }},
                                      Mirror{"rows and columns", [](const Vec2& p) { return Vec2(p.y(), p.x()); },
                                             [](int x, int y) {
                                               return std::array{-y, -x};
                                             }}};
  const TexelMap map(mesh, kSlitSide, kSlitSide);
  const double step = map.median_texel_size_mm();
  const std::vector<Vec2> offsets = square_offsets(kRadius, step);
  const auto index_of = [](int x, int y) {
    const int index = (y + kRadius) * (2 * kRadius + 1) + x + kRadius;
    return static_cast<std::size_t>(
        index > (2 * kRadius + 1) * kRadius + kRadius ? index - 1 : index);  // square_offsets() leaves the middle out.
  };
  const auto own_frames = std::make_shared<const FlowFrames>(uv_frames(map));
  const TexelNeighborhood neighborhood(map, offsets, own_frames, step);
  for (const Mirror& mirror : mirrors) {
    Mesh other_mesh = mesh;
    for (Vec2& uv : other_mesh.uvs) uv = mirror.uv(uv);
    const TexelMap other(other_mesh, kSlitSide, kSlitSide);
    const auto frames = std::make_shared<const FlowFrames>(uv_frames(other));
    const auto mirrored = [&](TexelId t) {
      if (t < 0) return t;
      const auto at =
          mirror.offset(2 * static_cast<int>(t % kSlitSide) - kLast, 2 * static_cast<int>(t / kSlitSide) - kLast);
      return TexelId{(at[1] + kLast) / 2} * kSlitSide + (at[0] + kLast) / 2;
    };
    const TexelNeighborhood other_neighborhood(other, offsets, frames, step);
    TexelNeighborhood::Cursor cursor(neighborhood), other_cursor(other_neighborhood);
    std::vector<TexelNeighbor> found(offsets.size()), other_found(offsets.size());
    int num_missing = 0, num_wrong = 0;
    for (TexelId t = 0; t < map.num_texels(); ++t) {
      ASSERT_EQ(map.is_covered(t), other.is_covered(mirrored(t))) << mirror.name << " " << t;
      if (!map.is_covered(t)) continue;
      map.gather(t, *own_frames, offsets, found);
      other.gather(mirrored(t), *frames, offsets, other_found);
      const auto fast = cursor.at(t), other_fast = other_cursor.at(mirrored(t));
      for (int y = -kRadius; y <= kRadius; ++y) {
        for (int x = -kRadius; x <= kRadius; ++x) {
          if (x == 0 && y == 0) continue;
          const auto there = mirror.offset(x, y);
          const std::size_t k = index_of(x, y), l = index_of(there[0], there[1]);
          num_missing += found[k].texel < 0;
          num_wrong += mirrored(found[k].texel) != other_found[l].texel;
          num_wrong += mirrored(fast[k].texel) != other_fast[l].texel;
        }
      }
    }
    EXPECT_EQ(num_wrong, 0) << mirror.name;
    EXPECT_GT(num_missing, 0);
  }
}

}  // namespace
}  // namespace patinate
