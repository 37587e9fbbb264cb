/// \file
/// What both kinds of capture project say alike. Inside of ingest only.
#pragma once

#include <array>
#include <string_view>

#include "libcommon/core/json.h"
#include "libcommon/image/color.h"

namespace patinate {

inline constexpr std::array<std::string_view, 2> kCaptureKinds{"fixed", "relit"};
/// "srgb", "linear" or {"gamma": 2.2}. @throws IoError
[[nodiscard]] Response read_response(JsonReader json);

}  // namespace patinate
