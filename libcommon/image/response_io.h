/// \file
/// How integer codes become linear values, as our JSON files say it.
#pragma once

#include "patinate/core/json.h"
#include "patinate/image/color.h"

namespace patinate {

/// "srgb", "linear" or {"gamma": 2.2}. @throws IoError
[[nodiscard]] Response read_response(JsonReader json);
[[nodiscard]] Json json_of(const Response& response);

}  // namespace patinate
