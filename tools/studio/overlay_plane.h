/// \file
/// One quantity over a simulation's picture as bytes: the amount of a material, or a counter.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "patinate/simulation/engine.h"
#include "tools/studio/tile_planes.h"

namespace patinate::studio {

/// Range that colors should span: of the texels where there is something, 2 % lie above `high`. Three digits.
struct OverlayRange {
  double low = 0.0;   ///< 0, unless 98 % of those texels lie in a narrow band: then the same share lies below.
  double high = 0.0;  ///< 0: there is nothing anywhere.
  double most = 0.0;
  friend bool operator==(const OverlayRange&, const OverlayRange&) = default;
};

/// 64 bytes a tile, in the order of ScreenTile. Byte b stands for high() (b / 255)^2: steps are fine where values are
/// small. high() is a power of two; it doubles when it is passed and halves when all is far below, so that most tiles
/// stay as they are.
class OverlayPlane {
 public:
  /// @param name  A material, or a parameter map that the simulation keeps.
  /// @throws InvalidInput if it is neither.
  OverlayPlane(const std::string& name, const simulation::Simulation& simulation, const ScreenLayout& layout);

  [[nodiscard]] double high() const { return high_; }
  /// Range of the last measure().
  [[nodiscard]] const OverlayRange& range() const { return range_; }
  /// @returns tiles whose bytes have changed, in order.
  [[nodiscard]] std::vector<ScreenTile> update(const simulation::Simulation& simulation);
  /// Whether bytes have changed since measure().
  [[nodiscard]] bool is_stale() const { return is_stale_; }
  /// Looks at every texel. @returns whether the range is another one now.
  bool measure(const simulation::Simulation& simulation);
  /// After a restore: everything is looked at again.
  void forget() { seen_ = -1; }
  [[nodiscard]] std::span<const std::uint8_t> tile(ScreenTile tile) const {
    return {&bytes_[std::size_t{tile} * 64], 64};
  }

 private:
  [[nodiscard]] std::vector<ScreenTile> write(std::span<const ScreenTile> tiles, const auto& value);
  [[nodiscard]] double most_of(const simulation::Simulation& simulation,
                               const std::function<double(simulation::TexelIndex)>& value) const;
  [[nodiscard]] std::function<double(simulation::TexelIndex)> values_of(const simulation::Simulation& simulation) const;

  std::string name_;
  const ScreenLayout* layout_;
  int material_ = -1;  ///< -1 = a counter.
  double high_ = 1.0;
  OverlayRange range_;
  bool is_stale_ = true;
  std::int64_t seen_ = -1;       ///< Tiles that changed in this iteration or later are not in it yet.
  std::int64_t seen_steps_ = 0;  ///< Seen steps of the brush, then.
  std::vector<std::uint8_t> bytes_;
};

}  // namespace patinate::studio
