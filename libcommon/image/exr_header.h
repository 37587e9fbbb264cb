/// \file
/// The first bytes of an EXR file, looked at before OpenEXR is: it allocates what they ask for. Inside of image input
/// only.
#pragma once

#include <filesystem>

namespace patinate {

/// Whether it is an EXR without deep pixels whose parts have at most kMaxImageSide along each side, and no more tiles
/// than the file has place for.
[[nodiscard]] bool is_plain_exr(const std::filesystem::path& path);

}  // namespace patinate
