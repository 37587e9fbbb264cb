#include "simulation/device/device_amounts.h"

#include <algorithm>
#include <array>

namespace patinate::simulation {

using device::Buffer;
using device::Device;

namespace {

constexpr std::size_t kTile = TileGrid::kTileTexels;
constexpr std::size_t kBatch = std::size_t{1} << 16;  // Tiles of one launch, which stays short.

device::Program build(const Device& device) {
  const std::array<std::string_view, 1> sources{kAmountEntries};
  return device.build("amounts", sources);
}

}  // namespace

DeviceAmounts::DeviceAmounts(const Device& device)
    : program_(build(device)), gather_(program_.kernel("gather_tiles")), scatter_(program_.kernel("scatter_tiles")) {}

void DeviceAmounts::put(const MaterialAtlas& atlas, std::span<const TileIndex> tiles, DeviceArrays& arrays) {
  const std::size_t num_materials = arrays.num_materials;
  for (std::size_t begin = 0; begin < tiles.size(); begin += kBatch) {
    const std::span<const TileIndex> batch = tiles.subspan(begin, std::min(kBatch, tiles.size() - begin));
    values_.resize(batch.size() * num_materials * kTile);
    std::uint16_t* out = values_.data();
    for (const TileIndex t : batch) {
      for (std::size_t m = 0; m < num_materials; ++m, out += kTile)
        atlas.read_tile(static_cast<int>(m), t, std::span<std::uint16_t, kTile>(out, kTile));
    }
    scatter_.run({.num = values_.size(), .group = kTile}, arrays.num_texels, arrays.num_materials,
                 arrays.device.upload(batch), arrays.device.upload(values_), arrays.amounts);
  }
}

void DeviceAmounts::read_dirty(const DeviceArrays& arrays) {
  const Device& device = arrays.device;
  std::vector<std::uint32_t> dirty(arrays.num_tiles);
  device.read(arrays.dirty, std::span(dirty));
  tiles_.clear();
  changed_.clear();
  for (TileIndex t = 0; t < dirty.size(); ++t) {
    if (dirty[t] == 0) continue;
    tiles_.push_back(t);
    changed_.push_back(dirty[t]);
  }
  const std::size_t each = arrays.num_materials * kTile;
  values_.resize(tiles_.size() * each);
  if (tiles_.empty()) return;
  const Buffer<std::uint16_t> room = device.allocate<std::uint16_t>(std::min(kBatch, tiles_.size()) * each);
  for (std::size_t begin = 0; begin < tiles_.size(); begin += kBatch) {
    const std::span<const TileIndex> batch =
        std::span(tiles_).subspan(begin, std::min(kBatch, tiles_.size() - begin));
    gather_.run({.num = batch.size() * each, .group = kTile}, arrays.num_texels, arrays.num_materials,
                device.upload(batch), arrays.amounts, room);
    device.read(room, std::span(values_).subspan(begin * each, batch.size() * each));
  }
}

void DeviceAmounts::give(MaterialAtlas& atlas) const {
  const std::uint16_t* from = values_.data();
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    for (int m = 0; m < atlas.num_materials(); ++m, from += kTile) {
      // A page is made where something in it has changed, if only back and forth, as the CPU makes it.
      if ((changed_[i] >> m & 1U) != 0) std::copy_n(from, kTile, atlas.writable_tile(m, tiles_[i]).begin());
    }
  }
}

}  // namespace patinate::simulation
