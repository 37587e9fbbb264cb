// Layers with cracks from a map at the start.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "patinate/core/error.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/layer_atlas.h"
#include "tests/simulation/engine/run_iterations.h"
#include "tests/support/errors.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::run_iterations;

constexpr int kResolution = 128;
constexpr int kCoat = 1;

/// A plate under paint with the map of cracks `image`. Stress rises to 0.9 in 100 iterations, so that no crack begins.
Scene cracked_plate(const ImageF& image) {
  Scene scene = testing_support::plate_scene(kResolution);
  scene.emitters[0].is_on = false;
  scene.emitters[0].gammatons = 1;
  scene.time_per_iteration = 0.01;
  SceneObject& plate = scene.objects[0];
  plate.layers = {{.name = "steel", .look = plate.preset},
                  {.name = "paint", .thickness_um = "400", .cracks = LayerCracks{.relief = 10.0}}};
  plate.preset.amounts = {};
  if (!image.empty()) {
    scene.maps.emplace_back() = {.name = "lines",
                                 .kind = "image",
                                 .options = {},
                                 .noise = {},
                                 .wood_grain = {},
                                 .images = {image},
                                 .is_inside = {}};
    plate.layers[kCoat].cracks->initial = "lines";
  }
  Rule drying{.name = "drying", .driver = "1", .rate = 0.9, .layer = "paint"};
  drying.layer_products.stress = 1.0;
  scene.rules = {drying};
  return scene;
}

ImageF black() { return {kResolution, kResolution}; }

/// Lines of a width along both axes, at multiples of `step` texels, the plate's border left out.
ImageF grid_of_lines(int step, int width) {
  ImageF image = black();
  for (int y = 0; y < kResolution; ++y) {
    for (int x = 0; x < kResolution; ++x) {
      const auto is_on = [&](int v) {
        const int nearest = (v + step / 2) / step * step;
        return nearest > 0 && nearest < kResolution && std::abs(v - nearest) <= width / 2;
      };
      if (is_on(x) || is_on(y)) image.at(x, y) = 1.0F;
    }
  }
  return image;
}

ImageF crack_map(const Simulation& simulation) {
  const std::vector<std::string> names = simulation.layer_map_names();
  return simulation.layer_map(
      static_cast<std::size_t>(std::find(names.begin(), names.end(), "layer1.crack") - names.begin()));
}

/// Areas of the cells between cracks, texels, that texels beside each other join.
std::vector<int> areas_between(const ImageF& cracks) {
  ImageU8 is_open(cracks.width(), cracks.height(), 1, 1);
  for (std::int64_t i = 0; i < cracks.num_pixels(); ++i) is_open.data()[i] = cracks.data()[i] > 0.0F ? 0 : 1;
  std::vector<int> areas;
  for (int y = 0; y < is_open.height(); ++y) {
    for (int x = 0; x < is_open.width(); ++x) {
      if (is_open.at(x, y) == 0) continue;
      std::vector<std::array<int, 2>> cell{{x, y}};
      is_open.at(x, y) = 0;
      for (std::size_t k = 0; k < cell.size(); ++k) {
        const auto [px, py] = cell[k];
        for (const auto& [nx, ny] : {std::array{px + 1, py}, {px - 1, py}, {px, py + 1}, {px, py - 1}}) {
          if (!is_open.contains(nx, ny) || is_open.at(nx, ny) == 0) continue;
          is_open.at(nx, ny) = 0;
          cell.push_back({nx, ny});
        }
      }
      areas.push_back(static_cast<int>(cell.size()));
    }
  }
  std::sort(areas.begin(), areas.end());
  return areas;
}

TEST(InitialCracks, OfAGridAreExactlyItsCellsHoweverWideItsLinesAre) {
  // Three lines each way: 16 cells. Lines are one texel wide whatever they were, so that cells have 31 x 31 to 32 x 32
  // texels.
  for (const int width : {1, 3, 7}) {
    const Simulation simulation(cracked_plate(grid_of_lines(32, width)));
    const std::vector<int> cells = areas_between(crack_map(simulation));
    ASSERT_EQ(cells.size(), 16U) << width;
    EXPECT_GE(cells.front(), 30 * 30) << width;
    EXPECT_LE(cells.back(), 33 * 33) << width;
    EXPECT_TRUE(simulation.layers()->tips().empty()) << width;  // All lines end at the plate's border.
  }
}

TEST(InitialCracks, AreKnownToCutOffWhatTheyEnclose) {
  // One cell loses its adhesion over more than half of its area by a rule, falls, and leaves the others.
  ImageF corner = black();
  for (int y = 64; y < 96; ++y) {
    for (int x = 32; x < 52; ++x) corner.at(x, y) = 1.0F;
  }
  Scene scene = cracked_plate(grid_of_lines(32, 3));
  SceneMap map = scene.maps.front();
  map.name = "corner";
  map.images = {corner};
  scene.maps.push_back(map);
  Rule loosening{.name = "loosening", .driver = "corner", .rate = 10.0, .layer = "paint"};
  loosening.layer_reactants.adhesion = 1.0;
  scene.rules.push_back(loosening);
  Simulation simulation(scene);
  run_iterations(simulation, 40);
  EXPECT_EQ(simulation.audit(), "");
  int bare = 0;
  const TileGrid& grid = simulation.atlas().surface().grid();
  for (int y = 0; y < kResolution; ++y) {
    for (int x = 0; x < kResolution; ++x) {
      const bool is_bare = simulation.layers()->tops()[grid.index(x, y)] == 0;
      bare += is_bare ? 1 : 0;
      const bool is_inside = x >= 30 && x <= 66 && y >= 62 && y <= 98;
      EXPECT_TRUE(!is_bare || is_inside) << x << ' ' << y;
    }
  }
  EXPECT_GE(bare, 30 * 30);
}

TEST(InitialCracks, OfABlackMapAreNone) {
  Simulation without(cracked_plate({})), black_map(cracked_plate(black()));
  run_iterations(without, 50);
  run_iterations(black_map, 50);
  EXPECT_TRUE(without.snapshot() == black_map.snapshot());
}

/// A line of 5 texels' width from (40, 64) to (88, 64).
ImageF short_line() {
  ImageF image = black();
  for (int y = 62; y <= 66; ++y) {
    for (int x = 40; x <= 88; ++x) image.at(x, y) = 1.0F;
  }
  return image;
}

TEST(InitialCracks, GoOnFromTheirEndsInTheirDirection) {
  Simulation simulation(cracked_plate(short_line()));
  const std::vector<CrackTip> tips = simulation.layers()->tips();
  ASSERT_EQ(tips.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(static_cast<double>(tips[k].way[0]), k == 0 ? -1.0 : 1.0, 0.05);
    EXPECT_NEAR(static_cast<double>(tips[k].place[1]), 64.5, 1.0);
  }
  EXPECT_EQ(areas_between(crack_map(simulation)).size(), 1U);
  run_iterations(simulation, 100);
  EXPECT_EQ(areas_between(crack_map(simulation)).size(), 2U);  // From one side of the plate to the other.
}

TEST(InitialCracks, AreOnlyWhereTheMapIsAtLeastAHalfAndTheLayerIs) {
  ImageF faint = short_line();
  for (float& v : faint.values()) v *= 0.4F;
  const ImageF none = crack_map(Simulation(cracked_plate(faint)));
  EXPECT_EQ(*std::max_element(none.values().begin(), none.values().end()), 0.0F);
  Scene scaled = cracked_plate(faint);
  scaled.objects[0].layers[kCoat].cracks->initial = "2 * lines";
  const ImageF some = crack_map(Simulation(scaled));
  EXPECT_EQ(*std::max_element(some.values().begin(), some.values().end()), 1.0F);
  scaled.objects[0].layers[kCoat].thickness_um = "0";
  const ImageF gone = crack_map(Simulation(scaled));
  EXPECT_EQ(*std::max_element(gone.values().begin(), gone.values().end()), 0.0F);
}

TEST(InitialCracks, HaveTheSameBitsForAnyNumberOfThreadsAndAfterASnapshot) {
  Simulation one(cracked_plate(short_line())), three(cracked_plate(short_line())), second(cracked_plate(black()));
  run_iterations(one, 30, 1);
  run_iterations(three, 30, 3);
  EXPECT_TRUE(one.snapshot() == three.snapshot());
  second.restore(one.snapshot());
  run_iterations(one, 30);
  run_iterations(second, 30);
  EXPECT_TRUE(one.snapshot() == second.snapshot());
}

TEST(InitialCracks, FromAPictureThatIsNotSquareAreRefusedInOneLine) {
  const std::string found = testing_support::error_of([] { Simulation simulation(cracked_plate(ImageF(64, 32))); });
  EXPECT_TRUE(testing_support::has(found,
                                   "cracks/initial of layer 'paint' of object 'plate': the picture of 'lines' is "
                                   "64 x 32 pixels; a map of cracks is square"))
      << found;
  EXPECT_FALSE(testing_support::has(found, "\n")) << found;
}

}  // namespace
}  // namespace patinate::simulation
