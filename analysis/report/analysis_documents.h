/// \file
/// The JSON Schemas of what analyses write.
#pragma once

#include "patinate/core/json.h"

namespace patinate::analysis {

[[nodiscard]] Json compare_schema();
[[nodiscard]] Json evaluation_schema();
[[nodiscard]] Json replicates_schema();

}  // namespace patinate::analysis
