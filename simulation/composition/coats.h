/// \file
/// Layers above substrates, as they look and how high they lie.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/layer_atlas.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/composition/base_layer.h"
#include "simulation/composition/compose_kernel.h"

namespace patinate::simulation::composition {

/// The looks of layers 1, 2, ..., in place of the new surface's where they are the outermost. Heights are the sum of
/// all thicknesses, and what lies at interfaces lifts what is above it by its material's height. A crack shows what is
/// below by the share of its texel that it is open, as dark as the light that comes into it makes it, and is as deep.
/// What has lost its adhesion is lifted.
class Coats {
 public:
  Coats(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface, double quanta_per_mm,
        const RunControl& control = {});

  /// Whether some object of the scene has layers.
  [[nodiscard]] bool has_any() const { return !looks_.empty(); }
  /// @param layers  Outlives the coats.
  void set(const LayerAtlas* layers) { layers_ = layers; }
  [[nodiscard]] std::size_t memory() const;

  /// Memory for what a tile looks like.
  struct Tile {
    BaseTile base;
    BaseTile buffer;
    alignas(64) std::int32_t heights[kTile];
  };
  /// @param looks  Of the materials. @param task  With the base and heights of the substrates; both are replaced.
  void cover(TileIndex tile, std::span<const QuantizedAppearance> looks, Tile& own, ComposeTask& task) const;

 private:
  void cover_look(TileIndex tile, Tile& own, ComposeTask& task) const;
  void draw_cracks(TileIndex tile, const BaseTile& substrate, Tile& own, ComposeTask& task) const;
  [[nodiscard]] bool is_cracked(TileIndex tile) const;
  [[nodiscard]] bool shows_crack(TexelIndex texel) const;
  [[nodiscard]] double open_share(TexelIndex texel) const;
  void add_lifts(TileIndex tile, std::int32_t* heights) const;
  void add_heights(TileIndex tile, std::span<const QuantizedAppearance> looks, std::int32_t* heights) const;

  std::vector<BaseLayer> looks_;  ///< By layer, from the first above the substrates on.
  const LayerAtlas* layers_ = nullptr;
  double texel_mm_ = 0.0;
  double quanta_per_mm_ = 0.0;
  std::int64_t height_scale_ = 0;  ///< Height quanta of a quantum of thickness, times 2^kHeightShift.
};

}  // namespace patinate::simulation::composition
