// What a Composer leaves to a device.
#include <algorithm>

#include "libcommon/core/parallel.h"
#include "patinate/simulation/compose.h"
#include "simulation/composition/compose_device.h"
#include "simulation/composition/composer_state.h"
#include "simulation/device/simulation_device.h"

namespace patinate::simulation {

using namespace composition;

namespace {

constexpr std::int64_t kChunk = 256;  // Tiles.
constexpr std::size_t kBatch =
    4096;  // Tiles: a launch of some milliseconds, and some tens of megabytes of what goes there.

}  // namespace

template <class Work>
bool Composer::State::worked_on_device(const Work& work) {
  if (device == nullptr || device->has_failed()) return false;
  try {
    if (on_device == nullptr) on_device = std::make_unique<DeviceSurface>(device->device(), *surface, frames);
    work();
    return true;
  } catch (const device::DeviceError& error) {
    device->report_failure(error);
    on_device.reset();
    device.reset();
    return false;
  }
}

bool Composer::State::composed_on_device(const MaterialAtlas& atlas, std::span<const TileIndex> tiles,
                                         const DeviceAmounts* amounts, const RunControl& control) {
  RunControl silent = control;
  silent.on_progress = nullptr;
  return worked_on_device([&] {
    PackedTiles packed(appearance, amounts);
    std::vector<std::uint32_t> new_codes;
    std::vector<std::int32_t> new_heights;
    std::vector<TileInput> inputs(std::min(kBatch, tiles.size()));
    for (std::size_t begin = 0; begin < tiles.size(); begin += kBatch) {
      control.throw_if_stopped();
      const std::span<const TileIndex> batch = tiles.subspan(begin, std::min(kBatch, tiles.size() - begin));
      packed.clear();
      // By all threads: grain is made when it is first asked for.
      parallel_for(static_cast<std::int64_t>(batch.size()), kChunk, silent, [&](std::int64_t first, std::int64_t end) {
        for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(end); ++i)
          prepare(atlas, batch[i], inputs[i]);
      });
      for (std::size_t i = 0; i < batch.size(); ++i) packed.add(inputs[i].task);
      on_device->compose(packed, new_codes, new_heights);
      for (std::size_t i = 0; i < batch.size(); ++i)
        take(batch[i], new_codes.data() + i * kTile, new_heights.data() + i * kTile);
      control.report(static_cast<double>(begin + batch.size()) / static_cast<double>(tiles.size()));
    }
  });
}

bool Composer::State::normals_on_device(std::span<const TileIndex> tiles, const RunControl& control) {
  return worked_on_device([&] {
    on_device->set_heights(heights);
    std::vector<std::uint8_t> found;
    for (std::size_t begin = 0; begin < tiles.size(); begin += kBatch) {
      control.throw_if_stopped();
      const std::span<const TileIndex> batch = tiles.subspan(begin, std::min(kBatch, tiles.size() - begin));
      on_device->normals(batch, found);
      for (std::size_t i = 0; i < batch.size(); ++i) take_normals(batch[i], found.data() + i * 3 * kTile);
    }
    control.report(1.0);
  });
}

}  // namespace patinate::simulation
