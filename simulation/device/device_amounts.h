/// \file
/// Amounts on their way between an atlas and a device.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "patinate/simulation/material_atlas.h"
#include "simulation/device/device_arrays.h"

namespace patinate::simulation {

/// The text of amounts_device.cl.
extern const std::string_view kAmountEntries;

/// Tiles that have changed here go there, and the other way round.
class DeviceAmounts {
 public:
  /// @throws DeviceError, as put() and read_dirty().
  explicit DeviceAmounts(const device::Device& device);

  void put(const MaterialAtlas& atlas, std::span<const TileIndex> tiles, DeviceArrays& arrays);
  /// Reads the tiles that are dirty there. Nothing changes there.
  void read_dirty(const DeviceArrays& arrays);
  /// Gives them to the atlas.
  void give(MaterialAtlas& atlas) const;

 private:
  device::Program program_;
  device::Kernel gather_, scatter_;
  std::vector<TileIndex> tiles_;
  std::vector<std::uint32_t> changed_;  ///< By tile: a bit for each material.
  std::vector<std::uint16_t> values_;   ///< By tile, then material.
};

}  // namespace patinate::simulation
