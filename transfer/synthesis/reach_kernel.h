/// \file
/// How far many projected neighborhoods are from one, for one instruction set; reach_kernel.inc, compiled three times.
#pragma once

#include <cstdint>

namespace patinate::transfer {

inline constexpr int kGroupSize = 16;

/// 16 projected neighborhoods of 16 values: two values of all, then the next two of all.
struct alignas(64) ProjectedGroup {
  std::int16_t values[8][kGroupSize][2];
};

/// 16 boxes around projected neighborhoods: from low to high, both included.
struct ProjectedBoxes {
  ProjectedGroup low, high;
};

/// Squared distances from `query`, of the values whose `counts` are -1 (others 0). All differences fit 16 bits, their
/// squares in sum 31.
struct ReachKernel {
  /// For group g and neighborhood i of it: bit i of masks[g] says whether its squared distance is at most `limit`;
  /// where it is, distances[16 g + i] is that. @param distances  Aligned to 64 bytes.
  void (*points)(const ProjectedGroup* groups, int num_groups, const std::int16_t* query, const std::int16_t* counts,
                 std::int32_t limit, std::int32_t* distances, std::uint16_t* masks);
  /// Tests the nearest place in each of 16 boxes. @returns the mask.
  std::uint16_t (*boxes)(const ProjectedBoxes* boxes, const std::int16_t* query, const std::int16_t* counts,
                         std::int32_t limit, std::int32_t* distances);
};

namespace reach_baseline {
extern const ReachKernel kKernel;
}
namespace reach_avx2 {
extern const ReachKernel kKernel;
}
namespace reach_avx512 {
extern const ReachKernel kKernel;
}

}  // namespace patinate::transfer
