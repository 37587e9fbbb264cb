/// \file
/// What of an image is inside, where the image is a mask. Inside of image input only.
#pragma once

#include "libcommon/image/decoded_image.h"

namespace patinate {

/// 0 outside, 255 inside, by the first of these that the image is:
/// - partly transparent, as an object that is cut out: what is opaque is inside;
/// - labels in several flat colors, black among them: what is not black is inside;
/// - labels in up to 16 levels of gray below 128, 0 among them: what is not 0 is inside;
/// - gray: codes from 128 on are inside.
/// @throws InvalidInput where the image says two things, or is a picture rather than a mask.
[[nodiscard]] ImageU8 mask_of(const DecodedImage& image);

}  // namespace patinate
