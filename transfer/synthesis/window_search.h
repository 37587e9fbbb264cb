/// \file
/// The source pixel of least cost in a window, without looking at every one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "transfer/synthesis/energy.h"

namespace patinate {

/// Pixels [x0, x1) x [y0, y1).
struct SearchWindow {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// What a search found.
struct WindowOptimum {
  std::int32_t pixel = -1;  ///< Of least cost; the first in row order among equals; -1 when the window holds no usable pixel.
  std::int64_t cost = 0;
};

/// Exact search of windows [Efros and Leung 1999], pruned: what a few likely pixels cost bounds all others; squares of 16 x 16 pixels keep theirs sorted by
/// the first control, so that only those are looked at whose control alone is below the bound; and of those a cost is given up as soon as its nearest
/// neighbours pass it. Thread-safe.
class WindowSearch {
 public:
  explicit WindowSearch(const SourceLevel& source);

  /// The window of `side` pixels around a place, moved into the source.
  [[nodiscard]] SearchWindow window(std::int64_t x, std::int64_t y, int side) const;
  /// @param cost  prepare()d. @param likely  Pixels that may be good, in the window or not; any order, may repeat; -1 is skipped.
  [[nodiscard]] WindowOptimum find(const TexelCost& cost, const SearchWindow& window, std::span<const std::int32_t> likely) const;
  /// The same by looking at every pixel: the oracle.
  [[nodiscard]] WindowOptimum find_exhaustively(const TexelCost& cost, const SearchWindow& window) const;

 private:
  static constexpr int kSquare = 16;
  const SourceLevel& source_;
  int squares_x_ = 0;
  std::vector<std::int32_t> begin_;      ///< By square, and the end of the last.
  std::vector<std::int32_t> pixels_;     ///< By square, then by first control, then by index.
  std::vector<std::uint16_t> controls_;  ///< Their first control.
};

}  // namespace patinate
