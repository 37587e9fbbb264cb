// Bounces about the normals of composed heights, an option.
#include <gtest/gtest.h>

#include "patinate/simulation/engine.h"
#include "tests/simulation/engine/run_iterations.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::run_iterations;

/// Drops that bounce on a plate on which steep rust grows.
Scene rough_plate(BounceNormal bounce_normal) {
  Scene scene = testing_support::plate_scene(64);
  scene.appearance[2].height_mm = 6.0;
  scene.appearance[2].height_variation = 1.0;
  scene.behavior = {.bounce = 0.8, .floating = 0.1, .absorb = 0.1};
  scene.rules.push_back(testing_support::rust_rule(2.0));
  scene.tracing.bounce_normal = bounce_normal;
  return scene;
}

TEST(BounceNormal, OfTheMeshHeightsChangeNothing) {
  Scene flat = rough_plate(BounceNormal::Mesh);
  flat.appearance[2].height_mm = 0.0;
  Simulation a(rough_plate(BounceNormal::Mesh)), b(flat);
  run_iterations(a, 60);
  run_iterations(b, 60);
  EXPECT_EQ(a.atlas().hash(), b.atlas().hash());
}

TEST(BounceNormal, OfTheComposedHeightsTurnsDropsAway) {
  Scene flat = rough_plate(BounceNormal::Composed);
  flat.appearance[2].height_mm = 0.0;
  Simulation a(rough_plate(BounceNormal::Composed)), b(flat), mesh(rough_plate(BounceNormal::Mesh));
  run_iterations(a, 60);
  run_iterations(b, 60);
  run_iterations(mesh, 60);
  EXPECT_NE(a.atlas().hash(), b.atlas().hash());
  EXPECT_EQ(b.atlas().hash(), mesh.atlas().hash()) << "without heights both normals are the mesh's";
  EXPECT_EQ(a.audit(), "");
}

TEST(BounceNormal, LookingAndGoingOnFromASnapshotChangeNothing) {
  const Scene scene = rough_plate(BounceNormal::Composed);
  Simulation whole(scene), seen(scene);
  run_iterations(whole, 50);
  for (int i = 0; i < 23; ++i) {
    seen.step();
    if (i % 3 == 0) (void)seen.compose();
  }
  Simulation resumed(scene);
  resumed.restore(seen.snapshot());
  run_iterations(resumed, 27);
  EXPECT_TRUE(resumed.snapshot() == whole.snapshot());
}

TEST(BounceNormal, WhoHoldsACopyOfThePictureIsToldOfAllThatTheEngineComposed) {
  Simulation simulation(rough_plate(BounceNormal::Composed));
  (void)simulation.compose();
  std::vector<std::uint32_t> copy(simulation.compose().codes().begin(), simulation.compose().codes().end());
  for (int look = 0; look < 5; ++look) {
    run_iterations(simulation, 7);
    const std::span<const std::uint32_t> codes = simulation.compose().codes();
    for (const TileIndex tile : simulation.composed_tiles()) {
      for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
        const std::size_t t = std::size_t{tile} * TileGrid::kTileTexels + i;
        copy[t] = codes[t];
      }
    }
    ASSERT_TRUE(std::equal(codes.begin(), codes.end(), copy.begin()));
  }
}

}  // namespace
}  // namespace patinate::simulation
