#include "transfer/synthesis/device_tables.h"

#include <algorithm>
#include <utility>

namespace patinate::transfer {

using device::Device;
using device::DeviceError;

AlikeOnDevice::AlikeOnDevice(const Device& device, const SourceLevel& source)
    : usable(device.upload(source.usable)),
      first_with(device.upload(source.first_with)),
      grid_cell(device.upload(source.grid_cell)),
      grid_begin(device.upload(source.grid_begin)),
      grid_pixels(device.upload(source.grid_pixels)) {}

NeighborsOnDevice::NeighborsOnDevice(const Device& device, const DestinationLevel& destination,
                                     const RunControl& control) {
  if (destination.map->num_texels() >= std::int64_t{1} << 31)
    throw DeviceError(device.info().name + ": an atlas of 2^31 texels is too large for it");
  const FlatNeighbors flat = destination.neighbors->flat(control);
  row = device.upload(flat.row);
  is_stored = device.upload(flat.is_stored);
  begin = device.upload(flat.begin);
  stored = device.upload(flat.stored);
  triangle = device.upload(destination.map->triangles());
  steps_of = device.upload(flat.steps_of);
  steps = device.upload(flat.steps);
}

PlacesOnDevice::PlacesOnDevice(const Device& device, const TexelMap& map)
    : device_(device),
      pixels_(device.allocate<std::int32_t>(static_cast<std::size_t>(map.num_texels()))),
      beside_(device.allocate<std::int8_t>(2 * static_cast<std::size_t>(map.num_texels()))) {}

void PlacesOnDevice::give(const PlaceMap& places) {
  if (are_there_) return;
  device_.write(std::span<const std::int32_t>(places.pixels), pixels_);
  device_.write(places.beside(), beside_);
}

void PlacesOnDevice::read() {
  read_pixels_.resize(pixels_.size());
  read_beside_.resize(beside_.size());
  device_.read(pixels_, std::span(read_pixels_));
  device_.read(beside_, std::span(read_beside_));
}

void PlacesOnDevice::take(PlaceMap& places) {
  std::swap(places.pixels, read_pixels_);
  std::copy(read_beside_.begin(), read_beside_.end(), places.beside().begin());
  are_there_ = true;
}

}  // namespace patinate::transfer
