/// \file
/// An outcome as `simulation.json` has it.
#pragma once

#include <vector>

#include "libcommon/document/document.h"
#include "simulation/job/outcome.h"

namespace patinate::simulation {

/// Members `objects` (by name) and `advice`; figures of four digits. A reader checks them alone.
void describe_outcome(DocumentVisitor& v, const std::vector<ObjectOutcome>& outcome);
/// The same as an object.
[[nodiscard]] Json outcome_json(const std::vector<ObjectOutcome>& outcome);

}  // namespace patinate::simulation
