/// \file
/// Which texels each lamp does not see.
#pragma once

#include "patinate/core/run_control.h"
#include "patinate/geometry/light.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Median edge length of a mesh: below it, a scan says nothing. 0 without triangles.
[[nodiscard]] double median_edge(const Mesh& mesh);

/// 255 where the segment from a texel to the lamp meets the blockers. It begins `offset_mm` off the surface along the
/// normal, and its first offset_mm do not count, so that a noisy scan does not shadow itself.
/// @param position_mm,normal  H x W x 3; normal unit.
/// @param mask  H x W, 0 = not looked at; may be empty.
/// @param offset_mm  >= 0.
/// @returns H x W x L. Same bits for any number of threads.
[[nodiscard]] ImageU8 cast_shadows(const Mesh& blockers, const ImageF& position_mm, const ImageF& normal,
                                   const ImageU8& mask, const std::vector<Light>& lights, double offset_mm,
                                   const RunControl& control = {});

}  // namespace patinate::capture
