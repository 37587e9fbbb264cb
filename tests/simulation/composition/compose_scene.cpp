#include "tests/simulation/composition/compose_scene.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/random.h"

namespace patinate::testing_support {

ComposeScene::ComposeScene(Mesh mesh, int resolution, std::vector<simulation::MaterialAppearance> appearance,
                           const std::function<void(simulation::Scene&)>& change) {
  simulation::SceneObject object;
  object.name = "object";
  object.mesh = std::move(mesh);
  scene.objects.push_back(std::move(object));
  for (std::size_t i = 0; i < appearance.size(); ++i) scene.materials.push_back("material" + std::to_string(i));
  scene.appearance = std::move(appearance);
  scene.resolution = resolution;
  if (change) change(scene);
  scene_mesh = simulation::make_scene_mesh(scene);
  surface = std::make_unique<simulation::SurfaceAtlas>(scene_mesh, resolution);
  map = std::make_unique<TexelMap>(scene_mesh.mesh, resolution, resolution);
  std::vector<std::array<std::uint16_t, simulation::kMaxMaterials>> originals;
  for (const simulation::SceneObject& each : scene.objects) {
    std::array<std::uint16_t, simulation::kMaxMaterials> quanta{};
    for (std::size_t i = 0; i < quanta.size(); ++i)
      quanta[i] = static_cast<std::uint16_t>(std::lround(each.preset.amounts[i] * simulation::kAmountOne));
    originals.push_back(quanta);
  }
  atlas = std::make_unique<simulation::MaterialAtlas>(*surface, static_cast<int>(scene.materials.size()),
                                                      std::move(originals));
}

void ComposeScene::set(int material, const std::function<double(int, int, const Vec3&)>& value) {
  const simulation::TileGrid& grid = surface->grid();
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const simulation::TexelIndex t = grid.index(x, y);
      if (!surface->is_covered(t)) continue;
      const double amount = value(x, y, map->position_mm(std::int64_t{y} * grid.width + x));
      atlas->writable_tile(material, simulation::TileGrid::tile_of(t))[t % simulation::TileGrid::kTileTexels] =
          static_cast<std::uint16_t>(
              std::lround(std::clamp(amount * simulation::kAmountOne, 0.0, double{simulation::kMaxAmount})));
    }
  }
}

ImageF ComposeScene::composed() const {
  simulation::Composer each = composer();
  (void)each.compose(*atlas, {});
  return each.color_linear();
}

CoarseAgainstFine compare_coarse_with_fine(const ImageF& coarse, const ImageF& fine) {
  constexpr int kBorder = 4;
  const int times = fine.width() / coarse.width(), num_fine = times * times;
  double squares = 0.0, values = 0.0, value_squares = 0.0, n = 0.0;
  for (int y = kBorder; y < coarse.height() - kBorder; ++y) {
    for (int x = kBorder; x < coarse.width() - kBorder; ++x) {
      double sum = 0.0;
      for (int k = 0; k < num_fine; ++k) sum += double{fine.at(times * x + k % times, times * y + k / times, 0)};
      const double value = double{coarse.at(x, y, 0)}, difference = sum / num_fine - value;
      squares += difference * difference, value_squares += value * value, values += value, n += 1.0;
    }
  }
  return {.mean_square = squares / n, .variance = value_squares / n - values / n * values / n};
}

std::vector<simulation::MaterialAppearance> any_appearance(int num_materials, std::uint64_t seed) {
  std::vector<simulation::MaterialAppearance> appearance;
  for (int i = 0; i < num_materials; ++i) {
    RandomStream random(seed, static_cast<std::uint64_t>(i));
    simulation::MaterialAppearance look;
    look.color.color = Vec3(random.uniform(), random.uniform(), random.uniform());
    look.strength = i == 0 ? 1.0 : std::exp(4.0 * random.uniform() - 2.0);
    look.variation = i % 3 == 0 ? 0.0 : random.uniform();
    look.specular = 2.0 * random.uniform() - 1.0;
    look.specular_variation = i % 2 == 0 ? 0.0 : random.uniform();
    look.height_mm = 0.5 * (2.0 * random.uniform() - 1.0);
    look.height_variation = i % 2 == 1 ? 0.0 : random.uniform();
    for (int k = 0; k < 2 + i % 3 && i % 4 == 1; ++k) {
      const double amount = 0.5 * k + 0.3 * random.uniform();
      const Vec3 color(random.uniform(), random.uniform(), random.uniform());
      look.colors.push_back({.amount = amount, .color = color, .second_color = Vec3(random.uniform(), 0.5, 0.5)});
    }
    appearance.push_back(std::move(look));
  }
  return appearance;
}

void set_any_amounts(ComposeScene& scene, std::uint64_t seed) {
  const int n = static_cast<int>(scene.scene.materials.size());
  for (int m = 0; m < std::max(1, n - 1); ++m) {
    scene.set(m, [&](int x, int y, const Vec3& p) {
      RandomStream random(seed, (static_cast<std::uint64_t>(m) << 40) + static_cast<std::uint64_t>(y) * 65536 +
                                    static_cast<std::uint64_t>(x));
      const double wave = std::sin(0.3 * p.x() + m) * std::cos(0.2 * p.y() - m);
      const double original = scene.scene.objects[0].preset.amounts[m];
      return std::max(0.0, original + wave) * (0.9 + 0.2 * random.uniform());
    });
  }
}

}  // namespace patinate::testing_support
