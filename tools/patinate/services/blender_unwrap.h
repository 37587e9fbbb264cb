/// \file
/// UVs by Blender's Smart UV Project, where Blender is installed. It runs as a child process, without a window.
#pragma once

#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"

namespace patinate::cli {

/// The mesh with UVs in [0, 1] that `blender`, found on the PATH, makes; existing ones are replaced. Charts lie two
/// texels apart at `resolution` x `resolution` texels, as far as Blender keeps to that. Positions and triangles stay as
/// they are.
/// @throws CannotComplete in one line if Blender is not installed, fails, takes more than ten minutes, or returns
/// another mesh.
/// @throws Canceled within 50 ms of a stop; Blender is ended then.
[[nodiscard]] Mesh blender_unwrap(Mesh mesh, int resolution, const RunControl& control = {});

}  // namespace patinate::cli
