#include "patinate/simulation/material_atlas.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <set>

#include "libcommon/core/parallel.h"
#include "tests/support/errors.h"
#include "tests/support/meshes.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;

Scene scene_of(std::vector<Mesh> meshes, int resolution) {
  Scene scene;
  scene.materials = {"water", "metal"};
  scene.appearance.resize(2);
  scene.resolution = resolution;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    SceneObject object;
    object.name = "part" + std::to_string(i);
    object.mesh = std::move(meshes[i]);
    object.preset.amounts[1] = 1.0;
    scene.objects.push_back(std::move(object));
  }
  Emitter rain;
  rain.name = "rain";
  scene.emitters.push_back(rain);
  return scene;
}

TEST(TileGrid, IndexIsABijectionOntoWholePages) {
  const TileGrid grid{.width = 100, .height = 70};
  std::set<TexelIndex> seen;
  for (int y = 0; y < 70; ++y) {
    for (int x = 0; x < 100; ++x) {
      const TexelIndex t = grid.index(x, y);
      EXPECT_LT(t, grid.num_texels());
      EXPECT_EQ(grid.x(t), x);
      EXPECT_EQ(grid.y(t), y);
      seen.insert(t);
    }
  }
  EXPECT_EQ(seen.size(), 7000u);
  EXPECT_EQ(TileGrid::tile_of(grid.index(8, 0)), TileGrid::tile_of(grid.index(15, 7)));
}

/// Covered texels by object.
std::vector<std::int64_t> texels_of(const Scene& scene) {
  const SurfaceAtlas atlas(make_scene_mesh(scene), scene.resolution);
  std::vector<std::int64_t> covered(scene.objects.size());
  for (TexelIndex t = 0; t < atlas.grid().num_texels(); ++t) {
    if (atlas.is_covered(t)) ++covered[atlas.object(atlas.triangle(t))];
  }
  return covered;
}

// A fitting of 50 mm on a chest of 400 mm: as dense as it asks for, whatever the chest's surface; the chest has what is
// left of the atlas.
TEST(SceneMesh, AnObjectGetsTheTexelsAMmThatItAsksFor) {
  Scene scene = scene_of({testing_support::unit_plane(400), testing_support::unit_plane(50)}, 512);
  scene.objects[1].texels_per_mm = 3.0;
  const std::vector<std::int64_t> covered = texels_of(scene);
  EXPECT_EQ(covered[1], 150 * 150);
  // Beside one another: 512 - 150 - the gutter.
  EXPECT_EQ(covered[0], 358 * 358);
  scene.objects[1].scale = 2.0;  // Scale as it stands.
  EXPECT_EQ(texels_of(scene)[1], 300 * 300);
  Scene alone = scene_of({testing_support::unit_plane(100)}, 256);
  alone.objects[0].texels_per_mm = 1.0;
  EXPECT_EQ(texels_of(alone)[0], 100 * 100);
}

TEST(SceneMesh, RefusesDensitiesThatDoNotFit) {
  Scene scene = scene_of({testing_support::unit_plane(100), testing_support::unit_plane(100)}, 256);
  scene.objects[0].texels_per_mm = 3.0;
  EXPECT_TRUE(has(error_of([&] { (void)make_scene_mesh(scene); }),
                  "object 'part0' needs an atlas of 300 texels for its 3 a mm; there are 256"));
  scene.objects[0].texels_per_mm = 2.0;
  scene.objects[1].texels_per_mm = 2.0;
  EXPECT_TRUE(
      has(error_of([&] { (void)make_scene_mesh(scene); }), "raise its resolution or lower their texels_per_mm"));
}

TEST(SceneMesh, ObjectsShareTheAtlasInProportionToTheirSurfaces) {
  const Scene scene = scene_of({testing_support::unit_plane(200), testing_support::unit_plane(100)}, 256);
  const SurfaceAtlas atlas(make_scene_mesh(scene), 256);
  std::array<std::int64_t, 2> covered{};
  std::array<std::int64_t, 2> weight{};
  for (TexelIndex t = 0; t < atlas.grid().num_texels(); ++t) {
    if (!atlas.is_covered(t)) continue;
    ++covered[atlas.object(atlas.triangle(t))];
    weight[atlas.object(atlas.triangle(t))] += atlas.weight(t);
  }
  // Sides are whole texels and one row is kept free, so the densities differ by a few percent; weights make up for it.
  EXPECT_NEAR(static_cast<double>(covered[0]) / static_cast<double>(covered[1]), 4.0, 0.2);
  EXPECT_NEAR(static_cast<double>(weight[0]) / static_cast<double>(weight[1]), 4.0, 0.02);
}

TEST(SceneMesh, NamesTheObjectThatHasNoUvsOrOverlappingOnes) {
  Mesh bare = testing_support::unit_plane(10);
  bare.uvs.clear();
  bare.uv_triangles.clear();
  const Scene without = scene_of({testing_support::unit_plane(10), bare}, 64);
  EXPECT_TRUE(has(error_of([&] { (void)make_scene_mesh(without); }), "object 'part1' has no UVs"));

  Mesh twice = testing_support::unit_plane(10);
  const std::size_t n = twice.triangles.size();
  for (std::size_t i = 0; i < n; ++i) {
    twice.triangles.push_back(twice.triangles[i]);
    twice.uv_triangles.push_back(twice.uv_triangles[i]);
  }
  twice.triangle_surface.assign(twice.triangles.size(), 0);
  const Scene doubled = scene_of({testing_support::unit_plane(10), twice}, 64);
  EXPECT_TRUE(
      has(error_of([&] { (void)SurfaceAtlas(make_scene_mesh(doubled), 64); }), "the UVs of object 'part1' overlap"));
}

TEST(SurfaceAtlas, NeighborsOfASeamAreAcrossIt) {
  // The right half's chart is turned by 90 degrees: its texels are reached over the cut by walking on the surface.
  const Scene scene = scene_of({testing_support::cut_plane(100)}, 128);
  const SceneMesh mesh = make_scene_mesh(scene);
  const SurfaceAtlas atlas(mesh, 128);
  const TexelMap map(mesh.mesh, 128, 128);
  int num_across = 0;
  for (TexelIndex t = 0; t < atlas.grid().num_texels(); ++t) {
    if (!atlas.is_covered(t)) continue;
    const auto id_of = [&](TexelIndex i) { return std::int64_t{atlas.grid().y(i)} * 128 + atlas.grid().x(i); };
    for (const TexelIndex n : atlas.neighbors(t)) {
      if (n == kNoTexel) continue;
      const double gap = (map.position_mm(id_of(n)) - map.position_mm(id_of(t))).norm();
      EXPECT_LT(gap, 2.0 * atlas.median_texel_size_mm());  // one step, and half a texel on both sides of a cut
      if (map.chart(id_of(n)) != map.chart(id_of(t))) ++num_across;
    }
  }
  EXPECT_GT(num_across, 100);
}

TEST(SurfaceAtlas, EveryPointHasATexelAtMostADiagonalAway) {
  const Scene scene = scene_of({testing_support::cut_plane(100)}, 64);
  const SceneMesh mesh = make_scene_mesh(scene);
  const SurfaceAtlas atlas(mesh, 64);
  const TexelMap map(mesh.mesh, 64, 64);
  for (int t = 0; t < mesh.mesh.num_triangles(); ++t) {
    for (const auto& [b1, b2] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, {0.3, 0.3}}) {
      const TexelIndex texel = atlas.texel_of(t, b1, b2);
      ASSERT_NE(texel, kNoTexel);
      const Triangle& c = mesh.mesh.triangles[t];
      const auto p = [&](std::size_t k) { return mesh.mesh.positions[c[k]]; };
      const Vec3 point = (1 - b1 - b2) * p(0) + b1 * p(1) + b2 * p(2);
      const Vec3 center = map.position_mm(std::int64_t{atlas.grid().y(texel)} * 64 + atlas.grid().x(texel));
      EXPECT_LT((point - center).norm(), 1.5 * atlas.median_texel_size_mm());
    }
  }
}

TEST(SurfaceAtlas, WeightsAreTheAreasThatGoToTexels) {
  // 25 charts in 25 directions. Each place of a fine net goes to the texel that texel_of() names, as it does for
  // gammatons.
  const Scene scene = scene_of({testing_support::quilt_plane(100, 5)}, 128);
  const SceneMesh mesh = make_scene_mesh(scene);
  const SurfaceAtlas atlas(mesh, 128);
  const double unit = atlas.median_texel_size_mm() * atlas.median_texel_size_mm() / SurfaceAtlas::kMedianWeight;
  std::vector<double> area(atlas.grid().num_texels(), 0.0);
  constexpr int kNet = 1000;  // a triangle's side; each texel has some 1,500 points
  for (int t = 0; t < mesh.mesh.num_triangles(); ++t) {
    for (int i = 0; i < kNet; ++i) {
      for (int j = 0; j < kNet - i; ++j)
        area[atlas.texel_of(t, (i + 1.0 / 3) / kNet, (j + 1.0 / 3) / kNet)] += 200.0 / (0.5 * kNet * (kNet + 1));
    }
  }
  double sum = 0.0, error = 0.0, naive = 0.0;
  for (TexelIndex t = 0; t < area.size(); ++t) {
    if (!atlas.is_covered(t)) continue;
    sum += atlas.weight(t) * unit;
    const double texels = area[t] / (unit * SurfaceAtlas::kMedianWeight);
    error = std::max(error, std::abs(atlas.weight(t) / double{SurfaceAtlas::kMedianWeight} - texels));
    naive = std::max(
        naive, std::abs(atlas.weight_of_triangle(atlas.triangle(t)) / double{SurfaceAtlas::kMedianWeight} - texels));
  }
  EXPECT_NEAR(sum, 100.0 * 100.0, 100.0 * 100.0 * 1e-4);  // weights are rounded to 1/256, either way
  EXPECT_LT(error, 0.04);  // a cell without a texel of its own is dealt out by 16 x 16 samples, in two or three parts
  EXPECT_GT(naive, 0.5);
}

TEST(MaterialAtlas, APageThatIsNotThereHoldsTheOriginals) {
  const Scene scene = scene_of({testing_support::unit_plane(100)}, 128);
  const SceneMesh mesh = make_scene_mesh(scene);
  const SurfaceAtlas surface(mesh, 128);
  MaterialAtlas atlas(surface, 2, {{0, static_cast<std::uint16_t>(kAmountOne)}});
  EXPECT_EQ(atlas.memory(), 0u);
  const std::string before = atlas.hash();
  const std::int64_t metal = atlas.mass(1);
  EXPECT_EQ(metal, std::int64_t{128 * 128} * SurfaceAtlas::kMedianWeight * kAmountOne);
  const TexelIndex t = surface.grid().index(70, 3);
  const std::span<std::uint16_t> tile = atlas.writable_tile(1, TileGrid::tile_of(t));
  EXPECT_EQ(atlas.memory(), 8192u);
  EXPECT_EQ(atlas.hash(), before) << "making a page changes nothing";
  tile[t % 64] -= 100;
  EXPECT_EQ(atlas.amount(1, t), kAmountOne - 100);
  EXPECT_EQ(atlas.mass(1), metal - 100 * SurfaceAtlas::kMedianWeight);
  EXPECT_NE(atlas.hash(), before);
}

TEST(MaterialAtlas, PagesMayBeMadeByManyThreads) {
  const Scene scene = scene_of({testing_support::unit_plane(100)}, 512);
  const SceneMesh mesh = make_scene_mesh(scene);
  const SurfaceAtlas surface(mesh, 512);
  MaterialAtlas atlas(surface, 2, {{7, 9}});
  RunControl control;
  control.num_threads = 8;
  parallel_for(surface.grid().num_tiles(), 1, control, [&](std::int64_t begin, std::int64_t) {
    atlas.writable_tile(0, static_cast<TileIndex>(begin))[5] += 1;
  });
  EXPECT_EQ(atlas.mass(0), (std::int64_t{512 * 512} * 7 + surface.grid().num_tiles()) * SurfaceAtlas::kMedianWeight);
}

TEST(CheckScene, NamesWhatIsOutOfRange) {
  const Scene good = scene_of({testing_support::unit_plane(10)}, 64);
  check_scene(good);
  const auto says = [&](auto&& change, const std::string& part) {
    Scene scene = good;
    change(scene);
    EXPECT_TRUE(has(error_of([&] { check_scene(scene); }), part)) << error_of([&] { check_scene(scene); });
  };
  says([](Scene& s) { s.emitters.clear(); }, "no emitters");
  says([](Scene& s) { s.materials.resize(9, "x"); }, "9 materials");
  says([](Scene& s) { s.exchange.ratio = std::nan(""); }, "exchange ratio");
  says([](Scene& s) { s.exchange.rates[0] = 1.5; }, "exchange rate");
  says([](Scene& s) { s.emitters[0].speed_mm_s = 0; }, "speed (mm/s) of emitter 'rain'");
  says([](Scene& s) { s.behavior.bounce = 0.9; }, "bounce + float + absorb is 1.7");
  says([](Scene& s) { s.objects[0].scale = -1; }, "scale of object 'part0'");
}

TEST(BehaviorOfSlider, FollowsFigure10) {
  EXPECT_EQ(behavior_of_slider(0.0).floating, 0.0);
  EXPECT_EQ(behavior_of_slider(0.0).deceleration_bounce, 0.0);
  EXPECT_NEAR(behavior_of_slider(0.5, 0.0).bounce, 0.5, 1e-12);
  EXPECT_NEAR(behavior_of_slider(0.5, 0.0).floating, 0.5, 1e-12);
  // Whatever still bounces leaves the surface.
  for (double s = 0.0; s < 0.66; s += 0.01) EXPECT_LT(behavior_of_slider(s).deceleration_bounce, 0.95) << s;
  EXPECT_EQ(behavior_of_slider(1.0).bounce, 0.0);
  EXPECT_EQ(behavior_of_slider(1.0).deceleration_float, 1.0);
  for (double s = 0.0; s <= 1.0; s += 0.05) {
    const Behavior b = behavior_of_slider(s, 0.1);
    EXPECT_NEAR(b.bounce + b.floating + b.absorb, 1.0, 1e-12);
  }
}

}  // namespace
}  // namespace patinate::simulation
