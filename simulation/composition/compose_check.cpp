#include <memory>
#include <optional>

#include "patinate/simulation/compose.h"
#include "simulation/composition/compose_device.h"
#include "simulation/device/check_scene.h"
#include "simulation/device/simulation_device.h"

namespace patinate::simulation {

device::CheckResult check_composition(const device::Device& device) {
  const Scene scene = check_scene();
  const CheckSurface on(scene);
  const MaterialAtlas atlas = on.any_amounts();
  std::optional<device::DeviceError> failure;
  Composer here(scene, on.mesh, on.surface), there(scene, on.mesh, on.surface);
  there.use(
      std::make_shared<const SimulationDevice>(device, [&](const device::DeviceError& problem) { failure = problem; }));
  (void)here.compose(atlas, {});
  (void)there.compose(atlas, {});
  if (failure) throw device::DeviceError(*failure);
  device::CheckResult check{.num_items = static_cast<std::int64_t>(2 * here.codes().size() + here.normals().size())};
  for (std::size_t i = 0; i < here.codes().size(); ++i)
    check.num_different += here.codes()[i] == there.codes()[i] ? 0 : 1;
  for (std::size_t i = 0; i < here.normals().size(); ++i)
    check.num_different += here.normals()[i] == there.normals()[i] ? 0 : 1;
  for (TexelIndex t = 0; t < on.surface.grid().num_texels(); ++t)
    check.num_different += here.height_mm(t) == there.height_mm(t) ? 0 : 1;
  return check;
}

}  // namespace patinate::simulation
