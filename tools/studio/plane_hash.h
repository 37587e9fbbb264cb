/// \file
/// A hash of planes that a browser computes, too.
#pragma once

#include <string>
#include <string_view>

namespace patinate::studio {

/// xxHash64 of bytes, 16 hexadecimal digits: quick, also in a browser.
[[nodiscard]] std::string xxh64(std::string_view bytes);

}  // namespace patinate::studio
