/// \file
/// Amounts of all texels that stay on a device from iteration to iteration.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "libcommon/device/device.h"
#include "patinate/simulation/material_atlas.h"

namespace patinate::simulation {

/// The text of amounts_device.cl.
extern const std::string_view kAmountEntries;

/// A plane of amounts for each material, in the order of texels; 2 bytes each. The atlas on the CPU has the same: tiles
/// that others have changed there are brought here before the device works, and those that the device has changed go
/// back after it.
class DeviceAmounts {
 public:
  /// @throws DeviceError, as all members but note_changes().
  DeviceAmounts(const device::Device& device, const MaterialAtlas& atlas);
  ~DeviceAmounts();

  /// These tiles have changed on the CPU.
  void note_changes(std::span<const TileIndex> tiles);
  /// Brings what was noted.
  void update(const MaterialAtlas& atlas);

  [[nodiscard]] const device::Buffer<std::uint16_t>& planes() const;
  /// Where in planes() a tile's 64 amounts are, in tiles.
  [[nodiscard]] std::int32_t tile_plane(std::int32_t material, TileIndex tile) const;
  /// By tile: a bit for each material of which a kernel has changed something since the last take().
  [[nodiscard]] const device::Buffer<std::uint32_t>& dirty() const;
  /// Waits for the device, and gives the atlas what has changed there. Nothing is changed if it throws.
  /// @param materials  Whose amounts are taken.
  /// @returns the tiles, rising; good until the next call.
  [[nodiscard]] std::span<const TileIndex> take(std::span<const int> materials, MaterialAtlas& atlas);
  /// The same of tiles that are known to have changed. @param changed  By tile: a bit for each of `materials`.
  void take_tiles(std::span<const TileIndex> tiles, std::span<const std::uint32_t> changed,
                  std::span<const int> materials, MaterialAtlas& atlas);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace patinate::simulation
