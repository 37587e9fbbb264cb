/// \file
/// libavformat's part of the module `patinate-media`. Inside of the module only.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "libcommon/image/media_module.h"

namespace patinate::media {

/// Functions of MediaModule of these names.
[[nodiscard]] std::unique_ptr<MovieEncoder> create_movie(const MovieFormat& format);
[[nodiscard]] std::string movie_comment(const std::filesystem::path& path);

}  // namespace patinate::media
