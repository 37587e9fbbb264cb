/// \file
/// Costs that grow with something that is counted before the work.
#pragma once

#include "libcommon/job/job.h"

namespace patinate {

/// Of an item in a process of its own. Figures were measured in November 2026; docs/scaling.md says on what.
struct CostModel {
  double seconds = 0.03;      ///< Before the first: starting, and reading what is small.
  double unit_seconds = 0.0;  ///< Of each: a pixel, texel, triangle, ray.
  double megabytes = 25.0;
  double unit_bytes = 0.0;

  [[nodiscard]] JobCost of(double count = 0.0) const {
    return {.core_seconds = seconds + unit_seconds * count, .megabytes = megabytes + 1e-6 * unit_bytes * count};
  }
};

/// Of an item that reads and writes small files alone.
inline constexpr CostModel kSmallCost{};

}  // namespace patinate
