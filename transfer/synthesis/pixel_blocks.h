/// \file
/// The usable pixels of a source in squares, tiles and blocks, laid out to be searched.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/core/run_control.h"
#include "transfer/synthesis/neighborhood_projection.h"
#include "transfer/synthesis/reach_kernel.h"
#include "transfer/synthesis/window_kernel.h"

namespace patinate::transfer {

/// Squares of 16 x 16 pixels, which keep their usable ones sorted by first control.
struct PixelSquares {
  static constexpr int kSide = 16;
  int squares_x = 0;                    ///< In a row.
  std::vector<std::int32_t> begin;      ///< By square, row by row, and the end of the last.
  std::vector<std::int32_t> pixels;     ///< By square, then by first control, then by index.
  std::vector<std::uint16_t> controls;  ///< Their first control.

  explicit PixelSquares(const SourceLevel& source);
};

/// Up to 64 pixels that look alike.
struct PixelBlock {
  static constexpr int kSize = 64;
  SearchWindow extent;                              ///< That holds all of them.
  std::uint16_t low_control = 0, high_control = 0;  ///< Least and greatest of their first control.
  std::int32_t
      begin = 0,
      end = 0;  ///< In PixelBlocks::pixels and controls; its groups begin at kSize / kGroupSize times its own index.
};

/// Up to 16 blocks: of a square of 32 x 32, or of pixels that look alike wherever they lie.
struct PixelTile {
  static constexpr int kSide = 32;
  SearchWindow extent;
  std::int32_t first_block = 0, last_block = 0;  ///< The last not included.
};

/// A k-d tree over projections and first control [Friedman, Bentley and Finkel 1977], of two levels.
struct PixelBlocks {
  std::vector<PixelTile> tiles;
  std::vector<ProjectedBoxes> boxes;  ///< Around the blocks of each tile. What is left of a tile's 16 means nothing.
  std::vector<PixelBlock> blocks;
  std::vector<std::int32_t> pixels;     ///< By block, then by first control, then by index.
  std::vector<std::uint16_t> controls;  ///< Their first control.
  std::vector<ProjectedGroup>
      groups;       ///< Their projections; four groups a block. What is left of a block's 64 means nothing.
  int tiles_x = 0;  ///< Tiles in a row of squares; 0 when tiles are not squares.

  enum class Tiles { Squares, Anywhere };
  [[nodiscard]] static PixelBlocks make(const SourceLevel& source, const NeighborhoodProjection& projection,
                                        Tiles tiles, const RunControl& control = {});
};

}  // namespace patinate::transfer
