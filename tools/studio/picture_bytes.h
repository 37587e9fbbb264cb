/// \file
/// Pictures as the bytes of a PNG or JPEG, without a file.
#pragma once

#include <string>
#include <string_view>

#include "patinate/image/image.h"

namespace patinate::studio {

/// @param codes  1, 3 or 4 channels. @throws CannotComplete
[[nodiscard]] std::string png_of(const ImageU8& codes);
/// @param codes  1 or 3 channels. @param quality  [1, 100].
[[nodiscard]] std::string jpeg_of(const ImageU8& codes, int quality = 88);
/// xxHash64 of bytes, 16 hexadecimal digits: quick, also in a browser.
[[nodiscard]] std::string xxh64(std::string_view bytes);

}  // namespace patinate::studio
