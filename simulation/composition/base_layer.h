/// \file
/// What a scene looks like when it is new, texel by texel, kept only where objects have maps.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/composition/compose_kernel.h"
#include "simulation/composition/quantized_appearance.h"
#include "simulation/rules/surface_parameter.h"

namespace patinate::simulation::composition {

/// Gives a texel of a tile what a code says (BaseTile::code).
void unpack(std::uint32_t code, std::size_t texel, BaseTile& tile);

/// Original colors, specular values and heights. Maps are sampled bilinearly at texel centers (a map with the object's
/// own size in the atlas: copied), pictures of presets repeated by texels; colors become sRGB codes, specular values
/// codes of 8 bit. Memory: 4 bytes a texel for pages (64 x 64) with color or specular maps, 4 for those with height
/// maps.
class BaseLayer {
 public:
  BaseLayer(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface, double quanta_per_mm,
            const RunControl& control = {});

  /// The only object of a tile; kSeveral or kNone otherwise.
  static constexpr std::uint16_t kSeveral = 0xFFFE;
  static constexpr std::uint16_t kNone = 0xFFFF;
  [[nodiscard]] std::uint16_t object(TileIndex tile) const { return tile_object_[tile]; }
  [[nodiscard]] bool has_heights() const { return has_heights_; }
  [[nodiscard]] std::size_t memory() const;

  /// @param buffer  Used where the answer is not stored as such.
  [[nodiscard]] const BaseTile& tile(TileIndex tile, BaseTile& buffer) const;
  /// 64 height quanta.
  [[nodiscard]] const std::int32_t* heights(TileIndex tile) const;

 private:
  struct ObjectColors;  ///< Sources of an object's colors besides its maps.
  void fill_page(std::uint32_t page, const Scene& scene, const SceneMesh& scene_mesh,
                 const std::vector<ObjectColors>& colors, double quanta_per_mm);

  const SurfaceAtlas* surface_;
  bool has_heights_ = false;
  std::vector<std::uint16_t> tile_object_;
  std::vector<BaseTile> plain_;  ///< By object: one color.
  std::vector<std::unique_ptr<std::uint32_t[]>> codes_;
  std::vector<std::unique_ptr<std::int32_t[]>> heights_;
};

}  // namespace patinate::simulation::composition
