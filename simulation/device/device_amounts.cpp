#include "simulation/device/device_amounts.h"

#include <algorithm>
#include <numeric>

namespace patinate::simulation {

using device::Buffer;
using device::Device;

namespace {

constexpr std::size_t kTile = TileGrid::kTileTexels;
constexpr std::size_t kBatch = 8192;  // Tiles of one launch, which stays short.

device::Program build(const Device& device) {
  const std::array<std::string_view, 1> sources{kAmountEntries};
  return device.build("amounts", sources);
}

}  // namespace

struct DeviceAmounts::State {
  State(const Device& its_device, const MaterialAtlas& atlas)
      : device(its_device),
        program(build(device)),
        gather(program.kernel("gather_tiles")),
        scatter(program.kernel("scatter_tiles")),
        num_texels(atlas.surface().grid().num_texels()),
        planes(device.allocate<std::uint16_t>(static_cast<std::size_t>(atlas.num_materials()) * num_texels)),
        dirty(device.allocate<std::uint32_t>(num_texels / kTile)),
        is_noted(num_texels / kTile, false),
        flags(num_texels / kTile) {
    device.fill_zero(dirty.memory());
    all_materials.resize(static_cast<std::size_t>(atlas.num_materials()));
    std::iota(all_materials.begin(), all_materials.end(), 0);
    noted.resize(num_texels / kTile);
    std::iota(noted.begin(), noted.end(), TileIndex{0});
    is_noted.assign(is_noted.size(), true);
  }

  [[nodiscard]] Buffer<std::uint32_t> numbers(std::span<const int> materials) const {
    const std::vector<std::uint32_t> list(materials.begin(), materials.end());
    return device.upload(list);
  }

  Device device;
  device::Program program;
  device::Kernel gather, scatter;
  std::uint32_t num_texels;
  Buffer<std::uint16_t> planes;
  Buffer<std::uint32_t> dirty;
  std::vector<int> all_materials;
  std::vector<TileIndex> noted;  ///< Those of is_noted.
  std::vector<bool> is_noted;
  std::vector<std::uint32_t> flags;
  std::vector<TileIndex> changed;
  std::vector<std::uint32_t> bits;  ///< By changed tile: of the materials that are taken.
  std::vector<std::uint16_t> values;
};

DeviceAmounts::DeviceAmounts(const Device& device, const MaterialAtlas& atlas)
    : state_(std::make_unique<State>(device, atlas)) {}
DeviceAmounts::~DeviceAmounts() = default;

const Buffer<std::uint16_t>& DeviceAmounts::planes() const { return state_->planes; }
std::int32_t DeviceAmounts::tile_plane(std::int32_t material, TileIndex tile) const {
  return material * static_cast<std::int32_t>(state_->num_texels / kTile) + static_cast<std::int32_t>(tile);
}
const Buffer<std::uint32_t>& DeviceAmounts::dirty() const { return state_->dirty; }

void DeviceAmounts::note_changes(std::span<const TileIndex> tiles) {
  State& s = *state_;
  for (const TileIndex t : tiles) {
    if (s.is_noted[t]) continue;
    s.is_noted[t] = true;
    s.noted.push_back(t);
  }
}

void DeviceAmounts::update(const MaterialAtlas& atlas) {
  State& s = *state_;
  const std::size_t num_materials = s.all_materials.size();
  const Buffer<std::uint32_t> materials = s.noted.empty() ? Buffer<std::uint32_t>() : s.numbers(s.all_materials);
  for (std::size_t begin = 0; begin < s.noted.size(); begin += kBatch) {
    const std::span<const TileIndex> batch =
        std::span(s.noted).subspan(begin, std::min(kBatch, s.noted.size() - begin));
    s.values.resize(batch.size() * num_materials * kTile);
    std::uint16_t* out = s.values.data();
    for (const TileIndex t : batch) {
      for (std::size_t m = 0; m < num_materials; ++m, out += kTile)
        atlas.read_tile(static_cast<int>(m), t, std::span<std::uint16_t, kTile>(out, kTile));
    }
    s.scatter.run({.num = s.values.size(), .group = kTile}, s.num_texels, static_cast<std::uint32_t>(num_materials),
                  materials, s.device.upload(batch), s.device.upload(s.values), s.planes);
  }
  for (const TileIndex t : s.noted) s.is_noted[t] = false;
  s.noted.clear();
}

std::span<const TileIndex> DeviceAmounts::take(std::span<const int> materials, MaterialAtlas& atlas) {
  State& s = *state_;
  s.device.read(s.dirty, std::span(s.flags));
  s.changed.clear();
  s.bits.clear();
  for (TileIndex t = 0; t < s.flags.size(); ++t) {
    if (s.flags[t] == 0) continue;
    s.changed.push_back(t);
    std::uint32_t& bits = s.bits.emplace_back(0);
    for (std::size_t k = 0; k < materials.size(); ++k) bits |= (s.flags[t] >> materials[k] & 1U) << k;
  }
  if (!s.changed.empty()) s.device.fill_zero(s.dirty.memory());
  take_tiles(s.changed, s.bits, materials, atlas);
  return s.changed;
}

void DeviceAmounts::take_tiles(std::span<const TileIndex> tiles, std::span<const std::uint32_t> changed,
                               std::span<const int> materials, MaterialAtlas& atlas) {
  State& s = *state_;
  if (tiles.empty()) return;
  const std::size_t each = materials.size() * kTile;
  s.values.resize(tiles.size() * each);
  const Buffer<std::uint32_t> planes = s.numbers(materials);
  const Buffer<std::uint16_t> values = s.device.allocate<std::uint16_t>(std::min(kBatch, tiles.size()) * each);
  for (std::size_t begin = 0; begin < tiles.size(); begin += kBatch) {
    const std::span<const TileIndex> batch = tiles.subspan(begin, std::min(kBatch, tiles.size() - begin));
    s.gather.run({.num = batch.size() * each, .group = kTile}, s.num_texels,
                 static_cast<std::uint32_t>(materials.size()), planes, s.device.upload(batch), s.planes, values);
    s.device.read(values, std::span(s.values).subspan(begin * each, batch.size() * each));
  }
  const std::uint16_t* from = s.values.data();
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t k = 0; k < materials.size(); ++k, from += kTile) {
      // A page is made where something in it has changed, if only back and forth, as the CPU makes it.
      if ((changed[i] >> k & 1U) != 0) std::copy_n(from, kTile, atlas.writable_tile(materials[k], tiles[i]).begin());
    }
  }
}

}  // namespace patinate::simulation
