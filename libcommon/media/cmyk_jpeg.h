/// \file
/// JPEGs of four inks, which OpenImageIO gives as RGB only. Inside of the module only.
#pragma once

#include <filesystem>

#include "libcommon/image/image_decoder.h"

namespace patinate::media {

/// Shares of ink, C, M, Y and K, 8 bits each: 255 = all ink, also where Adobe wrote them the other way round.
/// @throws IoError if it is damaged or of other than four inks.
[[nodiscard]] CodedImage read_cmyk_jpeg(const std::filesystem::path& path);

}  // namespace patinate::media
