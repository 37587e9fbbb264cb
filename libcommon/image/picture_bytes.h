/// \file
/// Pictures as the bytes of a PNG or JPEG, without a file. Equal pictures give equal bytes.
#pragma once

#include <string>

#include "patinate/image/image.h"

namespace patinate {

/// @param codes  1, 3 or 4 channels. @throws CannotComplete
[[nodiscard]] std::string png_of(const ImageU8& codes);
/// @param codes  1 or 3 channels. @param quality  [1, 100]. @throws CannotComplete
[[nodiscard]] std::string jpeg_of(const ImageU8& codes, int quality = 88);

}  // namespace patinate
