/// \file
/// All that a finished simulation says of its surface.
#pragma once

#include <filesystem>

#include "patinate/core/run_control.h"
#include "patinate/output/render_surface.h"

namespace patinate::cli {

/// The maps of a simulation's end, over its atlas, gutters filled. Water is a film, not a color: color, gloss and
/// height are those of the dry surface, composed again without it. Metal is what the presets say is bare metal and
/// nothing covers. Heights are mm.
/// @param folder  That `simulate` made. @param film  Amount of water that wets a place through; > 0.
/// @throws IoError also if the scene in the folder is no longer the one that was run.
[[nodiscard]] SurfaceMaps simulated_maps(const std::filesystem::path& folder, double film, const RunControl& control);

}  // namespace patinate::cli
