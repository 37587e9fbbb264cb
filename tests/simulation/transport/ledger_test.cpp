#include "patinate/simulation/ledger.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "libcommon/core/random.h"
#include "simulation/transport/exchange.h"
#include "simulation/transport/ledger_json.h"
#include "tests/simulation/transport/transport_scene.h"
#include "tests/support/errors.h"

namespace patinate::simulation {
namespace {

using testing_support::has;
using testing_support::random_contacts;
using testing_support::squeezed_plane;
using testing_support::TransportScene;

const std::vector<std::string> kNames{"water", "metal", "dirt"};

TEST(MassSum, GoesBeyond64Bits) {
  MassSum sum;
  for (int i = 0; i < 8; ++i) sum += std::int64_t{1} << 62;
  EXPECT_EQ(sum.value(), 0x1p65);
  for (int i = 0; i < 8; ++i) sum += -(std::int64_t{1} << 62);
  EXPECT_EQ(sum, MassSum{});
  sum += -1;
  EXPECT_EQ(sum.value(), -1.0);
  MassSum other = sum;
  other += 5;
  other -= sum;
  EXPECT_EQ(other.value(), 5.0);
  EXPECT_EQ(MassSum::from_parts(sum.high(), sum.low()), sum);
}

TEST(MassLedger, BalancesInEveryIterationOfALife) {
  constexpr std::uint32_t kGammatons = 500;
  TransportScene scene = squeezed_plane(64);
  Cargo cargo;
  cargo.mass.resize(kGammatons);
  MassLedger ledger;
  Exchanger exchanger(3, 1);
  RandomStream random(7, 7);
  for (std::uint32_t g = 0; g < kGammatons; ++g)
    ledger.birth(g, MassLedger::cargo_of({0.8, 0.0, random.uniform()}), cargo);
  for (int i = 0; i < 60; ++i) {
    const std::vector<Contact> contacts = random_contacts(scene, kGammatons, static_cast<std::uint64_t>(i));
    ledger.add(exchanger.exchange(
        contacts, {.ratio = random.uniform(), .rates = {0.5, 0.01, 1.0}, .splat_texels = i % 3 == 0 ? 3 : 1}, i, cargo,
        *scene.atlas));
    for (std::uint32_t g = 0; g < kGammatons; ++g) {
      if (random.below(10) != 0) continue;
      ledger.end(g, static_cast<CargoEnd>(random.below(3)), cargo);
      ledger.birth(g, MassLedger::cargo_of({0.8, 0.0, 0.1}), cargo);
    }
    // Effect of rules: one quantum made, some used.
    const TexelIndex t = scene.covered[i];
    scene.atlas->writable_tile(1, TileGrid::tile_of(t))[t % 64] -= 3;
    ledger.add_rules({}, {0, 3 * scene.surface->weight(t)});
    ASSERT_TRUE(ledger.balances());
    ASSERT_EQ(audit(ledger, *scene.atlas, cargo, kNames), "");
  }
  EXPECT_GT(ledger.account(0).left.value(), 0.0);
  EXPECT_GT(ledger.account(0).absorbed.value(), 0.0);
  EXPECT_GT(ledger.account(0).rested.value(), 0.0);
}

// Five gammatons with 0.5 of water on a texel of median size each; one left, one was absorbed. Then 3 quanta of metal
// from nowhere.
TEST(MassLedger, HasOneVocabularyInJson) {
  Cargo cargo;
  cargo.mass.resize(5);
  MassLedger ledger;
  for (std::uint32_t g = 0; g < 5; ++g) ledger.birth(g, MassLedger::cargo_of({0.5}), cargo);
  ledger.end(0, CargoEnd::Left, cargo);
  ledger.end(1, CargoEnd::Absorbed, cargo);
  const Json expected{{"emitted", 2.5}, {"made", 0.0}, {"on_surfaces", 0.0}, {"carried", 1.5}, {"absorbed", 0.5},
                      {"rested", 0.0},  {"left", 0.5}, {"used", 0.0},        {"residual", 0.0}};
  EXPECT_EQ(ledger_json(ledger, kNames).at("water"), expected);
  ledger.account(1).made += 3;
  EXPECT_EQ(ledger_json(ledger, kNames).at("metal").at("residual").get<double>(),
            3.0 / (double{kAmountOne} * SurfaceAtlas::kMedianWeight));
}

TEST(MassLedger, AuditFindsASingleLostQuantum) {
  TransportScene scene = squeezed_plane(64);
  Cargo cargo;
  cargo.mass.resize(1);
  MassLedger ledger;
  ledger.birth(0, MassLedger::cargo_of({1.0}), cargo);
  EXPECT_EQ(cargo.mass[0][0], kAmountOne * SurfaceAtlas::kMedianWeight);
  EXPECT_EQ(audit(ledger, *scene.atlas, cargo, kNames), "");
  --cargo.mass[0][0];
  EXPECT_EQ(audit(ledger, *scene.atlas, cargo, kNames),
            "material 'water': the gammatons differ from the ledger by -1 quanta");
  ++cargo.mass[0][0];
  const TexelIndex t = scene.covered[5];
  scene.atlas->writable_tile(1, TileGrid::tile_of(t))[t % 64] += 1;
  EXPECT_TRUE(has(audit(ledger, *scene.atlas, cargo, kNames), "material 'metal': the surfaces differ"));
}

TEST(MassLedger, CargoIsRoundedToWholeQuanta) {
  EXPECT_EQ(MassLedger::cargo_of({0.5 / (kAmountOne * 256.0), 16.0})[0], 1u);
  EXPECT_EQ(MassLedger::cargo_of({0.0, 16.0})[1], 16u * kAmountOne * 256u);
}

}  // namespace
}  // namespace patinate::simulation
