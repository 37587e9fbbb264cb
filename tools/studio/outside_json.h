/// \file
/// JSON that comes from a browser.
#pragma once

#include <string>

#include "patinate/core/json.h"

namespace patinate::studio {

/// At most 32 levels deep: what is made of it later may recurse. @throws InvalidInput if it is no JSON, deeper, or says
/// a key twice.
[[nodiscard]] Json parse_outside_json(const std::string& text);

}  // namespace patinate::studio
