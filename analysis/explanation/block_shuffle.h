/// \file
/// What chance gives: a reference whose blocks have changed places.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "analysis/explanation/surface_blocks.h"
#include "patinate/core/run_control.h"

namespace patinate::analysis {

/// Ways to lay the content of one block over another. Each block is flattened onto the plane that it is widest in; a
/// place takes what lies at the same offset from the other block's middle, or nearest to it there. So the fine
/// structure of a reference stays, and where it lies does not.
class BlockShuffles {
 public:
  /// Cost: O(n^2) for n samples, memory 4 bytes x n x blocks. Same bits for any number of threads.
  BlockShuffles(std::span<const Vec3> positions_mm, const SurfaceBlocks& blocks, const RunControl& control = {});

  /// The sample that each sample takes its value from, when the blocks are permuted. The same for the same numbers.
  [[nodiscard]] std::vector<std::uint32_t> shuffled(std::uint64_t seed, std::uint64_t number) const;

 private:
  std::size_t num_samples_;
  std::vector<std::vector<std::uint32_t>> members_;
  std::vector<std::vector<std::uint32_t>> taken_;  ///< Taken places for block a from block b, at [a * blocks + b].
};

}  // namespace patinate::analysis
