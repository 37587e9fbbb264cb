/// \file
/// Exchanges of whole iterations on a device, with the bytes of exchange.h.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "libcommon/core/kernel_language.h"
#include "simulation/device/device_arrays.h"
#include "simulation/transport/exchange.h"

namespace patinate::simulation {

/// exchange_types.inl for C++; devices read the same text.
namespace exchange_types {
using namespace kernel_types;
#include "simulation/transport/exchange_types.inl"
}  // namespace exchange_types
/// The texts of what it is compiled from.
extern const std::string_view kExchangeTypes, kSplatsThere, kWalksThere, kLayEntries, kTrailEntries, kExchangeEntries;

/// State that an exchange keeps on a device: how splats lie, room for their pieces, and parameter maps.
class DeviceExchange {
 public:
  /// @param choice  Maps that are kept. @throws DeviceError, as all members.
  DeviceExchange(const DeviceArrays& arrays, const SurfaceAtlas& surface, const ParameterMapChoice& choice);
  ~DeviceExchange();

  /// Rates, and how wide splats are: before the first exchange, and when one of them changes.
  void set(const ExchangeOptions& options, const SplatWidths& widths, double contact_area, std::uint64_t seed);
  /// Whether gammatons that end leave their cargo along their trails.
  [[nodiscard]] bool deposits() const;

  /// Exchanges at all contacts in `arrays`. @param time  Of random numbers, and of maps.
  void exchange(DeviceArrays& arrays, ExchangeTime time);
  /// Deposits at the endings of ways (0) or responses (1).
  void deposit(DeviceArrays& arrays, ExchangeTime time, std::uint32_t which);

  /// There was too little room (kHasOverflown): takes twice as much. Lists of texels are empty after it.
  void grow(std::uint32_t overflown);

  /// Parameter maps, there and back.
  void put_maps(const ParameterMaps& maps);
  /// @returns what gives them to `maps`, which must outlive it; it does not fail.
  [[nodiscard]] std::vector<std::function<void()>> read_maps(ParameterMaps& maps) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace patinate::simulation
