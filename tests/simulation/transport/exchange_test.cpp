#include "simulation/transport/exchange.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "libcommon/core/random.h"
#include "simulation/transport/pieces.h"
#include "simulation/transport/splat.h"
#include "simulation/transport/transfer.h"
#include "tests/simulation/transport/transport_scene.h"
#include "tests/support/threads.h"

namespace patinate::simulation {
namespace {

using testing_support::cargo_mass;
using testing_support::random_cargo;
using testing_support::random_contacts;
using testing_support::seamed_plane;
using testing_support::squeezed_plane;
using testing_support::TransportScene;

constexpr std::uint64_t kExchangeSeed = 11;
const ExchangeOptions kOptions{.ratio = 0.6, .rates = {0.5, 0.0, 0.02}, .contact = 1.0, .splat_texels = 1};

/// One contact after another, by gammaton, on a map of texels: what Exchanger must equal for splats of one texel.
void exchange_slowly(std::vector<Contact> contacts, const ExchangeOptions& options, std::int64_t iteration,
                     Cargo& cargo, const SurfaceAtlas& surface,
                     std::map<std::pair<int, TexelIndex>, std::uint32_t>& amounts, std::set<TileIndex>& dirty) {
  std::sort(contacts.begin(), contacts.end(),
            [](const Contact& a, const Contact& b) { return a.gammaton < b.gammaton; });
  for (const Contact& contact : contacts) {
    const std::uint32_t weight = surface.weight(contact.texel);
    std::size_t active = 0;
    const auto randoms = transfer_randoms(kExchangeSeed, contact.gammaton, iteration, 0, 8);
    for (int m = 0; m < 3; ++m) {
      const double rate = options.rates[m];
      if (rate == 0.0) continue;
      std::uint32_t& amount = amounts.at({m, contact.texel});
      std::uint32_t& mass = cargo.mass[contact.gammaton][m];
      const int quanta = transfer_quanta(transfer_shares(options.ratio, rate, options.contact, weight), amount, weight,
                                         mass, randoms[active++]);
      if (quanta != 0) dirty.insert(TileGrid::tile_of(contact.texel));
      amount -= static_cast<std::uint32_t>(quanta);
      mass += static_cast<std::uint32_t>(quanta) * weight;
    }
  }
}

TEST(Exchanger, EqualsOneContactAfterAnother) {
  for (const std::uint32_t n : {700u, 40'000u}) {  // sorted at once, and in sections
    TransportScene scene = squeezed_plane(128);
    std::map<std::pair<int, TexelIndex>, std::uint32_t> amounts;
    for (int m = 0; m < 3; ++m) {
      for (const TexelIndex t : scene.covered) amounts[{m, t}] = scene.atlas->amount(m, t);
    }
    Cargo cargo = random_cargo(n, 1.0, 1), slow_cargo = cargo;
    Exchanger exchanger(3, kExchangeSeed);
    for (int iteration = 0; iteration < 4; ++iteration) {
      const std::vector<Contact> contacts = random_contacts(scene, n, static_cast<std::uint64_t>(iteration), 5);
      std::set<TileIndex> dirty;
      exchange_slowly(contacts, kOptions, iteration, slow_cargo, *scene.surface, amounts, dirty);
      const std::int64_t before = scene.atlas->mass(0);
      const ExchangeReport report = exchanger.exchange(contacts, kOptions, iteration, cargo, *scene.atlas, nullptr,
                                                       testing_support::with_threads(2));
      EXPECT_EQ(scene.atlas->mass(0) - before, report.dropped[0] - report.picked_up[0]);
      EXPECT_TRUE(std::equal(report.dirty_tiles.begin(), report.dirty_tiles.end(), dirty.begin(), dirty.end()));
    }
    EXPECT_EQ(cargo.mass, slow_cargo.mass);
    for (const auto& [key, amount] : amounts) ASSERT_EQ(scene.atlas->amount(key.first, key.second), amount);
  }
}

/// One part of one splat after another, by gammaton: what Exchanger must equal, whichever regions they lie in.
void exchange_splats_slowly(std::vector<Contact> contacts, const ExchangeOptions& options, double width,
                            std::int64_t iteration, Cargo& cargo, MaterialAtlas& atlas) {
  std::sort(contacts.begin(), contacts.end(),
            [](const Contact& a, const Contact& b) { return a.gammaton < b.gammaton; });
  const SurfaceAtlas& surface = atlas.surface();
  const SplatShape shape(surface, width);
  for (const Contact& contact : contacts) {
    std::vector<SplatPart> parts;
    (void)shape.append(contact.texel, parts);
    const auto randoms = transfer_randoms(kExchangeSeed, contact.gammaton, iteration, 0, 8);
    std::size_t active = 0;
    for (int m = 0; m < 3; ++m) {
      const double rate = options.rates[m];
      if (rate == 0.0) continue;
      std::uint32_t& whole = cargo.mass[contact.gammaton][m];
      std::vector<std::uint32_t> masses(parts.size());
      deal(
          whole, randoms[active], surface.weight(contact.texel), parts.size(),
          [&](std::size_t k) { return parts[k].share; }, [&](std::size_t k, std::uint32_t mass) { masses[k] = mass; });
      std::uint32_t sum = 0;
      for (std::size_t k = 0; k < parts.size(); ++k) {
        const TexelIndex texel = parts[k].texel;
        const std::uint32_t weight = surface.weight(texel), amount = atlas.amount(m, texel);
        const double area = contact_area(options, surface) * parts[k].share / SplatShape::kWhole;
        const std::uint32_t limit =
            masses[k] + (0xFFFFFFFFu - whole) / static_cast<std::uint32_t>(SplatShape::kMaxParts);
        const int quanta = transfer_quanta(
            transfer_shares(options.ratio, rate, options.contact, weight, area), amount, weight, masses[k],
            transfer_kernel::mixed_with(randoms[active], static_cast<std::uint32_t>(k)), limit);
        if (quanta != 0)
          atlas.writable_tile(m, TileGrid::tile_of(texel))[texel % 64] =
              static_cast<std::uint16_t>(static_cast<int>(amount) - quanta);
        sum += masses[k] + static_cast<std::uint32_t>(quanta) * weight;
      }
      whole = sum;
      ++active;
    }
  }
}

struct SplatCase {
  bool is_squeezed;  ///< Texels of many sizes; else a seam.
  int resolution;
  double width;  ///< In texels of median size.
  double most;   ///< That a gammaton carries of a material.
  bool is_in_mm;
};

TransportScene splat_scene(const SplatCase& of) {
  return of.is_squeezed ? squeezed_plane(of.resolution) : seamed_plane(of.resolution);
}

TEST(Exchanger, EqualsOnePartOfASplatAfterAnother) {
  // Splats of 5 texels are 3 sqrt 2 wide. At 1024, regions have several pages. The last fills texels, and gammatons.
  for (const SplatCase& one : {SplatCase{true, 256, 3.0 * std::numbers::sqrt2, 1.0, false},
                               {false, 256, 3.0 * std::numbers::sqrt2, 1.0, false},
                               {true, 1024, 12.0, 16.0, true},
                               {false, 1024, 24.0, 64.0, true},
                               {false, 256, SplatShape::kWidest, 1000.0, true},
                               {true, 256, SplatShape::kWidest, 1000.0, true}}) {
    TransportScene slow = splat_scene(one);
    ASSERT_GT(slow.surface->grid().num_pages(), 4u);
    const auto gammatons = static_cast<std::uint32_t>(one.is_in_mm ? 1000 : 4000);
    ExchangeOptions options = kOptions;
    options.splat_texels = 5;
    const double median_mm = slow.surface->median_texel_size_mm();
    if (one.is_in_mm) options.splat_mm = one.width * median_mm;
    const double width = one.is_in_mm ? options.splat_mm / median_mm : one.width;
    std::vector<std::vector<Contact>> contacts;
    for (std::uint64_t i = 0; i < 3; ++i) contacts.push_back(random_contacts(slow, gammatons, i, 5));
    const Cargo start = random_cargo(gammatons, one.most, 1);
    Cargo slow_cargo = start;
    for (std::size_t i = 0; i < contacts.size(); ++i)
      exchange_splats_slowly(contacts[i], options, width, static_cast<std::int64_t>(i), slow_cargo, *slow.atlas);
    for (const InstructionSet set : {InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512}) {
      if (!has_instruction_set(set)) continue;
      TransportScene scene = splat_scene(one);
      Cargo cargo = start;
      Exchanger exchanger(3, kExchangeSeed, set);
      for (std::size_t i = 0; i < contacts.size(); ++i)
        (void)exchanger.exchange(contacts[i], options, static_cast<std::int64_t>(i), cargo, *scene.atlas, nullptr,
                                 testing_support::with_threads(2));
      EXPECT_EQ(cargo.mass, slow_cargo.mass) << one.width << " " << static_cast<int>(set);
      EXPECT_EQ(scene.atlas->hash(), slow.atlas->hash()) << one.width << " " << static_cast<int>(set);
      EXPECT_EQ(scene.atlas->memory(), slow.atlas->memory());
    }
  }
}

struct Outcome {
  std::string hash;
  std::vector<std::array<std::uint32_t, kMaxMaterials>> cargo;
  std::vector<std::uint32_t> hits;
  friend bool operator==(const Outcome&, const Outcome&) = default;
};

Outcome outcome_of(std::uint32_t n, int splat, int num_threads, bool is_shuffled) {
  TransportScene scene = squeezed_plane(128);
  Cargo cargo = random_cargo(n, 1.0, 1);
  Exchanger exchanger(3, kExchangeSeed);
  ParameterMaps maps(scene.surface->grid(), {.hits = true, .residence = true});
  ExchangeOptions options = kOptions;
  options.splat_texels = splat;
  for (int iteration = 0; iteration < 2; ++iteration) {
    std::vector<Contact> contacts = random_contacts(scene, n, static_cast<std::uint64_t>(iteration), 3);
    RandomStream random(static_cast<std::uint64_t>(num_threads), 9);
    for (std::uint32_t i = n; is_shuffled && i > 1; --i) std::swap(contacts[i - 1], contacts[random.below(i)]);
    (void)exchanger.exchange(contacts, options, iteration, cargo, *scene.atlas, &maps,
                             testing_support::with_threads(num_threads));
  }
  Outcome out{scene.atlas->hash(), cargo.mass, {}};
  for (const TexelIndex t : scene.covered)
    out.hits.push_back(maps.hits()->value(t) * 1000 + maps.residence()->value(t));
  return out;
}

TEST(Exchanger, HasTheSameBitsForAnyThreadsAndOrder) {
  for (const int splat : {1, 3, 5}) {
    for (const std::uint32_t n :
         {500u, splat == 1 ? 33'000u : 5'000u}) {  // as parts: below and above what is sorted at once
      const Outcome one = outcome_of(n, splat, 1, false);
      EXPECT_EQ(one, outcome_of(n, splat, 1, true)) << "shuffled";
      for (const int num_threads : {2, 3, 8})
        EXPECT_EQ(one, outcome_of(n, splat, num_threads, num_threads == 3)) << splat << " " << n << " " << num_threads;
    }
  }
}

TEST(Exchanger, ConservesEveryQuantumForEveryRatioAndRate) {
  constexpr std::uint32_t kGammatons = 12'000;
  RandomStream random(3, 3);
  for (const int splat : {1, 5}) {
    TransportScene scene = squeezed_plane(64);
    Cargo cargo = random_cargo(kGammatons, 16.0, 2);
    Exchanger exchanger(3, kExchangeSeed);
    std::array<std::int64_t, 3> total{};
    for (int m = 0; m < 3; ++m) total[m] = scene.atlas->mass(m) + cargo_mass(cargo, static_cast<std::size_t>(m));
    std::int64_t iteration = 0;
    for (const double ratio : {0.0, 0.001, 0.3, 0.5, 1.0}) {
      for (const double rate : {0.0, 1.0 / 4096, 0.1, 1.0}) {
        const ExchangeOptions options{.ratio = ratio,
                                      .rates = {rate, rate, 1.0 - rate},
                                      .contact = 1.0 + random.uniform(),
                                      .splat_texels = splat};
        const std::vector<Contact> contacts =
            random_contacts(scene, kGammatons, static_cast<std::uint64_t>(iteration), 40);
        (void)exchanger.exchange(contacts, options, iteration++, cargo, *scene.atlas);
        for (int m = 0; m < 3; ++m) {
          ASSERT_EQ(scene.atlas->mass(m) + cargo_mass(cargo, static_cast<std::size_t>(m)), total[m]);
        }
      }
    }
  }
}

TEST(Exchanger, AFullTexelTakesNoMoreAndLosesNothing) {
  TransportScene scene = squeezed_plane(64);
  const TexelIndex texel = scene.covered[700];
  scene.atlas->writable_tile(0, TileGrid::tile_of(texel))[texel % 64] = kMaxAmount;
  Cargo cargo = random_cargo(50, 16.0, 4);
  const Cargo before = cargo;
  std::vector<Contact> contacts;
  for (std::uint32_t g = 0; g < 50; ++g) contacts.push_back({texel, g});
  Exchanger exchanger(1, kExchangeSeed);
  const ExchangeReport report = exchanger.exchange(contacts, {.ratio = 1.0, .rates = {1.0}}, 0, cargo, *scene.atlas);
  EXPECT_EQ(scene.atlas->amount(0, texel), kMaxAmount);
  EXPECT_EQ(cargo.mass, before.mass);
  EXPECT_TRUE(report.dirty_tiles.empty());
}

TEST(Exchanger, WashingClearsAWetPlaceAndRainFillsADryOne) {
  // Many light gammatons over one texel: picking up alone leaves (1 - up)^n of it, in the mean over texels.
  TransportScene scene = squeezed_plane(64);
  Exchanger exchanger(3, kExchangeSeed);
  const ExchangeOptions washing{.ratio = 0.0, .rates = {0.0, 0.05, 0.0}};
  const auto n = static_cast<std::uint32_t>(scene.covered.size());
  std::vector<Contact> contacts;
  for (std::uint32_t g = 0; g < n; ++g) contacts.push_back({scene.covered[g], g});
  for (int i = 0; i < 10; ++i) {
    Cargo cargo = random_cargo(n, 0.0, 1);
    (void)exchanger.exchange(contacts, washing, i, cargo, *scene.atlas);
  }
  double sum = 0, expected = 0;
  for (const TexelIndex t : scene.covered) {
    sum += scene.atlas->amount(1, t);
    expected += kAmountOne * std::pow(1.0 - transfer_shares(0.0, 0.05, 1.0, scene.surface->weight(t)).up, 10);
  }
  EXPECT_NEAR(sum, expected, 4.0 * std::sqrt(10 * 0.25 * n));  // ten roundings a texel, each of variance <= 1/4
}

TEST(Exchanger, WakesAndWritesOnlyWhereSomethingChanged) {
  TransportScene scene = squeezed_plane(128);
  Cargo cargo = random_cargo(100, 0.0, 1);  // dry gammatons on a dry surface
  Exchanger exchanger(3, kExchangeSeed);
  const ExchangeReport report =
      exchanger.exchange(random_contacts(scene, 100, 1), {.ratio = 0.5, .rates = {1.0}}, 0, cargo, *scene.atlas);
  EXPECT_TRUE(report.dirty_tiles.empty());
  EXPECT_EQ(scene.atlas->memory(), 0u);
}

TEST(ParameterMaps, CountWhatTheExchangeDoes) {
  TransportScene scene = squeezed_plane(64);
  ParameterMaps maps(scene.surface->grid(),
                     {.hits = true, .last_hit = true, .residence = true, .deposited = {true, false, true}});
  Exchanger exchanger(3, kExchangeSeed);
  Cargo cargo = random_cargo(2000, 1.0, 1);
  std::map<TexelIndex, std::uint32_t> hits, last, residence;
  std::int64_t dropped = 0;
  for (int i = 0; i < 5; ++i) {
    const std::vector<Contact> contacts = random_contacts(scene, 2000, static_cast<std::uint64_t>(i), 3);
    std::set<TexelIndex> touched;
    for (const Contact& contact : contacts) {
      ++hits[contact.texel];
      last[contact.texel] = static_cast<std::uint32_t>(i) + 1;
      touched.insert(contact.texel);
    }
    for (const TexelIndex t : touched) ++residence[t];
    dropped += exchanger.exchange(contacts, kOptions, i, cargo, *scene.atlas, &maps).dropped[2];
  }
  std::int64_t deposited = 0;
  for (const TexelIndex t : scene.covered) {
    EXPECT_EQ(maps.hits()->value(t), hits[t]);
    EXPECT_EQ(maps.last_hit()->value(t), last[t]);
    EXPECT_EQ(maps.residence()->value(t), residence[t]);
    deposited += static_cast<std::int64_t>(maps.deposited(2)->value(t));
  }
  EXPECT_EQ(deposited, dropped);
  EXPECT_EQ(maps.deposited(1), nullptr);
}

}  // namespace
}  // namespace patinate::simulation
