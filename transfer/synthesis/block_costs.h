/// \file
/// Where borders of copied pieces cost most, block by block.
#pragma once

#include <cstdint>
#include <vector>

#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/seam_cost.h"

namespace patinate::transfer {

/// Sums of seam costs in blocks of 8 x 8 texels of a level, row by row.
class BlockCosts {
 public:
  /// All must outlive this. @param beside  Neighbors, of which those beside a texel are looked at.
  BlockCosts(const DestinationLevel& destination, const TexelNeighborhood& beside, const SeamFeatures& features);

  [[nodiscard]] std::size_t size() const { return costs_.size(); }
  /// Of the pairs of texels in each block.
  void measure(const PlaceMap& places, const RunControl& control);
  /// Of the 3 x 3 blocks around one.
  [[nodiscard]] std::int64_t around(std::size_t block) const;
  /// A texel near the middle of a block; -1 = none.
  [[nodiscard]] TexelId texel_in(std::size_t block) const;

 private:
  [[nodiscard]] std::int64_t texel_cost(TexelId t, TexelNeighborhood::Cursor& cursor, const PlaceMap& places) const;

  const TexelMap& map_;
  const FrameTurns* turns_;
  const TexelNeighborhood& beside_;
  const SeamFeatures& features_;
  int columns_, rows_;
  std::vector<std::int64_t> costs_;
};

}  // namespace patinate::transfer
