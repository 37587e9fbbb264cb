/// \file
/// One event of a scene's "events", for those who steer a running simulation.
#pragma once

#include "patinate/core/json.h"
#include "patinate/simulation/scene.h"

namespace patinate::simulation {

/// Reads an element of a scene file's "events", with all checks that a scene file gets. What is recorded and what
/// happens is so the same to the last bit.
/// @param mm_per_unit  Of the file's lengths. @throws InvalidInput
[[nodiscard]] SceneEvent parse_event(const Json& event_of_file, const Scene& scene, double mm_per_unit);

}  // namespace patinate::simulation
