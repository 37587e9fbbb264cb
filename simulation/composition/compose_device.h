/// \file
/// Composition on a device: the kernels of compose_kernel.inl, with the CPU's bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "libcommon/device/device.h"
#include "patinate/core/run_control.h"
#include "simulation/device/device_arrays.h"

namespace patinate::simulation {

struct ComposerParts;

namespace composition {

/// Composed textures, as the CPU keeps them.
struct Textures {
  std::vector<std::uint32_t>& codes;
  std::vector<std::int32_t>& heights;
  std::vector<std::uint8_t>& normals;
};

/// Everything that composition needs, and what it makes, in a device's memory.
class DeviceComposition {
 public:
  /// Codes, heights and normals are there as they are here.
  /// @throws DeviceError, as all members.
  DeviceComposition(const DeviceArrays& arrays, ComposerParts& parts, const Textures& textures,
                    const RunControl& control);
  ~DeviceComposition();

  /// Composes the tiles that are listed in `arrays`, and normals that their heights tell on.
  void compose(DeviceArrays& arrays);
  /// Those that the last compose() changed, rising.
  [[nodiscard]] std::vector<TileIndex> changed_tiles() const;
  /// Brings what has changed since the last bring_back(); nothing has changed here if it throws.
  void bring_back(const Textures& textures);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace composition

}  // namespace patinate::simulation
