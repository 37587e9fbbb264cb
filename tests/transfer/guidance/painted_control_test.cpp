#include "transfer/guidance/painted_control.h"

#include <gtest/gtest.h>

#include <cmath>

#include "patinate/atlas/atlas_mesh.h"
#include "tests/support/meshes.h"

namespace patinate::transfer {
namespace {

constexpr int kBrushSide = 64;

TEST(SurfaceBrush, KeepsWhatTheFormulaSays) {
  const TexelMap map(testing_support::unit_plane(kBrushSide), kBrushSide, kBrushSide);
  const BrushStroke stroke{.points_mm = {{20.0, 30.0, 0.5}, {24.0, 30.0, 0.0}}, .radius_mm = 6.0, .flow = 0.4};
  std::vector<double> kept(static_cast<std::size_t>(map.num_texels()), 1.0);
  for (const BrushedTexel& b : SurfaceBrush(map).find(stroke)) kept[b.texel] = b.kept;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    double expected = 1.0;
    for (const auto& p : stroke.points_mm) {
      const double squared = (map.position_mm(t) - Vec3(p[0], p[1], p[2])).squaredNorm() / (6.0 * 6.0);
      if (squared < 1.0) expected *= 1.0 - 0.4 * (1.0 - squared) * (1.0 - squared);
    }
    ASSERT_NEAR(kept[t], expected, 1e-12) << t;
  }
}

TEST(SurfaceBrush, HeldTwiceAtAPlaceItPaintsTwiceAsLong) {
  const TexelMap map(testing_support::unit_plane(kBrushSide), kBrushSide, kBrushSide);
  const SurfaceBrush brush(map);
  const auto once = brush.find({.points_mm = {{32.5, 32.5, 0.0}}, .radius_mm = 5.0, .flow = 0.3});
  const auto twice = brush.find({.points_mm = {{32.5, 32.5, 0.0}, {32.5, 32.5, 0.0}}, .radius_mm = 5.0, .flow = 0.3});
  ASSERT_EQ(once.size(), twice.size());
  for (std::size_t i = 0; i < once.size(); ++i) EXPECT_NEAR(twice[i].kept, once[i].kept * once[i].kept, 1e-12);
}

/// A sheet that is folded back on itself: its halves lie a twentieth of a millimeter apart and face away.
Mesh folded_sheet() {
  Mesh mesh = testing_support::cut_plane(kBrushSide);
  for (Vec3& p : mesh.positions) {
    if (p.x() <= 0.5 * kBrushSide) continue;
    p = Vec3(kBrushSide - p.x(), p.y(), -0.05);
  }
  mesh.normals.clear();
  return with_normals(std::move(mesh));
}

TEST(SurfaceBrush, PaintsTheSideThatItIsHeldAt) {
  const TexelMap map(folded_sheet(), kBrushSide, kBrushSide);
  constexpr double kRadius_mm = 6.0;
  const auto texels = SurfaceBrush(map).find({.points_mm = {{12.0, 32.0, 0.0}}, .radius_mm = kRadius_mm});
  const double texel_mm = map.median_texel_size_mm(), across = kRadius_mm / texel_mm;
  // The circle's area in texels; of those on its rim, half a texel wide, it is open.
  EXPECT_NEAR(static_cast<double>(texels.size()), 3.14159265 * across * across, 3.14159265 * across);
  for (const BrushedTexel& b : texels) EXPECT_GT(map.position_mm(b.texel).z(), -0.02) << b.texel;
}

}  // namespace
}  // namespace patinate::transfer
