/// \file
/// Composition on a device: the kernels of compose_kernel.inl, with the CPU's bytes.
#pragma once

#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "libcommon/device/arithmetic_check.h"
#include "libcommon/device/device.h"
#include "patinate/core/run_control.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/composition/height_frames.h"
#include "simulation/device/device_amounts.h"

namespace patinate::simulation {

namespace composition {

/// Tasks of some tiles with everything that they point to, in the pools that a device is given.
class PackedTiles {
 public:
  /// @param looks    Those that tasks point to, by material.
  /// @param amounts  Of the atlas on the device; null: amounts are packed, too.
  explicit PackedTiles(std::span<const QuantizedAppearance> looks, const DeviceAmounts* amounts = nullptr)
      : looks_(looks), amounts_(amounts) {}
  void add(const ComposeTask& task);
  void clear();
  [[nodiscard]] std::size_t size() const { return tasks_.size(); }

 private:
  friend class DeviceSurface;
  std::span<const QuantizedAppearance> looks_;
  const DeviceAmounts* amounts_;
  std::unordered_map<const std::uint16_t*, std::int32_t> originals_;  ///< Planes: most tiles of an object share one.
  std::vector<PackedTask> tasks_;
  std::vector<std::uint16_t> planes_, pictures_;
  std::vector<std::uint8_t> grains_;
  std::vector<BaseTile> bases_;
  std::vector<std::int32_t> heights_;
  // What the last task pointed to: neighbors often share it.
  const BaseTile* last_base_ = nullptr;
  const std::int32_t* last_height_ = nullptr;
};

/// What composition of one surface keeps on a device.
class DeviceSurface {
 public:
  /// @throws DeviceError, as all members.
  DeviceSurface(const device::Device& device, const SurfaceAtlas& surface, const HeightFrames& frames);
  ~DeviceSurface();
  /// 64 codes and heights of each tile.
  void compose(const PackedTiles& tiles, std::vector<std::uint32_t>& codes, std::vector<std::int32_t>& heights);
  /// Of the whole atlas, for normals().
  void set_heights(std::span<const std::int32_t> heights);
  /// 3 x 64 bytes of each tile.
  void normals(std::span<const TileIndex> tiles, std::vector<std::uint8_t>& normals);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace composition

/// A plate with relief, composed there and here. @throws DeviceError if the device cannot run it.
[[nodiscard]] device::CheckResult check_composition(const device::Device& device);

}  // namespace patinate::simulation
