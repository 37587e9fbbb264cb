/// \file
/// The part of an Exchanger that a device does.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "simulation/device/simulation_device.h"
#include "simulation/transport/device_exchange.h"
#include "simulation/transport/exchange.h"

namespace patinate::simulation {

/// Keeps amounts on the device from exchange to exchange, until something fails: the CPU goes on then.
class DeviceExchanger {
 public:
  /// @param device  Null: none.
  void use(std::shared_ptr<const SimulationDevice> device);
  [[nodiscard]] bool is_used() const { return device_ != nullptr && !device_->has_failed(); }
  void note_changes(std::span<const TileIndex> tiles);
  void forget_amounts() { amounts_.reset(); }
  /// Those of `atlas`, up to date; null where no device is used.
  [[nodiscard]] DeviceAmounts* amounts(const MaterialAtlas& atlas);

  /// @param of     Contacts in the order of gammatons, or endings, with at least one active material.
  /// @param width  Of a splat, in texels of median size; 0: contacts are of one texel.
  /// @param pieces  Cuts splats near seams, and trails.
  /// @returns nothing if the device could not do it, or has too much to tell parameter maps of; nothing was changed.
  [[nodiscard]] std::optional<ExchangeReport> exchange(const WideContacts& of, const ExchangeOptions& options,
                                                       double width, std::int64_t iteration, Pieces& pieces,
                                                       Cargo& cargo, MaterialAtlas& atlas, ParameterMaps* maps,
                                                       const RunControl& control);

 private:
  void fail(const device::DeviceError& error);
  [[nodiscard]] std::size_t num_pieces() const;
  void find_cut(const WideContacts& of, double width, Pieces& pieces, const RunControl& control);

  std::shared_ptr<const SimulationDevice> device_;
  std::unique_ptr<DeviceExchange> exchange_;
  std::unique_ptr<DeviceAmounts> amounts_;
  std::vector<std::uint16_t> sizes_;     ///< By contact.
  std::vector<std::uint32_t> cut_;       ///< By contact: its number among those that are cut, or kNotCut.
  std::vector<Contact> cut_contacts_;    ///< Those.
  std::vector<SplatPart> cut_parts_;     ///< One behind the other.
  std::vector<std::uint32_t> cut_from_;  ///< By number, and the end.
};

}  // namespace patinate::simulation
