/// \file
/// Several pictures side by side with a label under each.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "patinate/image/image.h"

namespace patinate {

struct ContactStripOptions {
  int columns = 0;  ///< Pictures in a row; 0 = all. >= 0.
  int gap_px = 8;   ///< Between pictures and around them; [0, 1000].
  int label_px =
      0;  ///< Height of the letters; 0 = 1/26 of the picture's height, at least 10; none without labels; [0, 500].
  float background = 0.92f;  ///< Linear gray; labels are dark on light and light on dark.
};

/// @param pictures  Same size, 1 or 3 channels, linear.
/// @param labels    As many as pictures, or none. Printable ASCII; anything else is drawn as `?`.
/// @returns linear, 3 channels.
/// @throws InvalidInput if there is no picture or sizes or numbers differ.
[[nodiscard]] ImageF contact_strip(std::span<const ImageF> pictures, std::span<const std::string> labels,
                                   const ContactStripOptions& options = {});

}  // namespace patinate
