/// \file
/// How integer codes become linear values, as our JSON files say it.
#pragma once

#include "libcommon/core/json.h"
#include "libcommon/image/color.h"

namespace patinate {

/// "srgb", "linear" or {"gamma": 2.2}. @throws IoError
[[nodiscard]] Response read_response(JsonReader json);
[[nodiscard]] Json json_of(const Response& response);

}  // namespace patinate
