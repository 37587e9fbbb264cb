/// \file
/// Printed markers that lie beside the object: marks that nobody needs to click.
#pragma once

#include <vector>

#include "capture/handheld/landmarks.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Four corners of every ArUco or AprilTag marker [Garrido-Jurado et al. 2014; Olson 2011], to a fraction of a pixel,
/// by names as "4x4 7 corner 0". A marker that is seen twice is left out.
/// @param color  H x W x 3, linear. @returns one a dictionary: 4x4, 5x5, 6x6 and 7x7 (up to 250 markers each), the
/// original ArUco one, AprilTag 36h11.
[[nodiscard]] std::vector<PhotoMarks> find_markers(const ImageF& color);

/// Marks of the dictionary that most pairs of photographs and names share: what one finds by chance, in a texture,
/// another does not.
/// @param found  find_markers() of every photograph.
[[nodiscard]] std::vector<PhotoMarks> of_one_dictionary(const std::vector<std::vector<PhotoMarks>>& found);

}  // namespace patinate::capture
