/// \file
/// Any picture, small enough to look at.
#pragma once

#include <filesystem>
#include <optional>

#include "patinate/image/image.h"

namespace patinate::studio {

/// sRGB codes of an image file at most `width` pixels wide, 1 or 3 channels. Color as it is; other channels (heights,
/// normals, controls) spread over the values they have, X Y Z as red, green, blue.
/// @param image  Of a movie or another file of many images, counted from 0. @throws IoError if it is no picture that
/// can be read, or holds no such image.
[[nodiscard]] ImageU8 preview_of(const std::filesystem::path& file, int width, std::optional<int> image = {});

}  // namespace patinate::studio
