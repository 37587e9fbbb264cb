/// \file
/// A sheet cut into its tiles.
#pragma once

#include "patinate/atlas/texel_map.h"

namespace patinate {

/// A tile with its margins: the rectangles of all tiles do not overlap, and no chart leaves its own.
[[nodiscard]] inline TexelRect cell_of(const Sheet& sheet, int tile) {
  const int m = sheet.margin(), x0 = sheet.first_x(tile) - m, y0 = sheet.first_y(tile) - m;
  return {x0, y0, x0 + sheet.tile_width + 2 * m, y0 + sheet.tile_height + 2 * m};
}

}  // namespace patinate
