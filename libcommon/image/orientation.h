/// \file
/// Pictures as they are to be seen: turned by the orientation that their file declares. Inside of image input only.
#pragma once

#include "libcommon/image/image_decoder.h"

namespace patinate {

/// Orientations 5 to 8 exchange width and height.
[[nodiscard]] constexpr bool is_transposing(int orientation) { return orientation >= 5; }

/// The picture upright. @param orientation  EXIF's, [1, 8].
[[nodiscard]] CodedImage upright(CodedImage stored, int orientation);

}  // namespace patinate
