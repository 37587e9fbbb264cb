#include "patinate/atlas/sheet.h"

#include <gtest/gtest.h>

#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/core/error.h"
#include "tests/support/meshes.h"

namespace patinate {
namespace {

using testing_support::udim_plane;
using testing_support::unit_plane;

TEST(Sheet, ATileAloneIsTheWholeSheet) {
  const Sheet sheet = make_sheet({""}, 100);
  EXPECT_EQ(sheet.width(), 100);
  EXPECT_EQ(sheet.height(), 100);
  EXPECT_EQ(sheet.sheet_uv(0, Vec2(0.3, 0.7)), Vec2(0.3, 0.7));
}

TEST(Sheet, TexelsOfATileKeepTheirPlaces) {
  const Sheet sheet = make_sheet({"1001", "1002", "1003"}, 32);
  EXPECT_EQ(sheet.columns, 2);
  EXPECT_EQ(sheet.width(), 2 * 36);
  for (int tile = 0; tile < 3; ++tile) {
    // The center of the tile's texel (5, 7), by the convention of texel_from_uv.
    const Vec2 uv = sheet.sheet_uv(tile, {5.5 / 32, 1.0 - 7.5 / 32});
    EXPECT_NEAR(uv.x() * sheet.width() - 0.5, sheet.first_x(tile) + 5, 1e-9);
    EXPECT_NEAR((1.0 - uv.y()) * sheet.height() - 0.5, sheet.first_y(tile) + 7, 1e-9);
  }
}

TEST(Sheet, TilesCutOutArePastedBackWithTheirBordersRepeated) {
  const Sheet sheet = make_sheet({"a", "b"}, 8);
  ImageF image(sheet.width(), sheet.height(), 2, -1.0f);
  ImageF tile(8, 8, 2);
  for (std::size_t i = 0; i < tile.values().size(); ++i) tile.values()[i] = static_cast<float>(i);
  paste_tile(image, sheet, 1, tile);
  EXPECT_EQ(cut_tile(image, sheet, 1), tile);
  EXPECT_EQ(cut_tile(image, sheet, 0), ImageF(8, 8, 2, -1.0f));
  EXPECT_EQ(image.at(sheet.first_x(1) - 2, sheet.first_y(1) - 1, 1), tile.at(0, 0, 1));
  EXPECT_EQ(image.at(sheet.first_x(1) + 9, sheet.first_y(1) + 3, 0), tile.at(7, 3, 0));
}

TEST(Sheet, RefusesMoreTexelsThanItHolds) {
  EXPECT_THROW((void)make_sheet({}, 64), InvalidInput);
  EXPECT_NO_THROW((void)make_sheet({""}, 16384));
  try {
    (void)make_sheet(std::vector<std::string>(100, "x"), 4096);
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find("at most 1634"), std::string::npos) << e.what();  // 16384 / 10 less margins
  }
}

TEST(Sheet, FilesOfTilesAreNamedAfterThem) {
  EXPECT_EQ(tile_path("out/tex.png", ""), "out/tex.png");
  EXPECT_EQ(tile_path("out/tex.png", "1002"), "out/tex.1002.png");
  EXPECT_EQ(tile_path("tex.<UDIM>.png", "1002"), "tex.1002.png");
  EXPECT_EQ(tile_path("tex_<UDIM>.exr", ""), "tex_1001.exr");
}

// Closed form: on a plane the neighbor at an offset lies at that offset, whatever tiles it is cut into.
TEST(Sheet, NeighborsAcrossTilesLieStraightOn) {
  constexpr double kSide = 48.0;
  const AtlasMesh atlas = atlas_mesh_of(udim_plane(kSide, 3), find_uv_layout(udim_plane(kSide, 3)));
  ASSERT_EQ(atlas.tiles.size(), 3u);
  const TexelMap map = make_texel_map(atlas, 32);
  EXPECT_EQ(map.num_covered(), 3 * 32 * 32);
  EXPECT_EQ(map.num_overlapping(), 0);
  const Vec2 texel(kSide / 3 / 32, kSide / 32);  // 0.5 by 1.5 mm
  std::vector<Vec2> offsets;
  for (int x = -3; x <= 3; ++x) offsets.emplace_back(x * texel.x(), 0.0);
  const FlowFrames frames = uv_frames(map);
  std::vector<TexelNeighbor> found(offsets.size());
  int num_crossing = 0;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    map.gather(t, frames, offsets, found);
    for (std::size_t k = 0; k < offsets.size(); ++k) {
      const Vec3 expected = map.position_mm(t) + Vec3(offsets[k].x(), 0, 0);
      if (expected.x() < 0.0 || expected.x() > kSide) continue;
      ASSERT_GE(found[k].texel, 0);
      EXPECT_LT((map.position_mm(found[k].texel) - expected).norm(), 1e-3);  // float barycentrics: exactly that texel
      num_crossing += map.chart(found[k].texel) != map.chart(t);
    }
  }
  EXPECT_EQ(num_crossing, 2 * 32 * 2 * (1 + 2 + 3));  // two borders of 32 rows, both ways
}

TEST(AtlasMesh, ComesBackFromTheFileItWasWrittenTo) {
  const Mesh mesh = udim_plane(10.0, 2);
  const AtlasMesh atlas = atlas_mesh_of(mesh, find_uv_layout(mesh));
  const AtlasMesh back = read_back_atlas_mesh(atlas.mesh, UvLayoutRule::Udim, {"1001", "1002"});
  EXPECT_EQ(back.triangle_tile, atlas.triangle_tile);
  EXPECT_EQ(back.mesh.uvs, atlas.mesh.uvs);
  EXPECT_THROW((void)read_back_atlas_mesh(atlas.mesh, UvLayoutRule::Udim, {"1001"}), InvalidInput);
  EXPECT_THROW((void)read_back_atlas_mesh(atlas.mesh, UvLayoutRule::Material, {"a", "b"}), InvalidInput);
}

TEST(AtlasMesh, UvsThatLeanOutAreScaledIn) {
  Mesh mesh = unit_plane(1.0);
  for (Vec2& uv : mesh.uvs) uv = uv * 1.2 - Vec2(0.1, 0.0);
  const AtlasMesh atlas = atlas_mesh_of(mesh, find_uv_layout(mesh));
  for (const Vec2& uv : atlas.mesh.uvs) {
    EXPECT_GE(uv.minCoeff(), 0.0);
    EXPECT_LE(uv.maxCoeff(), 1.0);
  }
  EXPECT_EQ(TexelMap(atlas.mesh, 64, 64).num_overlapping(), 0);
}

}  // namespace
}  // namespace patinate
