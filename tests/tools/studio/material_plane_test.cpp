#include "tools/studio/material_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "simulation/job/frame_maps.h"
#include "tests/support/meshes.h"
#include "tools/studio/mesh_glb.h"
#include "tools/studio/plant_rows.h"

namespace patinate::studio {
namespace {

/// A copper plate in two charts, in rain that carries what grows.
simulation::Scene copper_plate() {
  simulation::Scene scene;
  scene.materials = {"water", "moss"};
  scene.appearance.resize(2);
  scene.appearance[1].strength = 1.5;
  scene.resolution = 100;
  simulation::SceneObject object;
  object.name = "plate";
  object.mesh = testing_support::cut_plane(100.0);
  object.preset.metalness = 0.9;
  object.rotate_deg = Vec3(-60, 0, 0);
  scene.objects.push_back(object);
  simulation::Emitter rain;
  rain.name = "rain";
  rain.shape = simulation::EmitterShape::Sky;
  rain.gammatons = 40;
  rain.carries = {0.8, 1.5};
  scene.emitters.push_back(rain);
  scene.exchange.rates = {0.4, 0.4};
  return scene;
}

TEST(MaterialPlane, TellsMetalWaterAndPlantsAsPicturesHaveThem) {
  simulation::Simulation simulation(copper_plate());
  const ScreenLayout layout(simulation.atlas().surface());
  MaterialPlane plane(simulation, layout);
  std::vector<std::uint8_t> seen(std::size_t{layout.num_tiles()} * MaterialPlane::kTileBytes, 0);
  for (int i = 0; i < 40; ++i) {
    simulation.step();
    for (const ScreenTile tile : plane.update(simulation))
      std::memcpy(&seen[std::size_t{tile} * MaterialPlane::kTileBytes], plane.tile(tile).data(),
                  MaterialPlane::kTileBytes);
  }
  const ImageF metal = simulation::metalness_of(simulation), water = simulation.amounts(0),
               moss = simulation.amounts(1);
  const simulation::TileGrid& grid = simulation.atlas().surface().grid();
  int wet = 0, covered = 0;
  for (ScreenTile tile = 0; tile < layout.num_tiles(); ++tile) {
    const std::array<simulation::TexelIndex, 64> sources = layout.sources(tile);
    for (std::size_t i = 0; i < 64; ++i) {
      if (sources[i] == simulation::kNoTexel) continue;
      const int x = grid.x(sources[i]), y = grid.y(sources[i]);
      const std::uint8_t* codes = &seen[std::size_t{tile} * MaterialPlane::kTileBytes + 4 * i];
      constexpr double kFilm = 0.1;  // The amount of water that --film of `render` has without being told.
      EXPECT_NEAR(codes[0], 255.0 * static_cast<double>(metal.at(x, y)), 0.51);
      EXPECT_NEAR(codes[1], 255.0 * std::min(1.0, static_cast<double>(water.at(x, y)) / kFilm), 0.51);
      EXPECT_NEAR(codes[2], 255.0 * std::min(1.0, static_cast<double>(moss.at(x, y))), 0.51);
      wet += codes[1] > 0 ? 1 : 0;
      covered += codes[0] < 229 ? 1 : 0;
    }
  }
  EXPECT_GT(wet, 0);
  EXPECT_GT(covered, 0) << "what lies on metal hides it";
  EXPECT_TRUE(plane.update(simulation).empty()) << "nothing new is nothing to send";
}

TEST(MaterialPlane, WaterAddsNothingBelowAFilm) {
  simulation::Scene scene = copper_plate();
  scene.appearance[0].strength = 0.7;
  scene.appearance[0].specular = 0.5;
  scene.appearance[0].height_mm = 0.2;
  const std::vector<simulation::MaterialAppearance> below = simulation::looks_below_film(scene, scene.appearance);
  EXPECT_EQ(below[0].strength, 0.0);
  EXPECT_EQ(below[0].specular, 0.0);
  EXPECT_EQ(below[0].height_mm, 0.0);
  EXPECT_EQ(below[1].strength, scene.appearance[1].strength);
}

TEST(MaterialPlane, KnowsWhereLightDoesNotCome) {
  const auto hidden = [](double distance_mm) {
    simulation::Scene scene = copper_plate();
    scene.objects[0].rotate_deg = Vec3::Zero();
    scene.objects.push_back(scene.objects[0]);
    scene.objects.push_back(scene.objects[0]);
    scene.objects[1].name = "above";
    scene.objects[2].name = "below";
    scene.objects[1].translate_mm = Vec3(0, 0, distance_mm);
    scene.objects[2].translate_mm = Vec3(0, 0, -distance_mm);
    const simulation::Simulation simulation(scene);
    const simulation::SurfaceAtlas& surface = simulation.atlas().surface();
    const ScreenLayout layout(surface);
    MaterialPlane plane(simulation, layout);
    (void)plane.update(simulation);
    double sum = 0.0;
    int count = 0;
    for (ScreenTile tile = 0; tile < layout.num_tiles(); ++tile) {
      const std::array<simulation::TexelIndex, 64> sources = layout.sources(tile);
      for (std::size_t i = 0; i < 64; ++i) {
        if (sources[i] == simulation::kNoTexel || surface.object(surface.triangle(sources[i])) != 0) continue;
        sum += plane.tile(tile)[4 * i + 3] / 255.0;
        ++count;
      }
    }
    return sum / count;
  };
  // Of rays in cosine-weighted directions most meet a plate 10 mm away, which is far less than they reach.
  EXPECT_GT(hidden(10.0), 0.5);
  // None comes as far as 1 m.
  EXPECT_LT(hidden(1000.0), 0.01);
}

TEST(CutToTexels, KeepsPartsAndPlaces) {
  const PartedMesh plate = parted_mesh(with_normals(testing_support::cut_plane(100.0)), "plate");
  const PartedMesh fine = cut_to_texels(plate, 100);
  ASSERT_EQ(fine.parts.size(), 1u);
  EXPECT_EQ(static_cast<int>(fine.parts[0].triangles.size()), fine.mesh.num_triangles());
  EXPECT_GT(fine.mesh.num_triangles(), 10 * plate.mesh.num_triangles());
  for (const Vec3& p : fine.mesh.positions) EXPECT_NEAR(p.z(), 0.0, 1e-9);
}

TEST(PlantRows, HaveThePartTheyStandOn) {
  const PartedMesh mesh = parted_mesh(testing_support::cut_plane(100.0), "plate");
  const std::string rows = plant_rows(mesh);
  ASSERT_EQ(rows.size() % (kPlantRow * sizeof(float)), 0u);
  ASSERT_GT(rows.size(), 0u);
  std::array<float, kPlantRow> row{};
  std::memcpy(row.data(), rows.data(), sizeof(row));
  EXPECT_EQ(row[0], 0.0f);
  EXPECT_LE(std::abs(row[2]), 50.0f);  // x of its root, mm.
  EXPECT_NEAR(std::hypot(row[5], row[6], row[7]), 1.0, 1e-5);
  EXPECT_GE(row[12], 0.18f);  // The least amount that plants need.
}

}  // namespace
}  // namespace patinate::studio
