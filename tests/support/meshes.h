/// \file
/// Small meshes with closed forms.
#pragma once

#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate::testing_support {

/// Square of `side_mm` in the xy plane, normal +z, laid over the whole atlas: u along x, v along y. `n` x `n` cells.
[[nodiscard]] Mesh unit_plane(double side_mm, int n = 4);
/// The same square, its halves x < side/2 and x > side/2 in two charts of the same texel density; the right one is
/// turned by 90 degrees.
[[nodiscard]] Mesh cut_plane(double side_mm, int n = 8);

/// The square as `n` x `n` charts of the same texel density, each turned by an angle of its own.
[[nodiscard]] Mesh quilt_plane(double side_mm, int n);
/// Plane with every second chart mirrored and every second row of charts with 0.7 of the texel density.
[[nodiscard]] Mesh patchwork_plane(double side_mm, int n);

/// (x, y) * step_mm for x and y in [-radius, radius], row by row, without (0, 0): a neighborhood on a surface.
[[nodiscard]] std::vector<Vec2> square_offsets(int radius, double step_mm);

/// The square as `columns` UDIM tiles from left to right, each a strip of it that fills its tile.
[[nodiscard]] Mesh udim_plane(double side_mm, int columns);

}  // namespace patinate::testing_support
