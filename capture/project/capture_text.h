/// \file
/// What both kinds of capture project say alike. Inside of ingest only.
#pragma once

#include <array>
#include <string_view>

namespace patinate::capture {

inline constexpr std::array<std::string_view, 2> kCaptureKinds{"fixed", "relit"};

}  // namespace patinate::capture
