/// \file
/// Which texels of a surface are lifted flakes: pieces of a layer that have lost their adhesion and still hang on.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/image/image.h"
#include "patinate/simulation/layer_atlas.h"

namespace patinate::simulation {

/// A connected piece of one layer, in one chart, that is the outermost layer there, is lifted, and hangs on what holds.
struct LiftedFlake {
  int layer = 1;
  std::int64_t num_texels = 0;
  double thickness_mm = 0.0;  ///< Mean over its area.
  double radius_mm = 0.0;     ///< Of its curl: thickness over strain, as lift_mm() has it; infinity without strain.
};

/// Texels row by row, width x height, as a user sees them.
struct LiftedFlakes {
  int width = 0, height = 0;
  std::vector<LiftedFlake> flakes;
  std::vector<std::int32_t> flake;    ///< Into flakes; -1 where there is none.
  std::vector<std::int32_t> chart;    ///< -1 outside the charts.
  std::vector<std::uint8_t> holds;    ///< A bit for each layer that cracks and holds there.
  std::vector<std::uint8_t> cracked;  ///< The outermost layer where it has a crack, else 0.
  std::vector<float> crack_share;     ///< Share of the texel that this crack is open, [0, 1].
  std::vector<std::uint8_t> lifted;   ///< The outermost layer where it is lifted, in a flake or not, else 0.
  std::vector<std::uint8_t> bare;     ///< 1 where the layer below shows when flakes stand on their own.

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] bool is_inside(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
};

/// Finds them. A flake holds no part that is narrower than three texels, where its layer holds beside it counted too,
/// and is at least two texels wide, from where its layer holds to its free edge. Slivers would look like wires.
/// `bare` leaves out the texels beside where the layer holds: the layer goes on there below the flake. It includes
/// cracks beside the others. Flakes are in the order of their first texels.
[[nodiscard]] LiftedFlakes find_lifted_flakes(const LayerAtlas& layers);

}  // namespace patinate::simulation
