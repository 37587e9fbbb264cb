/// \file
/// What control maps take.
#pragma once

#include <string>

#include "libcommon/job/job.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/geometry/mesh.h"

namespace patinate::cli {

/// Of a kind, or of an expression: of all kinds in it. @param texels  Of the atlas.
[[nodiscard]] JobCost control_cost(const std::string& text, const Mesh& mesh, double texels,
                                   const ControlKindOptions& options);

}  // namespace patinate::cli
