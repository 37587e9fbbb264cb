/// \file
/// What is copied again near by: an eye finds a mark that stands twice within a few centimeters, and a row of them at
/// once. Amounts (amounts.h) count copies on the whole surface, where a source smaller than it must repeat. Sources
/// with lines go without: they repeat less, and other pieces would break some of their lines (docs/benchmarks.md).
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/core/run_control.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/places.h"

namespace patinate::transfer {

/// Copies of the parts of a source in the squares of an atlas, each with the eight around it.
class NearbyUses {
 public:
  static constexpr std::int32_t kOneCopy = 256;  ///< 1 in fixed point.

  /// Counts nothing yet: copies() is 0.
  NearbyUses(const SourceLevel& source, const TexelMap& map);

  /// Between two calls counts stay as they are, so that order and threads do not matter.
  void measure(const PlaceMap& places, const RunControl& control);

  /// How often the 4 x 4 pixels around a pixel are shown within at least 64 texels of a texel, in copies that a surface
  /// of that size cannot avoid: [0, 4] in 1 / kOneCopy.
  [[nodiscard]] std::int32_t copies(TexelId texel, std::int32_t pixel) const {
    return copies_.empty() ? 0 : copies_[square_of(texel) * num_cells_ + cell_of(pixel)];
  }
  [[nodiscard]] bool is_one_cell(std::int32_t a, std::int32_t b) const { return cell_of(a) == cell_of(b); }

 private:
  /// Side of the cells in which copies are counted.
  static constexpr std::int32_t kCell_px = 4, kMaxCopies = 4 * kOneCopy;

  [[nodiscard]] std::size_t cell_of(std::int32_t pixel) const {
    return static_cast<std::size_t>(pixel / source_width_ / kCell_px * columns_ + pixel % source_width_ / kCell_px);
  }
  [[nodiscard]] std::size_t square_of(TexelId t) const {
    return static_cast<std::size_t>(t / width_ / side_ * squares_x_ + t % width_ / side_);
  }

  std::int32_t source_width_, columns_;
  std::size_t num_cells_;
  std::vector<std::int32_t> usable_in_;  ///< Pixels by cell.
  std::int64_t num_usable_;
  std::int64_t width_, height_;  ///< Size and height of the atlas.
  std::int64_t side_ = 64, squares_x_ = 0, squares_y_ = 0;
  std::vector<std::uint16_t> copies_;  ///< By square and cell; empty until measure().
};

}  // namespace patinate::transfer
