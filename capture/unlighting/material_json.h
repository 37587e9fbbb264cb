/// \file
/// Materials as unlight.json has them. Inside of capture only.
#pragma once

#include <vector>

#include "patinate/capture/unlight.h"
#include "patinate/core/json.h"

namespace patinate::capture {

[[nodiscard]] Json to_json(const std::vector<SurfaceMaterial>& materials);

}  // namespace patinate::capture
