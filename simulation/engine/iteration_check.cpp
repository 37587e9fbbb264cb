#include "simulation/engine/iteration_check.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "libcommon/core/random.h"
#include "patinate/simulation/engine.h"
#include "simulation/device/simulation_device.h"
#include "simulation/tracing/gammatons.h"

namespace patinate::simulation {

namespace {

constexpr int kResolution = 128;  ///< A small wall and run that a device must repeat to the byte.
constexpr std::int64_t kGammatons = 1024;
constexpr int kIterations = 20;

/// Two charts, so that drops run over seams.
Mesh hills() {
  constexpr int kCells = 24;
  Mesh mesh;
  for (int y = 0; y <= kCells; ++y) {
    for (int x = 0; x <= kCells; ++x) {
      RandomStream random(8, static_cast<std::uint64_t>(y * (kCells + 1) + x));
      mesh.positions.emplace_back(2.0 * x, 4.0 * random.uniform(), 2.0 * y);
    }
  }
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const int i = y * (kCells + 1) + x;
      for (const std::array<int, 3>& triangle :
           {std::array{i, i + kCells + 2, i + 1}, std::array{i, i + kCells + 1, i + kCells + 2}}) {
        mesh.triangles.push_back(triangle);
        const bool is_left = x < kCells / 2;
        std::array<int, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k) {
          const int column = triangle[k] % (kCells + 1), row = triangle[k] / (kCells + 1);
          corners[k] = static_cast<int>(mesh.uvs.size());
          mesh.uvs.emplace_back((column + (is_left ? 0.5 : 2.0)) / (kCells + 3), (row + 0.5) / (kCells + 3));
        }
        mesh.uv_triangles.push_back(corners);
      }
    }
  }
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  mesh.surfaces.push_back({"hills", "hills"});
  return mesh;
}

/// Every step of expressions, makes and uses, rules that run dry and that overflow.
std::vector<Rule> rules_of_all_kinds() {
  return {{.name = "one",
           .driver = "pow(water, 0.7) * clamp(rust - 0.2, 0, 0.5) + smoothstep(0.1, 0.6, slope)",
           .rate = 0.05,
           .products = {0.0, 0.4, 1.0},
           .reactants = {1.0}},
          {.name = "two",
           .driver = "min(water, rust, 0.4) / max(dirt, slope) + abs(slope - age)",
           .rate = 0.2,
           .products = {0.0, 0.0, 3.0},
           .reactants = {0.2, 0.5}},
          {.name = "three", .driver = "!rust", .rate = 0.3, .products = {0.0, 0.1}, .where = "slope"},
          {.name = "four", .driver = "-(-dirt)", .rate = 4.0, .reactants = {0.0, 0.0, 1.0}}};
}

std::vector<MaterialAppearance> looks_of_all_kinds() {
  std::vector<MaterialAppearance> looks(3);
  for (int i = 0; i < 3; ++i) {
    MaterialAppearance& look = looks[i];
    look.color.color = Vec3(0.9 - 0.4 * i, 0.2 + 0.3 * i, 0.5);
    look.strength = 0.5 + i;
    look.variation = 0.3 * i;
    look.specular = 0.4 - 0.4 * i;
    look.height_mm = 0.3 * (i - 1);
    look.height_variation = 0.5;
    look.grain_mm = i == 1 ? 4.0 : 0.0;
  }
  looks[1].second_color = Vec3(0.1, 0.1, 0.8);
  looks[2].colors = {{.amount = 0.1, .color = {0.1, 0.8, 0.5}}, {.amount = 0.6, .color = {0.8, 0.2, 0.1}}};
  return looks;
}

template <class A, class B>
void compare(const A& a, const B& b, device::CheckResult& check) {
  check.num_items += static_cast<std::int64_t>(a.size());
  if (a.size() != b.size()) {
    check.num_different += static_cast<std::int64_t>(a.size());
    return;
  }
  for (std::size_t i = 0; i < a.size(); ++i) check.num_different += a[i] == b[i] ? 0 : 1;
}

}  // namespace

Scene check_scene(double splat_mm) {
  Scene scene;
  SceneObject object;
  object.name = "hills";
  object.mesh = hills();
  object.preset.amounts[1] = 0.25;
  scene.objects.push_back(std::move(object));
  scene.materials = {"water", "rust", "dirt"};
  scene.appearance = looks_of_all_kinds();
  scene.rules = rules_of_all_kinds();
  scene.resolution = kResolution;
  scene.time_per_iteration = 0.1;
  scene.emitters.push_back({.name = "rain",
                            .shape = EmitterShape::Sky,
                            .direction = Vec3(0.2, -1, 0.1).normalized(),
                            .spread_deg = 20,
                            .speed_mm_s = 2000,
                            .gammatons = kGammatons,
                            .carries = {1.0, 0.0, 0.2}});
  scene.behavior = {.bounce = 0.2, .floating = 0.7, .absorb = 0.1};
  scene.exchange.rates = {0.8, 0.0, 0.3};
  scene.exchange.splat_mm = splat_mm;
  scene.tracing.wet_attraction = 0.5;
  scene.tracing.rivulet_mm = 3.0;
  return scene;
}

device::CheckResult check_iterations(const device::Device& device) {
  std::optional<device::DeviceError> failure;
  device::CheckResult check;
  // Contacts of one texel, of a few, and of hundreds, on either side of what a stencil has and what is walked.
  for (const double splat_mm : {0.0, 2.0, 7.0}) {
    SimulationOptions options{.parameter_maps = {"hits", "residence", "water.deposited"}};
    Simulation here(check_scene(splat_mm), options);
    options.device = std::make_shared<const SimulationDevice>(
        device, [&](const device::DeviceError& problem) { failure = problem; });
    Simulation there(check_scene(splat_mm), options);
    for (int i = 0; i < kIterations; ++i) {
      here.step();
      there.step();
    }
    const Composer &a = here.compose(), &b = there.compose();
    compare(a.codes(), b.codes(), check);
    compare(a.normals(), b.normals(), check);
    compare(here.gammatons().position, there.gammatons().position, check);
    compare(here.snapshot(), there.snapshot(), check);
    if (failure) throw device::DeviceError(*failure);
  }
  return check;
}

}  // namespace patinate::simulation
