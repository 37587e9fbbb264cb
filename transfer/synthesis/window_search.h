/// \file
/// The source pixel of least cost in a window, without looking at every one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "transfer/synthesis/energy.h"
#include "transfer/synthesis/pixel_blocks.h"

namespace patinate::transfer {

/// Result of a search.
struct WindowOptimum {
  std::int32_t pixel =
      -1;  ///< Pixel of least cost; the first in row order among equals; -1 when the window holds no usable pixel.
  std::int64_t cost = 0;
};

/// Exact search of windows [Efros and Leung 1999], pruned: what a few likely pixels cost bounds all others, and only
/// those are looked at whose control and projected neighborhood (neighborhood_projection.h) alone stay within the
/// bound: tiles, blocks, then pixels [Fukunaga and Narendra 1975]. Where only some quarters of a texel's neighborhood
/// are known in place, their projections count; where those hold too little of what is known, control alone. A cost is
/// given up as soon as its nearest neighbors pass the bound. Thread-safe; about 90 bytes a usable pixel.
class WindowSearch {
 public:
  /// @param side  Of most windows: from half of the source on, pixels are kept by what they look like, else by where
  /// they are. Any window can be searched.
  WindowSearch(const SourceLevel& source, const Neighborhood& neighborhood, int side, const RunControl& control = {});

  /// The window of `side` pixels around a place, moved into the source.
  [[nodiscard]] SearchWindow window(std::int64_t x, std::int64_t y, int side) const;
  /// @param cost  prepare()d. @param likely  Pixels that may be good, in the window or not; any order, may repeat; -1
  /// is skipped.
  [[nodiscard]] WindowOptimum find(const TexelCost& cost, const SearchWindow& window,
                                   std::span<const std::int32_t> likely) const;
  /// All pixels of the window that cost at most `bound`, ascending: [Efros and Leung 1999] choose among them.
  [[nodiscard]] std::vector<std::int32_t> find_within(const TexelCost& cost, const SearchWindow& window,
                                                      std::int64_t bound) const;
  /// find() by looking at every pixel: the oracle.
  [[nodiscard]] WindowOptimum find_exhaustively(const TexelCost& cost, const SearchWindow& window) const;

 private:
  struct Best;
  class Query;
  struct Table {
    NeighborhoodProjection projection;
    PixelBlocks blocks;
  };
  [[nodiscard]] Table make_table(const Neighborhood& neighborhood, NeighborhoodProjection::Parts parts, int side,
                                 const RunControl& control) const;
  void search(const TexelCost& cost, const SearchWindow& window, Best& best) const;
  void search_by_control(const TexelCost& cost, const SearchWindow& window, Best& best) const;
  void search_by_projection(const Table& table, const TexelCost& cost, unsigned quarters, const SearchWindow& window,
                            Best& best) const;
  [[nodiscard]] bool is_in(const SearchWindow& window, std::int32_t pixel) const;

  const SourceLevel& source_;
  PixelSquares squares_;
  Table whole_, quarters_;
  std::size_t num_appearances_;  ///< Number of appearances of a neighborhood.
  const ReachKernel& kernel_;
};

}  // namespace patinate::transfer
