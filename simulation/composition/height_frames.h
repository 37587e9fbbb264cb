/// \file
/// From differences of height between neighboring texels to slopes on the surface.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/simulation/surface_atlas.h"
#include "simulation/composition/compose_kernel.h"

namespace patinate::simulation::composition {

/// Tangents of a triangle as glTF has them: T along +u, B in the triangle at right angles to T, on the side of +v; and
/// one texel step to the right and down in them. Mirrored charts have a B to the other side; slopes do not care.
struct TexelFrame {
  Vec3 t{1, 0, 0};
  Vec3 b{0, 1, 0};
  Eigen::Matrix2d step;  ///< Columns: right and down, in (T, B), mm.
  bool is_degenerate = true;
};
[[nodiscard]] TexelFrame texel_frame(const Eigen::Matrix<double, 3, 2>& mm_per_texel);

/// Places of a texel's neighbors in its frame, in steps of a texel; (0, 0) where there is none.
[[nodiscard]] std::array<Vec2, 4> neighbor_steps(const SceneMesh& scene_mesh, const SurfaceAtlas& surface,
                                                 TexelIndex t);
/// Weights of the four height differences in d height / d texel step (right, down): of the plane that fits best; 0
/// along what no neighbor tells. For those beside: 1/2, -1/2, 1/2, -1/2.
[[nodiscard]] Eigen::Matrix<double, 2, 4> gradient_weights(const std::array<Vec2, 4>& steps);

/// Everything that slopes need besides heights. Memory: 8 bytes a triangle, 4 a tile, 52 for each texel on a border.
class HeightFrames {
 public:
  /// @param scene_mesh  As it stood when `surface` was made.
  HeightFrames(const SceneMesh& scene_mesh, const SurfaceAtlas& surface, const RunControl& control = {});

  /// By triangle + 1; flat in [0] and where a triangle is degenerate.
  [[nodiscard]] std::span<const Frame> frames() const { return frames_; }
  [[nodiscard]] std::span<const BorderTexel> border(TileIndex tile) const;
  /// Border texels of all tiles, in order, and where a tile's begin in them.
  [[nodiscard]] std::span<const BorderTexel> border() const { return border_; }
  [[nodiscard]] std::uint32_t border_begin(TileIndex tile) const { return border_begin_[tile]; }
  /// Tiles, other than the four beside, whose slopes use heights of this one.
  [[nodiscard]] std::span<const TileIndex> dependents(TileIndex tile) const;
  /// Dependent tiles of all tiles, and where a tile's begin in them.
  [[nodiscard]] std::span<const TileIndex> dependents() const { return dependents_; }
  [[nodiscard]] std::uint32_t dependents_begin(TileIndex tile) const { return dependents_begin_[tile]; }
  [[nodiscard]] std::size_t memory() const;

 private:
  std::vector<Frame> frames_;
  std::vector<BorderTexel> border_;
  std::vector<std::uint32_t> border_begin_;  ///< By tile, one more.
  std::vector<TileIndex> dependents_;
  std::vector<std::uint32_t> dependents_begin_;
};

/// The four tiles beside; the tile itself where the atlas ends. Right, left, below, above.
[[nodiscard]] std::array<TileIndex, 4> tiles_beside(const TileGrid& grid, TileIndex tile);

}  // namespace patinate::simulation::composition
