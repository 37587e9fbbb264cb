/// \file
/// Passes of the fast synthesis on a device: the kernels of search_kernel.inl, with the CPU's bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "libcommon/device/arithmetic_check.h"
#include "libcommon/device/fallible_device.h"
#include "patinate/core/run_control.h"
#include "transfer/synthesis/energy.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/similar_pixels.h"

namespace patinate::transfer {

/// Parameters that differ from pass to pass.
struct DevicePass {
  search_kernel::Preferences factors;
  std::span<const std::uint8_t> reuse;   ///< By pixel; may be empty where nothing goes by it,
  std::span<const std::uint8_t> looks;   ///< as may looks by pixel
  std::span<const std::int32_t> excess;  ///< and kExcessCells x kExcessCells.
  int num_random = 0;
  std::uint64_t seed = 0;
  std::uint32_t stream = 0;
  bool is_whole = false;
  int first_turn = 0;  ///< First turn of the first of its sets.
};

/// A device for synthesis.
class SearchDevice : public device::FallibleDevice {
 public:
  using FallibleDevice::FallibleDevice;

  /// One level's tables in the device's memory.
  class Level {
   public:
    /// @throws DeviceError if it has too little memory, or its driver does not compile the kernels.
    Level(const SearchDevice& device, const SynthesisLevel& level, const Neighborhood& neighborhood,
          const SimilarPixels& similar, const EnergyScale& scale, const RunControl& control);
    ~Level();
    /// One pass over the interleaved sets. The first takes what is given there; later ones go on from what the last one
    /// left, and must be given that. @param changed_near  By texel: see search_kernel.inl.
    /// @throws DeviceError; what was given is then as it was. @throws Canceled within about 50 ms.
    void run(const DevicePass& pass, PlaceMap& places, std::span<std::uint8_t> changed_near, const RunControl& control);
    /// Input of measure_figures(): the texels of a map that passes have made, and whatever came after.
    /// @throws DeviceError, Canceled.
    [[nodiscard]] CostSums sum_costs(const EnergyScale& scale, const CoordinateMap& coordinates,
                                     const RunControl& control);

   private:
    struct State;
    std::unique_ptr<State> state_;
  };
};

/// A small synthesis there and here, place by place, and its energy. @throws DeviceError if the device cannot run it.
[[nodiscard]] device::CheckResult check_search(const device::Device& device);

}  // namespace patinate::transfer
