/// \file
/// Meshes of known shape for tests.
#pragma once

#include <functional>

#include "patinate/geometry/mesh.h"

namespace patinate::testing_support {

/// Subdivided icosahedron, 20 * 4^levels triangles, outward normals, every vertex on the sphere.
[[nodiscard]] Mesh make_icosphere(double radius, int levels);
/// nu x nv cells over [0, 1]^2 mapped by `point`; UVs are the parameters; the winding gives du x dv normals.
[[nodiscard]] Mesh make_patch(int nu, int nv, const std::function<Vec3(double u, double v)>& point);
/// Axis-aligned cube from 0 to `size`, 12 triangles, outward normals.
[[nodiscard]] Mesh make_cube(double size);

}  // namespace patinate::testing_support
