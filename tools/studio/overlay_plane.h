/// \file
/// One quantity over a simulation's picture as bytes: the amount of a material, or a counter.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "simulation/engine.h"
#include "tools/studio/tile_planes.h"

namespace patinate {

/// 64 bytes a tile, in the order of ScreenTile; 255 = high(). A counter's top doubles when it is passed, so that most tiles stay as they are.
class OverlayPlane {
 public:
  /// @param name  A material, or a parameter map that the simulation keeps.
  /// @throws InvalidInput if it is neither.
  OverlayPlane(const std::string& name, const Simulation& simulation, const ScreenLayout& layout);

  [[nodiscard]] double high() const { return high_; }
  /// @returns tiles whose bytes have changed, in order.
  [[nodiscard]] std::vector<ScreenTile> update(const Simulation& simulation);
  /// After a restore: everything is looked at again.
  void forget() { seen_ = -1; }
  [[nodiscard]] std::span<const std::uint8_t> tile(ScreenTile tile) const { return {&bytes_[std::size_t{tile} * 64], 64}; }

 private:
  [[nodiscard]] std::vector<ScreenTile> write(std::span<const ScreenTile> tiles, const auto& value);

  std::string name_;
  const ScreenLayout* layout_;
  int material_ = -1;        ///< -1 = a counter.
  double high_ = 1.0;
  std::int64_t seen_ = -1;   ///< Tiles that changed in this iteration or later are not in it yet.
  std::vector<std::uint8_t> bytes_;
};

}  // namespace patinate
