/// \file
/// What a user should know of a scene that can be run as it is.
#pragma once

#include <string>
#include <vector>

#include "patinate/simulation/scene_io.h"

namespace patinate::simulation {

/// A sentence each: floating drops that leave the surface, events that come after the run's end, emitters whose speed
/// does not suit the objects' size, cargo that is never exchanged. @param mm_per_unit  Of the scene as it was written.
[[nodiscard]] std::vector<std::string> scene_notes(const SceneFile& file, double mm_per_unit);

}  // namespace patinate::simulation
