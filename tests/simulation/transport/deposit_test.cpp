// Deposits of gammatons where they end.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "libcommon/core/random.h"
#include "simulation/transport/exchange.h"
#include "simulation/transport/part_sums.h"
#include "simulation/transport/splat.h"
#include "simulation/transport/trail.h"
#include "tests/simulation/transport/transport_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::cargo_mass;
using testing_support::random_cargo;
using testing_support::random_contacts;
using testing_support::seamed_plane;
using testing_support::squeezed_plane;
using testing_support::TransportScene;

constexpr std::uint64_t kDepositSeed = 11;

std::vector<Ending> endings_of(const std::vector<Contact>& contacts) {
  std::vector<Ending> endings;
  for (const Contact& contact : contacts) {
    endings.push_back({.gammaton = contact.gammaton, .trail = {}});
    endings.back().trail.add(contact.texel);
  }
  return endings;
}

TEST(Trail, KeepsTheLastContactsInTheirOrder) {
  Trail trail;
  EXPECT_EQ(trail.size(), 0u);
  for (TexelIndex n = 0; n < 100; ++n) {
    trail.add(n);
    ASSERT_EQ(trail.size(), std::min<std::size_t>(n + 1, Trail::kLength));
    for (std::size_t i = 0; i < trail.size(); ++i) ASSERT_EQ(trail.texel(i), n + 1 - trail.size() + i);
  }
  std::vector<Trail> trails(2);
  follow(std::vector<Contact>{{5, 0}, {6, 1}}, trails);
  follow(std::vector<Contact>{{7, 0}, {8, 1, true}}, trails);
  EXPECT_EQ(trails[0].size(), 2u);
  EXPECT_EQ(trails[1].size(), 1u) << "it has fallen from elsewhere";
  EXPECT_EQ(trails[1].texel(0), 8u);
}

TEST(PartSums, AreThoseOfASortedMapWithTheMiddleFirst) {
  PartSums sums;
  RandomStream random(3, 0);
  for (const std::uint32_t num_texels : {40u, 3000u, 200'000u, 500u}) {  // the third has more tiles than slots at first
    std::map<TexelIndex, std::uint32_t> slow;
    TexelIndex middle = 0;
    for (int i = 0; i < 5000; ++i) {
      const TexelIndex texel = random.below(num_texels);
      const std::uint32_t share = random.below(3);  // 0 counts as a part, too
      sums.add(texel, share);
      slow[texel] += share;
      if (i == 700) middle = texel;
    }
    std::vector<SplatPart> parts{{.texel = 1, .share = 2}};
    sums.take(middle, parts);
    ASSERT_EQ(parts.size(), slow.size() + 1);
    EXPECT_EQ(parts[1].texel, middle);
    EXPECT_EQ(parts[1].share, slow[middle]);
    slow.erase(middle);
    std::size_t k = 2;
    for (const auto& [texel, share] : slow) {
      ASSERT_EQ(parts[k].texel, texel);
      ASSERT_EQ(parts[k++].share, share);
    }
  }
}

TEST(Deposit, IsDarkestWhereTheWayEnds) {
  TransportScene scene = seamed_plane(128);
  const TileGrid& grid = scene.surface->grid();
  Ending ending;
  std::vector<TexelIndex> middles;
  for (int y = 4; y < grid.height && ending.trail.size() < Trail::kLength; y += TileGrid::kTileSide) {
    const TexelIndex middle = grid.index(36, y);
    if (!scene.surface->is_plain(TileGrid::tile_of(middle))) continue;
    ending.trail.add(middle);
    middles.push_back(middle);
  }
  const auto num_steps = static_cast<int>(middles.size());
  ASSERT_GT(num_steps, 5);
  Cargo cargo;
  cargo.mass.push_back({kAmountOne * 256u});
  Exchanger exchanger(1, kDepositSeed);
  const std::array one{ending};
  (void)exchanger.deposit(one, {.rates = {0.1}, .splat_texels = 1}, 0, cargo, *scene.atlas);
  for (int i = 0; i < num_steps; ++i) {
    const double expected = kAmountOne * (i + 1) / (0.5 * num_steps * (num_steps + 1));
    const TexelIndex first = middles[i] / TileGrid::kTileTexels * TileGrid::kTileTexels;
    double sum = 0.0;
    for (TexelIndex t = first; t < first + TileGrid::kTileTexels; ++t) sum += scene.atlas->amount(0, t);
    EXPECT_NEAR(sum, expected, 6.0) << i;  // parts, each in whole quanta
  }
  EXPECT_LT(cargo.mass[0][0], 256u);
}

TEST(Deposit, LeavesAllThatFitsWhereGammatonsEnd) {
  for (const double splat_mm : {0.0, 5.0}) {
    TransportScene scene = squeezed_plane(64);
    const TexelIndex full = scene.covered[700];
    scene.atlas->writable_tile(0, TileGrid::tile_of(full))[full % 64] = kMaxAmount - 1;
    constexpr std::uint32_t kGammatons = 400;
    Cargo cargo = random_cargo(kGammatons, 0.5, 4);
    std::vector<Contact> contacts = random_contacts(scene, kGammatons, 1, 3);
    contacts[7].texel = full;
    const std::int64_t total = scene.atlas->mass(0) + cargo_mass(cargo, 0), idle = cargo_mass(cargo, 1);
    ParameterMaps maps(scene.surface->grid(), {.hits = true, .deposited = {true}});
    Exchanger exchanger(3, kDepositSeed);
    const ExchangeReport report =
        exchanger.deposit(endings_of(contacts), {.ratio = 0.1, .rates = {0.01, 0.0, 0.5}, .splat_mm = splat_mm}, 3,
                          cargo, *scene.atlas, &maps);
    EXPECT_EQ(scene.atlas->mass(0) + cargo_mass(cargo, 0), total);
    EXPECT_EQ(cargo_mass(cargo, 1), idle) << "a material without a rate takes no part";
    std::int64_t deposited = 0;
    for (const TexelIndex t : scene.covered) {
      EXPECT_EQ(maps.hits()->value(t), 0u);
      deposited += static_cast<std::int64_t>(maps.deposited(0)->value(t));
    }
    EXPECT_EQ(deposited, report.dropped[0]);
    for (std::uint32_t g = 0; g < kGammatons; ++g) {
      // Less than a quantum of each texel that it lies on.
      if (g != 7) {
        EXPECT_LT(cargo.mass[g][0], SplatShape::kMaxParts * 2000u) << g;
      }
    }
    if (splat_mm == 0.0) {
      EXPECT_EQ(scene.atlas->amount(0, full), kMaxAmount);
      EXPECT_GT(cargo.mass[7][0], 0u);
    }
  }
}

TEST(Deposit, HasTheSameBitsForAnyNumberOfThreads) {
  const auto outcome = [](int num_threads) {
    TransportScene scene = squeezed_plane(128);
    Cargo cargo = random_cargo(5000, 1.0, 1);
    Exchanger exchanger(3, kDepositSeed);
    RunControl control;
    control.num_threads = num_threads;
    (void)exchanger.deposit(endings_of(random_contacts(scene, 5000, 2, 3)),
                            {.ratio = 0.6, .rates = {0.5, 0.0, 0.02}, .contact = 1.0, .splat_mm = 4.0}, 0, cargo,
                            *scene.atlas, nullptr, control);
    return std::pair(scene.atlas->hash(), cargo.mass);
  };
  const auto one = outcome(1);
  for (const int num_threads : {2, 3, 8}) EXPECT_EQ(one, outcome(num_threads)) << num_threads;
}

}  // namespace
}  // namespace patinate::simulation
