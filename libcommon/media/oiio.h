/// \file
/// OpenImageIO's part of the module `patinate-media`. Inside of the module only. Call configure_image_library() first.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "libcommon/image/media_module.h"

namespace patinate::media {

/// OpenImageIO's settings, made once; every use of it calls this first.
void configure_image_library();
/// OpenImageIO's messages may span lines; ours are one.
[[nodiscard]] std::string one_line(std::string text);

/// Functions of MediaModule of these names.
[[nodiscard]] std::unique_ptr<ImageSource> open_image(const std::filesystem::path& path,
                                                      const std::filesystem::path& name, bool has_raw_color);
[[nodiscard]] std::unique_ptr<ImageEncoder> create_image_encoder(const EncodedFormat& format, ByteSink& sink);
[[nodiscard]] std::unique_ptr<MovieEncoder> create_gif(const std::string& shown_path, double fps, ByteSink& sink);

}  // namespace patinate::media
