// Layers that crack, and what cracks cut off.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "analysis/cracks/line_structure.h"
#include "patinate/core/error.h"
#include "patinate/datasets/crackle.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/layer_atlas.h"
#include "tests/simulation/engine/run_iterations.h"
#include "tests/support/errors.h"
#include "tests/support/meshes.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::run_iterations;

constexpr int kFilm = 1;
constexpr int kDrying = 256;
constexpr double kSideMm = 100.0;

Rule drying(double stress) {
  Rule rule{.name = "drying", .driver = "1", .rate = 1.0, .layer = "paint"};
  rule.layer_products.stress = stress;
  return rule;
}

/// A plate under paint whose stress rises evenly to `stress` in kDrying. It does not rain.
Scene drying_plate(int resolution, double length_mm, double stress = 2.0) {
  Scene scene = testing_support::plate_scene(resolution);
  scene.emitters[0].is_on = false;
  scene.emitters[0].gammatons = 1;
  scene.time_per_iteration = 1.0 / kDrying;
  SceneObject& plate = scene.objects[0];
  constexpr double kRelief = 10.0, kUmPerMm = 1000.0;
  plate.layers = {{.name = "steel", .look = plate.preset},
                  {.name = "paint",
                   .thickness_um = std::to_string(length_mm / kRelief * kUmPerMm),
                   .cracks = LayerCracks{.relief = kRelief}}};
  plate.preset.amounts = {};
  scene.rules = {drying(stress)};
  return scene;
}

/// Lost adhesion creeps in from edges and cracks, at different speeds.
Scene peeling_plate() {
  Scene scene = drying_plate(160, 3.0);
  Rule creep{.name = "creep", .driver = "edge * (0.3 + crack + stress)", .rate = 2.0, .layer = "paint"};
  creep.layer_reactants.adhesion = 1.0;
  Rule corrosion{.name = "corrosion", .driver = "below.metal * min(1, edge)", .rate = 1.0, .layer = "paint"};
  corrosion.layer_products.at_interface[2] = 1.0;
  scene.rules.insert(scene.rules.end(), {creep, corrosion});
  return scene;
}

ImageF map_of(const Simulation& simulation, const std::string& name) {
  const std::vector<std::string> names = simulation.layer_map_names();
  return simulation.layer_map(static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin()));
}

ImageU8 cracks_of(const Simulation& simulation) {
  const ImageF values = map_of(simulation, "layer1.crack");
  ImageU8 cracks(values.width(), values.height());
  for (std::int64_t i = 0; i < values.num_pixels(); ++i) cracks.data()[i] = values.data()[i] > 0.0F ? 255 : 0;
  return cracks;
}

/// Areas of what cracks cut the plate into, texels; those of less than 16 left out.
std::vector<int> cells_of(const ImageU8& cracks) {
  constexpr int kLeast = 16;
  ImageU8 free = cracks;
  for (std::uint8_t& v : free.values()) v = v == 0 ? 1 : 0;
  std::vector<int> areas;
  for (int y = 0; y < free.height(); ++y) {
    for (int x = 0; x < free.width(); ++x) {
      if (free.at(x, y) == 0) continue;
      std::vector<std::array<int, 2>> open{{x, y}};
      free.at(x, y) = 0;
      int area = 0;
      while (!open.empty()) {
        const auto [px, py] = open.back();
        open.pop_back();
        ++area;
        for (const auto& [nx, ny] : {std::array{px + 1, py}, {px - 1, py}, {px, py + 1}, {px, py - 1}}) {
          if (nx < 0 || ny < 0 || nx >= free.width() || ny >= free.height() || free.at(nx, ny) == 0) continue;
          free.at(nx, ny) = 0;
          open.push_back({nx, ny});
        }
      }
      if (area >= kLeast) areas.push_back(area);
    }
  }
  return areas;
}

/// Diameter of a circle that is as large as a cell in the mean.
double cell_mm(const Simulation& simulation) {
  const auto num_cells = static_cast<double>(cells_of(cracks_of(simulation)).size());
  return kSideMm * std::sqrt(4.0 / (std::acos(-1.0) * num_cells));
}

TEST(LayerCracks, LieAsFarApartAsThicknessAndStressSay) {
  // A decade of thickness; texels of a sixth of the thinnest layer's relief length.
  constexpr double kStress = 2.0;
  const double spacing = std::acosh(kStress / (kStress - 1.0)) / std::log(2.0);  // In relief lengths: 1.9.
  for (const double length_mm : {1.2, 3.8, 12.0}) {
    Simulation simulation(drying_plate(512, length_mm, kStress));
    run_iterations(simulation, kDrying);
    EXPECT_NEAR(cell_mm(simulation) / length_mm, spacing, 0.1 * spacing) << length_mm << " mm";
  }
}

/// Mean distance between cracks along rows (dx = 1) or columns of the plate.
double spacing_mm(const ImageU8& cracks, int dx) {
  int num = 0;
  for (int y = 1; y < cracks.height(); ++y) {
    for (int x = 1; x < cracks.width(); ++x)
      num += cracks.at(x, y) != 0 && cracks.at(x - dx, y - (1 - dx)) == 0 ? 1 : 0;
  }
  return kSideMm * cracks.width() / num;
}

TEST(LayerCracks, LieAlongEachAxisAsFarApartAsItsTensionSays) {
  // Stress 3 across the plate's x axis, and 1.5 along it, as boards have it. Cracks of one direction that wander count
  // for the other, too, and for both by the same share: what the law says is how the two compare, and the cells' area.
  constexpr double kStress = 3.0, kRatio = 0.5, kLengthMm = 2.4;
  const auto mean_mm = [&](double s) { return kLengthMm * std::acosh(s / (s - 1.0)) / std::log(2.0); };
  Scene scene = drying_plate(512, kLengthMm, kStress);
  scene.objects[0].layers[kFilm].cracks->tension = CrackTension{.along = Vec3::UnitX(), .ratio = kRatio};
  Simulation simulation(scene);
  run_iterations(simulation, kDrying);
  const ImageU8 cracks = cracks_of(simulation);
  const double across = mean_mm(kStress), along = mean_mm(kStress * kRatio);
  EXPECT_NEAR(spacing_mm(cracks, 1) / spacing_mm(cracks, 0), along / across, 0.1 * along / across);
  EXPECT_NEAR(cell_mm(simulation), std::sqrt(across * along), 0.1 * std::sqrt(across * along));
}

TEST(LayerCracks, RunAcrossWhereTensionAlongIsLarger) {
  // Stress 0.9 alone never exceeds the strength; along it is 1.8.
  Scene scene = drying_plate(256, 4.0, 0.9);
  scene.objects[0].layers[kFilm].cracks->tension = CrackTension{.along = Vec3::UnitX(), .ratio = 2.0};
  Simulation simulation(scene);
  run_iterations(simulation, kDrying);
  const ImageU8 cracks = cracks_of(simulation);
  EXPECT_GT(spacing_mm(cracks, 0), 4.0 * spacing_mm(cracks, 1));
}

TEST(LayerCracks, HaveTensionAlongBoardsWhereverTheyStand) {
  // The plate as one board in 36 charts that are turned by angles of their own; its longest side is the first, x.
  Scene scene = drying_plate(256, 4.0);
  scene.objects[0].mesh = testing_support::quilt_plane(kSideMm, 6);
  scene.objects[0].rotate_deg = Vec3(-60.0, 0.0, 30.0);
  scene.objects[0].layers[kFilm].cracks->tension = CrackTension{.along = {}, .ratio = 0.5};
  const Simulation simulation(scene);
  const SurfaceAtlas& surface = simulation.atlas().surface();
  const Vec3 along(std::sqrt(0.75), 0.5, 0.0);
  const auto& axes = simulation.layers()->tension_axes(kFilm);
  ASSERT_EQ(static_cast<int>(axes.size()), surface.num_triangles());
  for (int t = 0; t < surface.num_triangles(); ++t) {
    const Eigen::Matrix<double, 3, 2> steps = surface.mm_per_texel(t).cast<double>();
    const Vec3 row = steps.col(0).normalized(), column = (steps.col(1) - steps.col(1).dot(row) * row).normalized();
    constexpr double kFloat = 1e-5;
    EXPECT_LT((double{axes[t][0]} * row + double{axes[t][1]} * column - along).norm(), kFloat) << t;
  }
}

TEST(LayerCracks, CloseAsManyCellsAsSyntheticCrackle) {
  const datasets::CrackleOptions options{.width = 512, .height = 512};
  const datasets::CrackleDataset data = datasets::crackle(options);
  ImageU8 truth(options.width, options.height);
  for (std::int64_t i = 0; i < truth.num_pixels(); ++i) truth.data()[i] = data.opening_s.data()[i] < 0.0F ? 0 : 255;
  Simulation simulation(drying_plate(512, 4.0));
  run_iterations(simulation, kDrying);
  const double own = analysis::measure_structure(cracks_of(simulation), {}, {}).closed_share();
  EXPECT_GE(own, 0.9 * analysis::measure_structure(truth, {}, {}).closed_share());
}

TEST(LayerCracks, NeverBeginBelowTheStrength) {
  Simulation simulation(drying_plate(128, 4.0, 0.95));
  run_iterations(simulation, kDrying);
  EXPECT_EQ(cells_of(cracks_of(simulation)).size(), 1U);
  Scene strong = drying_plate(128, 4.0, 2.0);
  strong.objects[0].layers[kFilm].cracks->strength = "2.5";
  Simulation other(strong);
  run_iterations(other, kDrying);
  EXPECT_EQ(cells_of(cracks_of(other)).size(), 1U);
}

TEST(LayerCracks, GoOverSeams) {
  // The same plate in one chart, and in 36 that are turned by angles of their own: as many cells.
  Scene quilt = drying_plate(512, 6.0);
  quilt.objects[0].mesh = testing_support::quilt_plane(kSideMm, 6);
  Simulation whole(drying_plate(512, 6.0)), sewn(quilt);
  run_iterations(whole, kDrying);
  run_iterations(sewn, kDrying);
  // Length of cracks, in texels that are as many in the whole plate as the charts have.
  const auto share = [](const Simulation& simulation) {
    const SurfaceAtlas& surface = simulation.atlas().surface();
    double cracked = 0.0;
    for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t)
      cracked += surface.is_covered(t) && simulation.layers()->cracked()[t] != 0 ? 1.0 : 0.0;
    return cracked / static_cast<double>(surface.num_covered()) / simulation.texel_size_mm();
  };
  EXPECT_NEAR(share(sewn), share(whole), 0.1 * share(whole));
}

TEST(LayerCracks, HaveTheSameBitsForAnyNumberOfThreads) {
  Simulation one(peeling_plate());
  run_iterations(one, kDrying, 1);
  for (const int threads : {2, 3}) {
    Simulation other(peeling_plate());
    run_iterations(other, kDrying, threads);
    EXPECT_TRUE(other.snapshot() == one.snapshot()) << threads << " threads";
  }
}

TEST(LayerCracks, GoOnFromASnapshotAsIfNothingHadHappened) {
  for (const int first_part : {100, 150, 200}) {
    Simulation whole(peeling_plate()), first(peeling_plate()), second(peeling_plate());
    run_iterations(whole, kDrying);
    run_iterations(first, first_part);
    run_iterations(second, 130);
    second.restore(first.snapshot());
    run_iterations(second, kDrying - first_part);
    EXPECT_TRUE(second.snapshot() == whole.snapshot()) << first_part;
  }
}

TEST(LayerCracks, KeepTheirStrengthAndDirectionsInASnapshot) {
  Scene scene = peeling_plate();
  scene.objects[0].layers[kFilm].cracks->strength = "0.7 + 0.6*noise";
  scene.objects[0].layers[kFilm].cracks->tension = CrackTension{.along = {}, .ratio = 0.5};
  Simulation whole(scene), first(scene), second(scene);
  run_iterations(whole, kDrying);
  run_iterations(first, kDrying / 2);
  second.restore(first.snapshot());
  run_iterations(second, kDrying / 2);
  EXPECT_TRUE(second.snapshot() == whole.snapshot());
}

TEST(LayerCracks, CutOffWhatFallsAndTheBooksBalance) {
  Simulation simulation(peeling_plate());
  for (int k = 0; k < 8; ++k) {
    run_iterations(simulation, kDrying / 8);
    ASSERT_EQ(simulation.audit(), "");
    ASSERT_TRUE(simulation.ledger().balances());
  }
  const LayerAccount& account = simulation.layers()->account(0, kFilm);
  EXPECT_GT(account.flaked.value(), 0.1 * account.start.value());
  EXPECT_LT(account.flaked.value(), 0.95 * account.start.value());
  EXPECT_EQ(account.worn, MassSum{});
  EXPECT_GT(simulation.atlas().mass(2), 0);  // rust that lay below what has fallen
}

TEST(LayerCracks, APieceFallsAsAWhole) {
  // What is left of the paint has lost its adhesion over less than half of every piece.
  Simulation simulation(peeling_plate());
  run_iterations(simulation, kDrying);
  const ImageF thickness = map_of(simulation, "layer1.thickness_um"), adhesion = map_of(simulation, "layer1.adhesion");
  ImageU8 open = cracks_of(simulation);
  std::int64_t lost = 0, held = 0;
  for (std::int64_t i = 0; i < thickness.num_pixels(); ++i) {
    if (thickness.data()[i] > 0.0F) ++(adhesion.data()[i] > 0.0F ? held : lost);
    if (thickness.data()[i] == 0.0F) open.data()[i] = 255;
  }
  EXPECT_GT(held, 0);
  EXPECT_GT(lost, 0);
  EXPECT_LT(lost, held);
  const std::vector<int> cells = cells_of(open);
  EXPECT_GT(cells.size(), 3U);
}

TEST(LayerCracks, AndTheirMapsAreWhatTheyWereSetTo) {
  Simulation aged(peeling_plate()), shown(peeling_plate());
  for (int k = 0; k < 50; ++k) {
    run_iterations(aged, 4);
    (void)aged.compose();  // only what has changed
  }
  const std::vector<std::string> names = aged.layer_map_names();
  EXPECT_EQ(names, (std::vector<std::string>{"layer1.thickness_um", "layer1.adhesion", "layer1.interface.rust",
                                             "layer1.stress", "layer1.crack"}));
  for (std::size_t m = 0; m < aged.scene().materials.size(); ++m)
    shown.set_amounts(static_cast<int>(m), aged.amounts(static_cast<int>(m)));
  for (std::size_t k = 0; k < names.size(); ++k) shown.set_layer_map(k, aged.layer_map(k));
  const Composer &one = aged.compose(), &other = shown.compose();
  EXPECT_TRUE(std::equal(one.codes().begin(), one.codes().end(), other.codes().begin()));
  for (TexelIndex t = 0; t < one.codes().size(); ++t) ASSERT_EQ(one.height_mm(t), other.height_mm(t)) << t;
}

TEST(LayerCracks, WhatHasLostItsAdhesionIsLiftedByTheSquareOfItsWayFromWhereItHolds) {
  // Paint of 0.4 mm holds on the left half alone: R = 0.4 mm / 0.04.
  Scene scene = drying_plate(128, 4.0, 0.8);
  ImageF left(2, 1, 1, 0.0F);
  left.at(0, 0) = 1.0F;
  scene.maps.emplace_back() = {
      .name = "left", .kind = "image", .options = {}, .noise = {}, .wood_grain = {}, .images = {left}, .is_inside = {}};
  scene.objects[0].layers[kFilm].adhesion = "smoothstep(0.49, 0.51, left)";
  scene.objects[0].layers[kFilm].cracks->shrinkage = 0.05;
  Simulation simulation(scene);
  run_iterations(simulation, kDrying);
  const ImageF adhesion = map_of(simulation, "layer1.adhesion");
  const TileGrid& grid = simulation.atlas().surface().grid();
  const double mm = simulation.texel_size_mm();
  constexpr int kRow = 64;
  int last = 0;
  for (int x = 0; x < adhesion.width(); ++x) last = adhesion.at(x, kRow) > 0.0F ? x : last;
  ASSERT_GT(last, 32);
  ASSERT_LT(last, 96);
  // The last turn of a tile is up to 8 iterations ago.
  const double radius = 0.4 / 0.04, late = 1.0 - 8.0 / kDrying, step_mm = 2.0 * mm / 1024.0;
  const Composer& look = simulation.compose();
  for (int k = 0; k < 8; ++k) {
    const double x = k * mm, lift = look.height_mm(grid.index(last + k, kRow)) - 0.4;
    EXPECT_LE(lift, x * x / (2.0 * radius) + step_mm) << k;
    EXPECT_GE(lift, late * x * x / (2.0 * radius) - step_mm) << k;
  }
}

TEST(LayerCracks, AreDarkAndDeep) {
  Scene scene = drying_plate(256, 4.0);
  scene.objects[0].layers[kFilm].look.color.color = Vec3(0.8, 0.8, 0.8);
  scene.objects[0].layers[kFilm].cracks->shrinkage = 0.05;
  Simulation simulation(scene);
  run_iterations(simulation, kDrying);
  const Composer& look = simulation.compose();
  const SurfaceAtlas& surface = simulation.atlas().surface();
  constexpr double kThicknessMm = 0.4;  // 4 mm / 10; cracks are 0.8 mm wide, and texels 0.4 mm.
  for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    const bool is_cracked = simulation.layers()->cracked()[t] != 0;
    ASSERT_NEAR(look.height_mm(t), is_cracked ? 0.0 : kThicknessMm, simulation.texel_size_mm() / 1024.0);
    ASSERT_EQ((look.codes()[t] & 255) < 200, is_cracked);
  }
}

TEST(LayerCracks, ThatCannotBeAreRefusedInOneLine) {
  const auto says = [](const std::function<void(Scene&)>& change) {
    Scene scene = drying_plate(64, 4.0);
    change(scene);
    return error_of([&] { Simulation simulation(scene); });
  };
  const auto none = says([](Scene& s) { s.objects[0].layers[kFilm].cracks = {}; });
  EXPECT_TRUE(has(none, "rule 'drying' changes the stress of a layer, and no layer has \"cracks\"")) << none;
  const auto map = says([](Scene& s) { s.objects[0].layers[kFilm].cracks->strength = "1 + wornn"; });
  EXPECT_TRUE(has(map, "cracks/strength of layer 'paint' of object 'plate'")) << map;
  const auto relief = says([](Scene& s) { s.objects[0].layers[kFilm].cracks->relief = 0.0; });
  const auto ratio = says([](Scene& s) { s.objects[0].layers[kFilm].cracks->tension = CrackTension{.ratio = 0.0}; });
  EXPECT_TRUE(has(ratio, "the ratio of the tension of layer 'paint' of object 'plate' is 0; use [0.1, 10]")) << ratio;
  const auto along =
      says([](Scene& s) { s.objects[0].layers[kFilm].cracks->tension = CrackTension{.along = Vec3(1.0, 1.0, 0.0)}; });
  EXPECT_TRUE(has(along, "the length of the direction of the tension of layer 'paint' of object 'plate'")) << along;
  EXPECT_TRUE(has(relief, "the relief of layer 'paint' of object 'plate' is 0; use [0.1, 1000]")) << relief;
}

}  // namespace
}  // namespace patinate::simulation
