/// \file
/// An outcome as `simulation.json` has it.
#pragma once

#include <vector>

#include "patinate/core/json.h"
#include "simulation/job/outcome.h"

namespace patinate::simulation {

/// Members `objects` (by name) and `advice`; figures of four digits.
[[nodiscard]] Json outcome_json(const std::vector<ObjectOutcome>& outcome);

}  // namespace patinate::simulation
