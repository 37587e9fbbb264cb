/// \file
/// How much of what: pieces are chosen so that looks occur as often as in the source, among pixels of similar control
/// value [Kopf et al. 2007, "Solid texture synthesis from 2D exemplars", sec. 3.2].
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/places.h"

namespace patinate::transfer {

/// Texels that a thread counts at a time into a table of its own: many more than the table has cells, which are added
/// up afterwards.
[[nodiscard]] constexpr std::int64_t texels_a_count(std::size_t num_cells) {
  return std::max<std::int64_t>(16384, 8 * static_cast<std::int64_t>(num_cells));
}

/// Compares what a map has of each look with what the source has.
class Amounts {
 public:
  static constexpr int kLooks = 16;   ///< Equal parts of the source, by the first component of its appearance.
  static constexpr int kValues = 16;  ///< Values of the first control, equally wide.
  static_assert(kLooks == search_kernel::kExcessCells && kValues == search_kernel::kExcessCells);

  using Table = std::array<std::int64_t, kValues * kLooks>;
  /// Counts of a map, or a part of one: those of all parts add up.
  struct Counts {
    Table has{};                     ///< Texels by value and look.
    std::vector<std::int64_t> uses;  ///< By cell of the source.
    std::int64_t num_texels = 0;
    void add(const Counts& part);
  };

  explicit Amounts(const SourceLevel& source);

  /// Counts what the map has. Between two calls prices stay as they are, so that order and threads do not matter.
  void measure(const DestinationLevel& destination, const PlaceMap& places, const RunControl& control);
  /// Counts in two steps.
  [[nodiscard]] Counts count(const DestinationLevel& destination, const PlaceMap& places,
                             const RunControl& control) const;
  void set(const Counts& counts);
  /// How much more than its share a pixel's look has among texels that ask for this: relative to the share, [-1, 2] in
  /// 1/256; 0 where the source has too little of such control values to tell.
  [[nodiscard]] std::int32_t excess(std::span<const std::uint16_t> target, std::int32_t pixel) const {
    return excess_[cell(value_of(target[0]), look_[pixel])];
  }
  /// Cost of a pixel's look for texels that ask for this, in 1/256: excess() and twice all that was measured before, so
  /// that what stays wrong becomes dearer from round to round until it is right. [-8, 8]
  [[nodiscard]] std::int32_t price(std::span<const std::uint16_t> target, std::int32_t pixel) const {
    return price_[cell(value_of(target[0]), look_[pixel])];
  }
  /// For kernels: looks by pixel, and excess by value of the control and look.
  [[nodiscard]] const std::vector<std::uint8_t>& looks() const { return look_; }
  [[nodiscard]] std::span<const std::int32_t> excess() const { return excess_; }
  /// How much more than its share the 8 x 8 pixels around a pixel are used, anywhere on the surface: relative to the
  /// share, or to one copy where that is more, [0, 3] in 1/256. Pieces that repeat are dear at any distance.
  [[nodiscard]] std::int32_t reuse(std::int32_t pixel) const { return reuse_[cell_of(pixel)]; }

 private:
  [[nodiscard]] static int value_of(std::uint16_t control) { return control * kValues / (kControlSteps + 1); }
  static constexpr int kCell_px = 8;  ///< Side of the cells in which uses of the source are counted.
  [[nodiscard]] std::int32_t cell_of(std::int32_t pixel) const {
    return pixel / width_ / kCell_px * columns_ + pixel % width_ / kCell_px;
  }
  [[nodiscard]] static std::size_t cell(int value, int look) { return static_cast<std::size_t>(value * kLooks + look); }

  void set_reuse(const Counts& counts);

  Table wanted_{};  ///< Pixels of the source.
  std::array<std::int32_t, kValues * kLooks> excess_{}, before_{}, price_{};
  std::vector<std::uint8_t> look_;  ///< By pixel.
  std::int32_t width_ = 0, columns_ = 0;
  std::vector<std::int32_t> usable_in_, reuse_;  ///< By cell.
};

}  // namespace patinate::transfer
