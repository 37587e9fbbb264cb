/// \file
/// Which boards the objects of a scene are made of, for the grain of wood.
#pragma once

#include <vector>

#include "patinate/controls/wood_grain.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

struct Boards {
  std::vector<int> of_triangle;  ///< Index into `boards`.
  std::vector<Board> boards;
};

/// Every piece of an object that hangs together, over positions that are equal, is a board of its own: its grain runs
/// along the longest side of its box (of equal ones the first of x, y, z), in the coordinates that `scene_mesh` has.
/// @param first_numbers  By object: of its first board; its others follow.
[[nodiscard]] Boards find_boards(const SceneMesh& scene_mesh, const std::vector<std::int64_t>& first_numbers);

}  // namespace patinate::simulation
