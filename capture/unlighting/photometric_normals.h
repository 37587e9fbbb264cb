/// \file
/// Photometric stereo: normals from photographs alone [Woodham 1980].
#pragma once

#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/geometry/light.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// For each pixel, the vector g (albedo / pi times normal) whose light max(0, g . l) is nearest to what is
/// photographed, the sum of the roots of the differences being smallest: shadows and highlights, however far off,
/// hardly pull. Tried are the solutions of three lamps, all triples of up to 12 lamps and 220 spread ones of more. What
/// unlight() begins with when there is no scan; it then weighs all samples that agree.
/// @param photos  L images H x W x C, linear; a pixel's channels are summed. @param valid  L images H x W, 0 = does not
/// count; or none.
/// @param mask    H x W; may be empty. @param lights  L, directional, at least 3 that do not lie in a plane.
/// @returns H x W x 3, unit; (0, 0, 0) where fewer than 3 samples are valid or nothing is bright.
/// @throws InvalidInput if a light is near, or there are too few, or they all lie in a plane.
/// Same bits for any number of threads.
[[nodiscard]] ImageF photometric_normals(const std::vector<ImageF>& photos, const std::vector<ImageU8>& valid,
                                         const ImageU8& mask, const std::vector<Light>& lights,
                                         const RunControl& control = {});

}  // namespace patinate::capture
