/// \file
/// The exact search of windows on a device: the kernels of window_kernel.inl, with the CPU's bytes.
///
/// A group of items searches a texel's window: all of its pixels, each by its control and projected neighborhood first
/// (neighborhood_projection.h), then those that may be good by their cost. Trees of blocks, which the CPU searches,
/// would make items of a group wait for one another.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/transfer/transfer.h"
#include "transfer/synthesis/audit.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/search_device.h"

namespace patinate::transfer {

/// Texels of the reference synthesis, front by front (wavefronts.h).
class ReferenceOnDevice {
 public:
  /// What `source` and what follows it say is as in synthesize_reference(). All but `fronts` must outlive this.
  /// @throws DeviceError if it has too little memory, or its driver does not compile the kernels.
  ReferenceOnDevice(const SearchDevice& device, const SourceLevel& source, const DestinationLevel& destination,
                    const Neighborhood& neighborhood, std::span<const std::vector<TexelId>> fronts, std::uint64_t seed,
                    const ReferenceOptions& options, const RunControl& control);
  ~ReferenceOnDevice();

  /// Fronts [first, last) of a pass. The first call takes the places that are given there; later ones go on from what
  /// the last one left, and must be given that.
  /// @throws DeviceError; `places` are then as they were. @throws Canceled within about 50 ms.
  void run(const EnergyScale& scale, int pass, std::size_t first, std::size_t last, PlaceMap& places,
           const RunControl& control);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Audits of single texels: nothing of the atlas but what they see is there. A device runs one at a time.
class AuditOnDevice {
 public:
  /// All must outlive this. @throws DeviceError as ReferenceOnDevice does.
  AuditOnDevice(const SearchDevice& device, const SynthesisLevel& level, const Neighborhood& neighborhood,
                const EnergyScale& scale, const RunControl& control);
  ~AuditOnDevice();

  /// What audit_texels() finds of them. @param texels  A few thousand, each with a usable pixel.
  /// @throws DeviceError. @throws Canceled within about 50 ms, or after one texel of a source of many million pixels.
  [[nodiscard]] std::vector<AuditedTexel> run(std::span<const TexelId> texels, const CoordinateMap& coordinates,
                                              const RunControl& control);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A small reference synthesis there and here, place by place, and its audit. @throws DeviceError if the device cannot
/// run it.
[[nodiscard]] device::CheckResult check_window_search(const device::Device& device);

}  // namespace patinate::transfer
