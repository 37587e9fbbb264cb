/// \file
/// The tiles that highlights are summed over before they are smoothed. Inside of unlighting only.
#pragma once

#include <algorithm>
#include <array>

#include "patinate/image/image.h"

namespace patinate::capture {

inline constexpr int kSpecularTile = 8;  ///< Pixels along a side.

/// One of `step` pixels is summed.
[[nodiscard]] inline bool is_specular_sample(int x, int y, int step) { return (x + 2 * y) % step == 0; }

/// One of the tiles whose centers are nearest to a pixel, and its share of what lies between them.
struct TileShare {
  int x = 0;
  int y = 0;
  double weight = 0.0;
};

/// Bilinear; at the edges tiles are repeated. @param tiles  One pixel a tile.
[[nodiscard]] inline std::array<TileShare, 4> tiles_around(const ImageF& tiles, int x, int y) {
  const double u = std::clamp((x + 0.5) / kSpecularTile - 0.5, 0.0, tiles.width() - 1.0),
               v = std::clamp((y + 0.5) / kSpecularTile - 0.5, 0.0, tiles.height() - 1.0);
  const int i = static_cast<int>(u), j = static_cast<int>(v);
  const int right = std::min(i + 1, tiles.width() - 1), below = std::min(j + 1, tiles.height() - 1);
  const double s = u - i, t = v - j;
  return {{{i, j, (1.0 - s) * (1.0 - t)}, {right, j, s * (1.0 - t)}, {i, below, (1.0 - s) * t}, {right, below, s * t}}};
}

}  // namespace patinate::capture
