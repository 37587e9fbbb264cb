/// \file
/// What photographs show of an object of known shape: the samples that lights are found from.
#pragma once

#include <vector>

#include "patinate/capture/lambertian_lights.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Squares of step_px x step_px pixels whose pixels all see one smooth piece of the mesh (their normals within 10
/// degrees of the middle one's): the middle's point and normal, and the mean of the photograph there. The side that the
/// camera sees is the outside, however triangles are wound.
/// @param photos  The same view under each light, linear, H x W x 3, the camera's size. @param mask  May be empty.
/// @returns samples[light]; the same places for each. @throws InvalidInput if sizes differ, step_px is not in [1,
/// 1000], or nothing of the mesh is seen.
[[nodiscard]] std::vector<std::vector<ShadedSample>> surface_samples(const Camera& camera_mm, const Mesh& mesh_mm,
                                                                     const std::vector<ImageF>& photos,
                                                                     const ImageU8& mask, int step_px);

/// A square of a plane as two triangles. @param normal  Of any length > 0.
[[nodiscard]] Mesh plane_mesh(const Vec3& middle, const Vec3& normal, double side);

}  // namespace patinate::capture
