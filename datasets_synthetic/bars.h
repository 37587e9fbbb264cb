/// \file
/// Bodies of planks and bars as one mesh with one atlas, for scenes to simulate.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate::datasets {

/// A flat quadrangle, corners counter-clockwise seen from outside; the first side is at right angles to the second or
/// fourth.
struct Face {
  std::array<Vec3, 4> corners;
  int cells_x = 1;  ///< Along the first side; faces that share an edge cut it alike.
  int cells_y = 1;
  double angle = 0.0;  ///< By which its chart is turned in the atlas, radians.
};

/// Adds a body between x0 and x1 (mm) whose section in the yz plane is a quadrangle, counter-clockwise seen from +x:
/// front foot, back foot, back top, front top. @param cell_mm  About the side of a cell.
void add_bar(std::vector<Face>& faces, double x0, double x1, const std::array<Vec2, 4>& section_yz, double cell_mm);

/// Cuts faces into charts of whole cells, each turned by an angle of its own. @param num_charts  Along the longer side;
/// 1 = as it was.
[[nodiscard]] std::vector<Face> in_patches(const std::vector<Face>& faces, int num_charts);

/// Faces as a mesh, a chart each, of even density without overlaps and 3 texels apart on 1024; equal positions are
/// joined, so that the surface continues over edges. Triangles are in the faces' order, 2 cells_x cells_y of each.
/// @param largest_mm  No chart is larger; > 0.
[[nodiscard]] Mesh mesh_of_faces(const std::vector<Face>& faces, double largest_mm, const std::string& node,
                                 const std::string& material);

}  // namespace patinate::datasets
