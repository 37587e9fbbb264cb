/// \file
/// What the photographs of a series say of how they are to be seen, once for all of them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

/// A line for each thing that photographs say: "color: Display P3 (ICC profile)", with the photographs that say
/// otherwise: "orientation: turned by 180 degrees (EXIF orientation 3); not so in f03.jpg: nothing said".
/// @param photos  Name and what the file says, in order.
[[nodiscard]] std::vector<std::string> series_facts(const std::vector<std::pair<std::string, ImageFacts>>& photos);

/// Nothing, or that a response that is given stands in the place of what photographs say of their color.
[[nodiscard]] std::string override_text(const std::vector<std::pair<std::string, ImageFacts>>& photos,
                                        const Response& response);

/// "1/250 s, f/2.8, ISO 100"; "" where time or ISO is not said.
[[nodiscard]] std::string exposure_text(const ImageExposure& exposure);

}  // namespace patinate::capture
