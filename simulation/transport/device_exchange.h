/// \file
/// An exchange on a device: what region_exchange.h does on the CPU, with its bytes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "libcommon/core/kernel_language.h"
#include "libcommon/device/arithmetic_check.h"
#include "libcommon/device/device.h"
#include "simulation/device/device_amounts.h"
#include "simulation/transport/parameter_maps.h"
#include "simulation/transport/pieces.h"

namespace patinate::simulation {

/// exchange_types.inl for C++; devices read the same text.
namespace exchange_types {
using namespace kernel_types;
#include "simulation/transport/exchange_types.inl"
}  // namespace exchange_types
/// The texts of what it is compiled from.
extern const std::string_view kExchangeTypes, kExchangeEntries;

inline constexpr std::uint32_t kNotCut = 0xFFFFFFFFu;

/// Contacts in the order of gammatons, or endings, and what is known of their splats.
struct DeviceContacts {
  exchange_types::ExchangeCall call = {};        ///< All but materials and the size of the atlas.
  std::span<const int> active = {};              ///< Materials, at least one.
  std::span<const Contact> contacts = {};        ///< Each gammaton at most once, rising.
  std::span<const std::uint16_t> sizes = {};     ///< By contact: of its splat (SplatShape).
  std::span<const std::uint32_t> cut = {};       ///< By contact: its number among those whose parts follow, or kNotCut.
  std::span<const SplatPart> cut_parts = {};     ///< One splat behind the other.
  std::span<const std::uint32_t> cut_from = {};  ///< By number: where its parts begin; and the end.
};

/// What an exchange has done.
struct DeviceExchangeReport {
  std::span<const TileIndex> dirty_tiles;             ///< Rising; good until the next exchange.
  std::array<std::int64_t, kMaxMaterials> dropped{};  ///< Mass, by material.
  std::array<std::int64_t, kMaxMaterials> picked_up{};
};

/// What an exchange keeps on a device.
class DeviceExchange {
 public:
  /// @throws DeviceError, as all members.
  DeviceExchange(const device::Device& device, const SurfaceAtlas& surface);
  ~DeviceExchange();

  /// Exchanges as the CPU does. What is here changes once all is done there: nothing has if it throws.
  /// @param amounts  On the same device, of `atlas`.
  /// @param maps     Recorded too, unless null.
  DeviceExchangeReport exchange(const DeviceContacts& contacts, std::int64_t iteration, DeviceAmounts& amounts,
                                MaterialAtlas& atlas, Cargo& cargo, ParameterMaps* maps);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Some 8,000 contacts and endings on a plate with seams, one texel wide to hundreds, exchanged there and here. @throws
/// DeviceError if the device cannot run it.
[[nodiscard]] device::CheckResult check_exchange(const device::Device& device);

}  // namespace patinate::simulation
