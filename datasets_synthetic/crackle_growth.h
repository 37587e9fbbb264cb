/// \file
/// Growth of a crack network over a spacing field; the geometric half of crackle().
#pragma once

#include <vector>

#include "patinate/datasets/crackle.h"

namespace patinate::datasets {

/// Facts of the plate that the growth needs, all H x W.
struct CrackleField {
  ImageF spacing_px;    ///< Crack spacing that the local thickness asks for; > 0.
  ImageF unsteadiness;  ///< [0, 1]; 1 = cracks wander most.
  ImageF at_once;       ///< [0, 1]; 0 = cracks come one by one, 1 = at once.
};

/// Grows cracks until none fits any more; start times are left at 0, `onset` gets the time of each as a share of the
/// time that growth takes, [0, 1], never falling.
/// @param grain  See CrackleOptions.
[[nodiscard]] std::vector<Crack> grow_cracks(const CrackleField& field, double grain, std::uint64_t seed,
                                             std::vector<double>& onset, std::vector<std::array<int, 2>>& ends_on,
                                             const RunControl& control);

}  // namespace patinate::datasets
