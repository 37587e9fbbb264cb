/// \file
/// Poses of a relit capture from the registration.json that `register` wrote of its scans.
#pragma once

#include <filesystem>

#include "capture/project/relit_project.h"

namespace patinate::capture {

/// Gives every step with a scan and without a `transform` of its own the pose that the registration has of its scan,
/// in the frame of the project's reference step. Scans are found by their paths, else by their names.
/// @throws IoError naming the step whose scan the registration does not have, or could not place.
void apply_registration(const std::filesystem::path& file, RelitProject& project);

}  // namespace patinate::capture
