/// \file
/// The first bytes of an EXR file, looked at before OpenEXR is: it allocates what they ask for. Inside of image input
/// only.
#pragma once

#include <filesystem>

namespace patinate {

/// Whether it is an EXR of one part, stored by rows, of at most kMaxImageSide along each side.
[[nodiscard]] bool is_plain_exr(const std::filesystem::path& path);

}  // namespace patinate
