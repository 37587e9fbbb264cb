/// \file
/// refine_edges() for those who carry values of their own at positions.
#pragma once

#include <array>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// refine_edges(). @param parents  Gets, for every new position in order, the two whose edge it splits.
[[nodiscard]] Mesh refine_edges(Mesh mesh, double max_edge, int max_triangles, RefineShape shape,
                                std::vector<std::array<int, 2>>& parents);

}  // namespace patinate
