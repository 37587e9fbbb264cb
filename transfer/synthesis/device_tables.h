/// \file
/// What several searches of a device read and write, in its memory.
#pragma once

#include <cstdint>

#include "libcommon/device/device.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/places.h"

namespace patinate::transfer {

/// Usable pixels by control value: AlikeTables' arrays.
struct AlikeOnDevice {
  device::Buffer<std::int32_t> usable, first_with, grid_cell, grid_begin, grid_pixels;
  AlikeOnDevice(const device::Device& device, const SourceLevel& source);
};

/// The neighbors of all texels of a level: NeighborTables' arrays.
struct NeighborsOnDevice {
  device::Buffer<std::int32_t> row;
  device::Buffer<std::uint64_t> is_stored;
  device::Buffer<std::uint32_t> begin;
  device::Buffer<neighbor_kernel::PackedNeighbor> stored;
  device::Buffer<std::int32_t> triangle, steps_of;
  device::Buffer<neighbor_kernel::PackedNeighbor> steps;
  /// @throws DeviceError if the atlas has 2^31 texels or more.
  NeighborsOnDevice(const device::Device& device, const DestinationLevel& destination, const RunControl& control);
};

/// The places of all texels, which stay there from one call to the next.
class PlacesOnDevice {
 public:
  PlacesOnDevice(const device::Device& device, const TexelMap& map);
  [[nodiscard]] const device::Buffer<std::int32_t>& pixels() const { return pixels_; }
  [[nodiscard]] const device::Buffer<std::int8_t>& beside() const { return beside_; }
  [[nodiscard]] bool are_there() const { return are_there_; }
  /// Unless they are there already, as the last take() left them.
  void give(const PlaceMap& places);
  /// Reads them into room of its own, ...
  void read();
  /// ... and hands them over. In two steps, so that a device that is lost leaves what was given.
  void take(PlaceMap& places);

 private:
  device::Device device_;
  device::Buffer<std::int32_t> pixels_;
  device::Buffer<std::int8_t> beside_;
  bool are_there_ = false;
  CoordinateMap read_pixels_;
  std::vector<std::int8_t> read_beside_;
};

}  // namespace patinate::transfer
