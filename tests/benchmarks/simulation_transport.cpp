#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/random.h"
#include "simulation/rules/rules.h"
#include "simulation/transport/exchange.h"
#include "tests/benchmarks/simulation_parts.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/meshes.h"
#include "tests/support/threads.h"

namespace patinate::benchmarks {

namespace {

const std::vector<std::string> kMaterials{"water", "metal", "rust", "dirt", "organic"};

struct World {
  std::unique_ptr<simulation::SurfaceAtlas> surface;
  std::unique_ptr<simulation::MaterialAtlas> atlas;
};

/// Metal all over the atlas, in 128 x 128 x 2 triangles.
World plane_of(int resolution) {
  simulation::Scene scene;
  simulation::SceneObject object;
  object.name = "plane";
  object.mesh = testing_support::unit_plane(1000, 128);
  scene.objects.push_back(std::move(object));
  World world;
  world.surface = std::make_unique<simulation::SurfaceAtlas>(simulation::make_scene_mesh(scene), resolution);
  world.atlas = std::make_unique<simulation::MaterialAtlas>(
      *world.surface, static_cast<int>(kMaterials.size()),
      std::vector<std::array<std::uint16_t, simulation::kMaxMaterials>>{{0, simulation::kAmountOne}});
  return world;
}

std::vector<simulation::Contact> contacts_on(const World& world, std::uint32_t n, std::uint64_t seed) {
  RandomStream random(seed, 0);
  std::vector<simulation::Contact> contacts;
  while (contacts.size() < n) {
    const simulation::TexelIndex t = random.below(world.surface->grid().num_texels());
    if (world.surface->is_covered(t)) contacts.push_back({t, static_cast<std::uint32_t>(contacts.size())});
  }
  return contacts;
}

/// Median of `runs` calls, ms.
template <class Work>
double median_ms(int runs, Work&& work) {
  std::vector<double> times;
  for (int i = 0; i < runs; ++i) times.push_back(1e3 * seconds([&] { work(i); }));
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

double exchange_ms(World& world, std::uint32_t n, int splat, int num_threads) {
  std::vector<std::vector<simulation::Contact>> contacts;
  for (std::uint64_t i = 0; i < 8; ++i) contacts.push_back(contacts_on(world, n, i));
  simulation::Cargo cargo;
  cargo.mass.assign(n, {simulation::kAmountOne * 256, 0, 0, simulation::kAmountOne * 64});
  simulation::Exchanger exchanger(static_cast<int>(kMaterials.size()), 1);
  const simulation::ExchangeOptions options{.ratio = 0.5, .rates = {0.3, 0.0, 0.0, 0.1}, .splat_texels = splat};
  const auto run = [&](int i) {
    (void)exchanger.exchange(contacts[i % 8], options, i, cargo, *world.atlas, nullptr,
                             testing_support::with_threads(num_threads));
  };
  for (int i = 0; i < 8; ++i) run(i);
  return median_ms(n > 100'000 ? 7 : 41, run);
}

double rules_ms(World& world, double wet, int num_threads, InstructionSet set) {
  RandomStream random(2, 0);
  for (simulation::TileIndex tile = 0; tile < world.surface->grid().num_tiles(); ++tile) {
    const bool is_wet = random.uniform() < wet;
    for (std::uint16_t& amount : world.atlas->writable_tile(0, tile))
      amount = static_cast<std::uint16_t>(is_wet ? 2000 + random.below(9000) : 0);
  }
  std::vector<simulation::Rule> three(3);
  three[0] = {.name = "rust", .driver = "min(water, metal)", .rate = 0.1, .products = {0, 0, 1.0}};
  three[1] = {.name = "growth", .driver = "min(water, dirt)", .rate = 0.1, .products = {0, 0, 0, 0, 1.0}};
  three[2] = {.name = "evaporation", .driver = "water", .rate = 0.1, .reactants = {1.0}};
  simulation::RuleEngine engine(three, kMaterials, *world.surface, 0.01, 1, {}, set);
  for (int i = 0; i < 16; ++i) (void)engine.step(i, *world.atlas, testing_support::with_threads(num_threads));
  return median_ms(21,
                   [&](int i) { (void)engine.step(16 + i, *world.atlas, testing_support::with_threads(num_threads)); });
}

}  // namespace

void exchange() {
  std::printf("exchange of two materials, ms an iteration       1 thread  2 threads\n");
  for (const int resolution : {1024, 2048, 4096}) {
    World world = plane_of(resolution);
    for (const std::uint32_t n : {5'000u, 100'000u, 1'000'000u}) {
      std::printf("  %4d^2, %7u gammatons                    %9.3f  %9.3f\n", resolution, n,
                  exchange_ms(world, n, 1, 1), exchange_ms(world, n, 1, 2));
    }
    std::printf("  %4d^2, %7u gammatons, splat of 3        %9.3f  %9.3f\n", resolution, 5000u,
                exchange_ms(world, 5000, 3, 1), exchange_ms(world, 5000, 3, 2));
    std::printf("  %4d^2, %7u gammatons, splat of 5        %9.3f  %9.3f\n", resolution, 5000u,
                exchange_ms(world, 5000, 5, 1), exchange_ms(world, 5000, 5, 2));
  }
}

void rules() {
  std::printf("three rules, ms an iteration                     1 thread  2 threads\n");
  for (const int resolution : {1024, 2048, 4096}) {
    World world = plane_of(resolution);
    for (const double wet : {0.5, 0.8}) {
      for (std::size_t i = 0; i < kInstructionSetNames.size(); ++i) {
        const auto set = static_cast<InstructionSet>(i);
        if (!has_instruction_set(set)) {
          std::printf("  %4d^2, %2.0f %% wet, %-8s  skipped: not on this machine\n", resolution, wet * 100,
                      kInstructionSetNames[i].data());
          continue;
        }
        std::printf("  %4d^2, %2.0f %% wet, %-8s                  %9.3f  %9.3f\n", resolution, wet * 100,
                    kInstructionSetNames[i].data(), rules_ms(world, wet, 1, set), rules_ms(world, wet, 2, set));
      }
    }
  }
}

}  // namespace patinate::benchmarks
