#include "simulation/device/device_arrays.h"

#include <vector>

namespace patinate::simulation {

DeviceArrays::DeviceArrays(const device::Device& its_device, const SurfaceAtlas& surface, int materials,
                           std::size_t gammatons)
    : device(its_device),
      num_materials(static_cast<std::uint32_t>(materials)),
      num_texels(surface.grid().num_texels()),
      num_tiles(surface.grid().num_tiles()),
      num_gammatons(static_cast<std::uint32_t>(gammatons)),
      width(surface.grid().width),
      weights(device.upload(surface.weights())),
      triangles(device.upload(surface.triangles())),
      amounts(device.allocate<std::uint16_t>(std::size_t{num_materials} * num_texels)),
      dirty(device.allocate<std::uint32_t>(num_tiles)),
      changed_in(device.allocate<std::int32_t>(num_tiles)),
      awake(device.allocate<std::uint32_t>(num_tiles)),
      is_listed(device.allocate<std::uint32_t>(num_tiles)),
      touched(device.allocate<std::uint32_t>(num_tiles)),
      cargo(device.allocate<std::uint32_t>(gammatons * num_materials)),
      contacts(device.allocate<std::uint32_t>(gammatons)),
      ended(device.allocate<std::uint32_t>(gammatons)),
      endings{device.allocate<std::uint32_t>(gammatons), device.allocate<std::uint32_t>(gammatons)},
      met(device.allocate<std::uint32_t>(num_texels / 32)),
      tally(device.allocate<std::uint32_t>(tally_types::kTallyWords)) {}

void list_tiles(std::span<const TileIndex> tiles, DeviceArrays& arrays) {
  std::vector<std::uint32_t> is_listed(arrays.num_tiles, 0);
  for (const TileIndex t : tiles) is_listed[t] = 1;
  arrays.device.write(std::span<const std::uint32_t>(is_listed), arrays.is_listed);
  arrays.device.write(tiles, arrays.touched);
  const auto num = static_cast<std::uint32_t>(tiles.size());
  arrays.device.write(std::span(&num, 1), arrays.tally, tally_types::kNumTouched);
}

}  // namespace patinate::simulation
