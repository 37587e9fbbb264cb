/// \file
/// Junctions of a crack network where the paint is thin; the second half of the growth of crackle().
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datasets_synthetic/crackle_growth.h"

namespace patinate::datasets {

/// Turns T junctions into Y junctions as far as cracks come at once there (field.at_once): nodes move to where the
/// pulls of the cracks that meet in them balance (three equal pulls do so at 120 degrees), against a spring to where
/// they were; cracks between nodes become wavy chords. Where cracks come one by one, not a point moves.
/// @param ends_on  For every crack the two cracks that its ends lie on, -1 = the border: that of the last point, then
/// that of the first.
void relax_junctions(const CrackleField& field, std::uint64_t seed, const std::vector<std::array<int, 2>>& ends_on,
                     std::vector<Crack>& cracks);

}  // namespace patinate::datasets
