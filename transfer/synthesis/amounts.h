/// \file
/// How much of what: pieces are chosen so that looks occur as often as in the source, among pixels of similar control
/// value [Kopf et al. 2007, "Solid texture synthesis from 2D exemplars", sec. 3.2].
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/places.h"

namespace patinate::transfer {

/// Compares what a map has of each look with what the source has.
class Amounts {
 public:
  static constexpr int kLooks = 16;   ///< Equal parts of the source, by the first component of its appearance.
  static constexpr int kValues = 16;  ///< Of the first control, equally wide.

  explicit Amounts(const SourceLevel& source);

  /// Counts what the map has. Between two calls prices stay as they are, so that order and threads do not matter.
  void measure(const DestinationLevel& destination, const PlaceMap& places, const RunControl& control);
  /// How much more than its share a pixel's look has among texels that ask for this: relative to the share, [-1, 2] in
  /// 1/256; 0 where the source has too little of such control values to tell.
  [[nodiscard]] std::int32_t excess(std::span<const std::uint16_t> target, std::int32_t pixel) const {
    return excess_[cell(value_of(target[0]), look_[static_cast<std::size_t>(pixel)])];
  }

 private:
  [[nodiscard]] static int value_of(std::uint16_t control) { return control * kValues / (kControlSteps + 1); }
  [[nodiscard]] static std::size_t cell(int value, int look) { return static_cast<std::size_t>(value * kLooks + look); }

  using Table = std::array<std::int64_t, kValues * kLooks>;
  Table wanted_{};  ///< Pixels of the source.
  std::array<std::int32_t, kValues * kLooks> excess_{};
  std::vector<std::uint8_t> look_;  ///< By pixel.
};

}  // namespace patinate::transfer
