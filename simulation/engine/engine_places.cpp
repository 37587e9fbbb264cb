// Consequences of objects that are moved, turned or scaled while a simulation runs.
#include <array>
#include <cstdint>
#include <cstdlib>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/engine/engine_state.h"

namespace patinate::simulation {

namespace {

using Masses = std::array<std::int64_t, kMaxMaterials>;

/// Mass that has come onto the surfaces since the start, in the present weights.
Masses mass_since_start(const MaterialAtlas& atlas, const LayerAtlas* layers, const RunControl& control) {
  const SurfaceAtlas& surface = atlas.surface();
  Masses masses = parallel_reduce(
      std::int64_t{surface.grid().num_texels()}, TileGrid::kPageTexels, control, Masses{},
      [&](std::int64_t begin, std::int64_t end) {
        Masses sum{};
        for (auto t = static_cast<TexelIndex>(begin); t < end; ++t) {
          if (!surface.is_covered(t)) continue;
          for (int m = 0; m < atlas.num_materials(); ++m)
            sum[m] += (std::int64_t{atlas.amount(m, t)} - atlas.original(m, t)) * surface.weight(t);
        }
        return sum;
      },
      [](Masses a, const Masses& b) {
        for (std::size_t m = 0; m < a.size(); ++m) a[m] += b[m];
        return a;
      });
  for (int m = 0; layers && m < atlas.num_materials(); ++m) masses[m] += layers->interface_mass(m, control);
  return masses;
}

}  // namespace

void Simulation::State::check_scale(std::size_t object, double scale) const {
  const double factor = scale / start_scales[object];
  if (factor <= SurfaceAtlas::kMaxScaling && factor >= 1.0 / SurfaceAtlas::kMaxScaling) return;
  throw InvalidInput("object '" + scene.objects[object].name + "' would be scaled to " + number_text(factor) +
                     " times its size at the start; use [1/8, 8] times: the atlas is made for that size");
}

void Simulation::State::move_objects(const Scene& changed) {
  SceneMesh moved = scene_mesh;
  place_objects(moved, changed);
  if (moved.mesh.positions == scene_mesh.mesh.positions) return;
  scene_mesh = std::move(moved);
  tracer.set_mesh(scene_mesh);
  has_old_maps = true;
  std::vector<double> factors;
  for (std::size_t i = 0; i < changed.objects.size(); ++i)
    factors.push_back(changed.objects[i].scale / start_scales[i]);
  if (factors == scale_factors) return;
  const Masses before = mass_since_start(atlas, layers.get(), {});
  const std::vector<std::int64_t> layers_before = layers ? layers->remaining() : std::vector<std::int64_t>();
  surface.set_scale_factors(factors);
  there.reset();  // A device has the weights as they were.
  scale_factors = std::move(factors);
  const Masses after = mass_since_start(atlas, layers.get(), {});
  if (layers) enter_scaled_layers(layers_before);
  Masses made{}, used{};
  for (std::size_t m = 0; m < made.size(); ++m)
    (after[m] >= before[m] ? made : used)[m] = std::abs(after[m] - before[m]);
  ledger.add_rules(made, used);
}

void Simulation::State::enter_scaled_layers(std::span<const std::int64_t> before) {
  const std::vector<std::int64_t> after = layers->remaining();
  for (std::size_t i = 0; i < after.size(); ++i) layers->accounts()[i].start += after[i] - before[i];
  rules->wake_everything();  // which remember weights of texels
}

void Simulation::State::renew_rules(const RunControl& control) {
  if (!has_old_maps) return;
  rules = make_rules(control);
  has_old_maps = false;
}

}  // namespace patinate::simulation
