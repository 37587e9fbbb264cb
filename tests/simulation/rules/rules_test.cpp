#include "simulation/rules/rules.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "libcommon/core/random.h"
#include "simulation/rules/compiled_rules.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/simulation/tracing/tracing_scene.h"
#include "tests/simulation/transport/transport_scene.h"
#include "tests/support/errors.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::squeezed_plane;
using testing_support::TransportScene;

constexpr double kSigmas = 4.0;
const std::vector<std::string> kRustMaterials{"water", "metal", "rust"};

Rule rule_of(const std::string& driver, double rate, MaterialValues products, MaterialValues reactants = {}) {
  return {.name = "test", .driver = driver, .rate = rate, .products = products, .reactants = reactants};
}
const Rule kEvaporation = rule_of("water", 0.3, {}, {1.0});
const Rule kRust = rule_of("min(water, metal)", 0.05, {0.0, 0.0, 1.0});
const Rule kConsuming = rule_of("min(water, metal)", 0.4, {0.0, 0.0, 1.0}, {0.0, 1.0});

/// A surface with so much of everything at each covered texel, in quanta.
TransportScene filled(int resolution, std::array<std::uint16_t, 3> amounts) {
  TransportScene scene = squeezed_plane(resolution);
  for (const TexelIndex t : scene.covered) {
    for (int m = 0; m < 3; ++m) scene.atlas->writable_tile(m, TileGrid::tile_of(t))[t % 64] = amounts[m];
  }
  return scene;
}

/// Runs rules for a number of iterations from amounts that are alike everywhere.
TransportScene aged(std::vector<Rule> rules, int resolution, std::array<std::uint16_t, 3> amounts, double dt,
                    int iterations, std::uint64_t seed = 5) {
  TransportScene scene = filled(resolution, amounts);
  RuleEngine engine(rules, kRustMaterials, *scene.surface, dt, seed);
  for (int i = 0; i < iterations; ++i) (void)engine.step(i, *scene.atlas);
  return scene;
}

struct Moments {
  double mean = 0.0;
  double expected = 0.0;
  double n = 0.0;
};

/// Mean amount of a material in quanta, and of what `expected` says for the iterations that each tile is aged by.
Moments moments_of(const TransportScene& scene, int material, int iterations,
                   const std::function<double(double)>& expected) {
  Moments out;
  for (const TexelIndex t : scene.covered) {
    out.mean += scene.atlas->amount(material, t);
    out.expected += expected(static_cast<double>(RuleEngine::aged_iterations(TileGrid::tile_of(t), iterations - 1)));
    ++out.n;
  }
  out.mean /= out.n;
  out.expected /= out.n;
  return out;
}

TEST(RuleEngine, EvaporationIsTheExponentialForAnySplitOfTime) {
  for (const auto& [dt, iterations] : {std::pair{0.4, 10}, {0.05, 80}, {0.005, 800}}) {
    const TransportScene scene = aged({kEvaporation}, 64, {16384, 0, 0}, dt, iterations);
    const Moments m =
        moments_of(scene, 0, iterations, [dt = dt](double n) { return 16384.0 * std::exp(-0.3 * dt * n); });
    const double epochs = iterations / 8.0 + 1.0;
    constexpr double kFloats = 3e-7 * 16384;  // relative error of an epoch's decay
    EXPECT_NEAR(m.mean, m.expected, kSigmas * 0.5 * std::sqrt(epochs / m.n) + kFloats) << dt;
  }
}

TEST(RuleEngine, RustUnderConstantWaterGrowsEvenly) {
  const TransportScene scene = aged({kRust}, 64, {5000, 16384, 0}, 0.02, 400);
  const Moments m = moments_of(scene, 2, 400, [](double n) { return 5000.0 * 0.05 * 0.02 * n; });
  EXPECT_NEAR(m.mean, m.expected, kSigmas * 0.5 * std::sqrt(51 / m.n));
}

TEST(RuleEngine, RustUnderEvaporatingWaterConvergesWithTheTimeStep) {
  const auto error_at = [](double dt, int iterations) {
    const TransportScene scene = aged({kRust, kEvaporation}, 64, {8000, 16384, 0}, dt, iterations);
    const Moments m = moments_of(scene, 2, iterations,
                                 [dt](double n) { return 8000.0 * 0.05 / 0.3 * (1.0 - std::exp(-0.3 * dt * n)); });
    return (m.mean - m.expected) / m.expected;
  };
  const double coarse = error_at(0.1, 80), fine = error_at(0.05, 160), finest = error_at(0.0125, 640);
  // Rust of an epoch sees its first water: the error is 0.3 * 8 dt / 2 of the rust, to first order.
  EXPECT_NEAR(coarse, 0.12, 0.012);
  EXPECT_NEAR(fine / coarse, 0.5, 0.03);
  EXPECT_NEAR(finest / fine, 0.25, 0.03);
}

TEST(RuleEngine, MeanIsRightWhereAQuantumIsDueInFourThousandEpochs) {
  // A driver of one quantum, 1/4096 of it each epoch: 100 epochs over all texels make a Poisson count.
  constexpr double kPerIteration = 1.0 / 4096 / 8;
  const int iterations = 800;
  const TransportScene scene = aged({rule_of("1/16384", 1.0, {0, 0, 1.0})}, 256, {0, 0, 0}, kPerIteration, iterations);
  const Moments m = moments_of(scene, 2, iterations, [](double n) { return n * kPerIteration; });
  EXPECT_GT(m.expected * m.n, 1000.0);
  EXPECT_NEAR(m.mean, m.expected, kSigmas * std::sqrt(m.expected / m.n));
}

TEST(RuleEngine, TwoHalfStepsAreOneWholeInTheMean) {
  struct Case {
    Rule rule;
    int material;
  };
  for (const Case& c : {Case{kEvaporation, 0}, Case{kConsuming, 1}, Case{kConsuming, 2}, Case{kRust, 2}}) {
    const TransportScene whole = aged({c.rule}, 64, {16384, 9000, 100}, 0.1, 80),
                         halves = aged({c.rule}, 64, {16384, 9000, 100}, 0.05, 160, 6);
    double difference = 0, n = 0;
    for (const TexelIndex t : whole.covered) {
      if (TileGrid::tile_of(t) % 8 != 1)
        continue;  // tiles that both runs have aged in their last iteration, 79 and 159
      difference += double(whole.atlas->amount(c.material, t)) - double(halves.atlas->amount(c.material, t));
      ++n;
    }
    constexpr double kFloats = 3e-7 * 16384;
    EXPECT_NEAR(difference / n, 0.0, kSigmas * 0.5 * std::sqrt((10 + 20) / n) + kFloats)
        << c.rule.driver << " " << c.material;
  }
}

TEST(RuleEngine, WhatARuleUsesIsWhatItMakes) {
  const TransportScene scene = aged({kConsuming}, 64, {12000, 16384, 3}, 0.25, 200);
  for (const TexelIndex t : scene.covered) ASSERT_EQ(scene.atlas->amount(1, t) + scene.atlas->amount(2, t), 16387);
  EXPECT_LT(scene.atlas->amount(1, scene.covered[9]), 1000);
}

TEST(RuleEngine, NothingIsOverdrawnOrOverfilled) {
  const Rule greedy = rule_of("1e30", 1e6, {0, 0, 1000.0}, {1000.0, 1.0});
  const TransportScene scene =
      aged({greedy, rule_of("-5*metal", 1.0, {1.0}), kRust}, 64, {16384, 9000, 65530}, 1.0, 20);
  for (const TexelIndex t : scene.covered) {
    ASSERT_LE(scene.atlas->amount(0, t), 16384);
    ASSERT_LE(scene.atlas->amount(1, t), 9000);
    ASSERT_EQ(scene.atlas->amount(2, t), 65535);
  }
  EXPECT_EQ(scene.atlas->amount(0, scene.covered[0]), 0) << "all that there was";
  const TransportScene divided = aged({rule_of("water/(metal - metal)", 1.0, {0, 0, 1.0})}, 64, {9, 7, 5}, 1.0, 20);
  EXPECT_EQ(divided.atlas->amount(2, divided.covered[0]), 5) << "division by zero is 0";
}

TEST(RuleEngine, EveryTileIsAgedOnceAnEpochByAllTheTimeSince) {
  // One quantum an iteration, without rounding: amounts count iterations.
  for (const int iterations : {1, 5, 8, 17}) {
    const TransportScene scene = aged({rule_of("1/16384", 1.0, {0, 0, 1.0})}, 128, {0, 0, 0}, 1.0, iterations);
    for (const TexelIndex t : scene.covered) {
      const std::int64_t aged_by = RuleEngine::aged_iterations(TileGrid::tile_of(t), iterations - 1);
      ASSERT_EQ(scene.atlas->amount(2, t), aged_by);
      ASSERT_GT(aged_by, iterations - RuleEngine::kEpoch);
      ASSERT_LE(aged_by, iterations);
    }
  }
}

TEST(RuleEngine, RandomNumbersOfTexelsAndTimesAreIndependent) {
  // Half a quantum each epoch: after n epochs a binomial count; its variance, and products of neighbors, say whether
  // draws depend.
  constexpr int kEpochs = 64;
  const TransportScene scene = aged({rule_of("0.5/16384", 1.0, {0, 0, 1.0})}, 256, {0, 0, 0}, 1.0 / 8, 8 * kEpochs);
  double n = 0, variance = 0, with_next = 0, with_below = 0;
  for (const TexelIndex t : scene.covered) {
    if (TileGrid::tile_of(t) % 8 != 1)
      continue;  // the tiles that were aged in the last iteration: kEpochs whole epochs
    const auto off = [&](TexelIndex i) { return double(scene.atlas->amount(2, i)) - kEpochs / 2.0; };
    if (!scene.surface->is_covered(t ^ 1) || !scene.surface->is_covered(t ^ 8)) continue;
    n += 1;
    variance += off(t) * off(t);
    with_next += off(t) * off(t ^ 1);
    with_below += off(t) * off(t ^ 8);
  }
  EXPECT_GT(n, 5000);
  constexpr double kVariance = kEpochs / 4.0;
  EXPECT_NEAR(variance / n, kVariance, kSigmas * kVariance * std::sqrt(2.0 / n));
  EXPECT_NEAR(with_next / n, 0.0, kSigmas * kVariance * std::sqrt(2.0 / n));  // pairs are counted twice
  EXPECT_NEAR(with_below / n, 0.0, kSigmas * kVariance * std::sqrt(2.0 / n));
}

struct Outcome {
  std::string hash;
  std::vector<TileIndex> dirty;
  std::array<std::int64_t, kMaxMaterials> made, used;
  friend bool operator==(const Outcome&, const Outcome&) = default;
};

Outcome outcome_of(int num_threads, InstructionSet set) {
  TransportScene scene = squeezed_plane(256);
  for (std::size_t i = 0; i < scene.covered.size(); i += 3) {
    scene.atlas->writable_tile(0, TileGrid::tile_of(scene.covered[i]))[scene.covered[i] % 64] =
        static_cast<std::uint16_t>(i * 7);
  }
  const std::vector<Rule> rules{
      kConsuming, rule_of("pow(rust, 1.5)/(0.1 + smoothstep(0, 1, water)) + 0.01*age", 0.1, {0.2, 0.1}), kEvaporation};
  RuleEngine engine(rules, kRustMaterials, *scene.surface, 0.02, 7, {}, set);
  RunControl control;
  control.num_threads = num_threads;
  Outcome out{};
  for (int i = 0; i < 30; ++i) {
    const RuleReport report = engine.step(i, *scene.atlas, control);
    out.dirty.insert(out.dirty.end(), report.dirty_tiles.begin(), report.dirty_tiles.end());
    EXPECT_TRUE(std::is_sorted(report.dirty_tiles.begin(), report.dirty_tiles.end()));
    for (std::size_t m = 0; m < kMaxMaterials; ++m) {
      out.made[m] += report.made[m];
      out.used[m] += report.used[m];
    }
  }
  out.hash = scene.atlas->hash();
  return out;
}

TEST(RuleEngine, HasTheSameBitsForAnyNumberOfThreads) {
  const Outcome one = outcome_of(1, InstructionSet::Baseline);
  for (const int num_threads : {2, 3, 8}) EXPECT_EQ(outcome_of(num_threads, InstructionSet::Baseline), one);
}

TEST(RuleEngine, HasTheSameBitsWithAvx2) {
  if (!has_instruction_set(InstructionSet::Avx2)) GTEST_SKIP() << "this machine lacks AVX2";
  EXPECT_EQ(outcome_of(2, InstructionSet::Avx2), outcome_of(2, InstructionSet::Baseline));
}

TEST(RuleEngine, HasTheSameBitsWithAvx512) {
  if (!has_instruction_set(InstructionSet::Avx512)) GTEST_SKIP() << "this machine lacks AVX-512";
  EXPECT_EQ(outcome_of(2, InstructionSet::Avx512), outcome_of(2, InstructionSet::Baseline));
}

TEST(RuleEngine, SleepSavesWorkAndChangesNothing) {
  TransportScene scene = filled(128, {0, 16384, 0}), awake = filled(128, {0, 16384, 0});
  const std::vector<Rule> rules{kRust, kEvaporation};
  RuleEngine engine(rules, kRustMaterials, *scene.surface, 0.5, 7);
  const auto pour = [&](TransportScene& into, std::size_t i) {
    const TexelIndex t = into.covered[i * 377 % into.covered.size()];
    into.atlas->writable_tile(0, TileGrid::tile_of(t))[t % 64] = 500;
    return TileGrid::tile_of(t);
  };
  for (int i = 0; i < 200; ++i) {
    if (i % 12 == 0) {
      const TileIndex tile = pour(scene, static_cast<std::size_t>(i));
      engine.wake({&tile, 1});
      (void)pour(awake, static_cast<std::size_t>(i));
    }
    (void)engine.step(i, *scene.atlas);
    RuleEngine fresh(rules, kRustMaterials, *awake.surface, 0.5, 7);  // as after resuming: all tiles awake
    (void)fresh.step(i, *awake.atlas);
    if (i == 199) {
      EXPECT_GT(fresh.num_awake(), 10 * engine.num_awake());
    }
  }
  EXPECT_EQ(scene.atlas->hash(), awake.atlas->hash());
  EXPECT_GT(engine.num_awake(), 0);
  for (int i = 200; i < 500; ++i) (void)engine.step(i, *scene.atlas);
  EXPECT_EQ(engine.num_awake(), 0) << "all dry";
}

TEST(CompiledRules, KnowWithoutWhichMaterialsNothingHappens) {
  constexpr std::uint32_t kWater = 1, kMetal = 2, kOxide = 4;
  std::vector<SurfaceParameter> slope(1);
  slope[0].name = "slope";
  const std::vector<std::pair<std::string, std::uint32_t>> cases{
      {"min(1, 8*water) * metal * max(0, 1 - rust)", kWater | kMetal},
      {"min(water, metal, rust)", kWater | kMetal | kOxide},
      {"(water + metal) * rust", kOxide},
      {"max(water, metal) * slope", 0},
      {"max(0, water) / metal", kWater | kMetal},
      {"min(water - 0.5, metal)", 0},  // below 0 where there is no metal, too; but not always
      {"min(water, slope)", 0},
      {"-water * (slope - metal)", kWater},
      {"water * clamp(metal - 1, 0, 1)", kWater},
      {"min(abs(slope), metal) * smoothstep(0, 1, water)", kMetal},
      {"1 - water", 0}};
  for (const auto& [driver, needs] : cases) {
    const CompiledRules rules = compile_rules(std::vector<Rule>{rule_of(driver, 1.0, {1.0})}, kRustMaterials, slope);
    std::uint32_t found = 0;
    for (std::size_t k = 0; k < rules.materials.size(); ++k) {
      if ((rules.rules[0].needs >> k & 1) != 0) found |= std::uint32_t{1} << rules.materials[k];
    }
    EXPECT_EQ(found, needs) << driver;
    // Whatever the others are.
    struct alignas(64) Block {
      std::array<float, kExpressionBlock> values;
    };
    std::vector<Block> slots(static_cast<std::size_t>(rules.num_slots));
    RandomStream random(3, 0);
    for (std::size_t without = 0; without < rules.materials.size(); ++without) {
      if ((rules.rules[0].needs >> without & 1) == 0) continue;
      for (std::size_t k = 0; k < slots.size(); ++k) {
        for (float& v : slots[k].values)
          v = k == without ? 0.0F
                           : static_cast<float>(k < rules.materials.size() ? 3.0 : 2.0) *
                                 static_cast<float>(random.uniform() - (k < rules.materials.size() ? 0.0 : 0.5));
      }
      for (const auto& constant : rules.rules[0].driver.constants) slots[constant.slot].values.fill(constant.value);
      run_expression(rules.rules[0].driver, slots[0].values.data(), InstructionSet::Baseline);
      for (const float v : slots[rules.rules[0].driver.result].values)
        ASSERT_EQ(v, 0.0F) << driver << " without " << kRustMaterials[rules.materials[without]];
    }
  }
  EXPECT_EQ(compile_rules(std::vector<Rule>{rule_of("1", 1.0, {}, {0.0, 1.0})}, kRustMaterials, {}).rules[0].needs, 1u)
      << "what a rule uses has to be there";
}

TEST(RuleEngine, ReportsWhatItMadeAndUsed) {
  TransportScene scene = filled(64, {4000, 16384, 65500});
  const std::vector<Rule> rules{kConsuming, kEvaporation};
  RuleEngine engine(rules, kRustMaterials, *scene.surface, 0.1, 7);
  std::array<std::int64_t, 3> balance{};
  for (int m = 0; m < 3; ++m) balance[m] = scene.atlas->mass(m);
  for (int i = 0; i < 50; ++i) {
    const RuleReport report = engine.step(i, *scene.atlas);
    for (std::size_t m = 0; m < 3; ++m) {
      balance[m] += report.made[m] - report.used[m];
      ASSERT_EQ(scene.atlas->mass(static_cast<int>(m)), balance[m]);
    }
  }
}

TEST(RuleEngine, TouchesNoTexelOutsideTheCharts) {
  const TransportScene scene = aged({rule_of("1", 0.1, {1.0})}, 128, {0, 0, 0}, 1.0, 16);
  for (TexelIndex t = 0; t < scene.surface->grid().num_texels(); ++t) {
    if (!scene.surface->is_covered(t)) {
      ASSERT_EQ(scene.atlas->amount(0, t), 0);
    }
  }
  EXPECT_GT(scene.atlas->amount(0, scene.covered[0]), 0);
}

TEST(RuleEngine, DriversMayAskForAgeAndSurfaceParameters) {
  const TransportScene by_age = aged({rule_of("age", 1e-4, {1.0})}, 64, {0, 0, 0}, 1.0, 80);
  const Moments m =
      moments_of(by_age, 0, 80, [](double n) { return 16384.0 * 1e-4 * n * n / 2.0; });  // the integral of age
  EXPECT_NEAR(m.mean, m.expected, kSigmas * 0.5 * std::sqrt(11 / m.n) + 1e-3);

  TransportScene scene = filled(64, {0, 0, 0});
  const ImageF map(64, 64, 1, 0.25F);
  const std::vector<Rule> rules{rule_of("exposure*(1 - slope)", 0.5, {1.0})};
  EXPECT_TRUE(has(error_of([&] { (void)RuleEngine(rules, kRustMaterials, *scene.surface, 1.0, 1); }),
                  "rule 'test' asks for `exposure`, of which there is no map"));
  EXPECT_EQ(parameters_of(rules[0], kRustMaterials), (std::vector<std::string>{"exposure", "slope"}));
  const std::vector<float> slopes(scene.surface->grid().num_texels(), 0.5F);
  RuleEngine engine(rules, kRustMaterials, *scene.surface, 1.0 / 8, 1,
                    {map_parameter("exposure", map, *scene.surface), {.name = "slope", .values = slopes}});
  for (int i = 0; i < 8; ++i) (void)engine.step(i, *scene.atlas);
  const TexelIndex t = *std::find_if(scene.covered.begin(), scene.covered.end(),
                                     [](TexelIndex i) { return TileGrid::tile_of(i) % 8 == 1; });
  EXPECT_NEAR(scene.atlas->amount(0, t), 16384 * 0.25 * 0.5 * 0.5, 1.1);  // one rounding, and the map's codes
}

TEST(RuleEngine, NamesTheDriverThatCannotBeRead) {
  const TransportScene scene = squeezed_plane(64);
  const auto says = [&](const std::string& driver) {
    const std::vector<Rule> rules{rule_of(driver, 1.0, {1.0})};
    return error_of([&] { (void)RuleEngine(rules, kRustMaterials, *scene.surface, 1.0, 1); });
  };
  EXPECT_EQ(
      says("min(watr, metal)"),
      "rule 'test': driver `min(watr, metal)`: position 5: unknown material or parameter `watr`; there are "
      "`water`, `metal`, `rust`, `accessibility`, `ray_share`, `tangent_sphere`, `exposure`, `sun`, `facing`, "
      "`height`, "
      "`spray`, `noise`, `wood_grain`, `slope`, `age`, `rain`, `temperature`, `humidity`, `sunshine`, `wind`; did "
      "you mean `water`?");
  EXPECT_TRUE(has(says("water +"), "position 8: found the end"));
}

TEST(SurfaceParameter, SlopeIsNoneOnTheFloorHalfOnAWallAndOneOnACeiling) {
  Scene source;
  SceneObject object;
  object.name = "triangle";
  object.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  object.mesh.triangles = {{0, 1, 2}};
  object.mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
  object.mesh.uv_triangles = {{0, 1, 2}};
  object.mesh.triangle_surface = {0};
  object.mesh.surfaces.resize(1);
  source.objects.push_back(object);
  const SceneMesh mesh = make_scene_mesh(source);
  const SurfaceAtlas surface(mesh, 64);
  const auto slope = [&](const Vec3& up) {
    const SurfaceParameter parameter = slope_parameter(mesh, surface, up);
    return std::get<std::vector<std::uint16_t>>(parameter.values)[surface.grid().index(10, 50)] / 65535.0;
  };
  EXPECT_EQ(slope({0, 0, 1}), 0.0);
  EXPECT_NEAR(slope({0, 1, 0}), 0.5, 0.5 / 65535 + 1e-9);
  EXPECT_EQ(slope({0, 0, -1}), 1.0);
}

TEST(SurfaceParameter, SlopeOfASphereDoesNotShowItsTriangles) {
  Scene source;
  SceneObject object;
  object.name = "ball";
  object.mesh = testing_support::with_any_uvs(testing_support::make_icosphere(10.0, 2));
  source.objects.push_back(object);
  const SceneMesh mesh = make_scene_mesh(source);
  const SurfaceAtlas surface(mesh, 256);
  const SurfaceParameter parameter = slope_parameter(mesh, surface, {0, 1, 0});
  const auto& values = std::get<std::vector<std::uint16_t>>(parameter.values);
  double largest = 0.0;
  for (TexelIndex t = 0; t < surface.grid().num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    const std::array<double, 3> weights = surface.corner_weights(t);
    Vec3 p = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = mesh.mesh.triangles[surface.triangle(t)][k];
      p += weights[k] * mesh.mesh.positions[corner];
    }
    largest = std::max(largest, std::abs(values[t] / 65535.0 - (1.0 - p.normalized().y()) / 2.0));
  }
  // Triangles of 18 degrees across have normals up to 10 degrees off: 0.09. Interpolated, vertices' normals are off by
  // under one degree, since triangles round a vertex of five differ a little from each other.
  EXPECT_LT(largest, 0.01);
}

}  // namespace
}  // namespace patinate::simulation
