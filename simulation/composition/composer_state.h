/// \file
/// What a Composer holds.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "patinate/simulation/compose.h"
#include "simulation/composition/base_layer.h"
#include "simulation/composition/compose_device.h"
#include "simulation/composition/compose_kernel.h"
#include "simulation/composition/grain.h"
#include "simulation/composition/height_frames.h"
#include "simulation/composition/quantized_appearance.h"

namespace patinate::simulation {

struct Composer::State {
  State(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface_atlas, ColorForm color_form,
        const RunControl& control);

  void set_appearance(const std::vector<MaterialAppearance>& appearance);
  /// Amounts of new texels, by object and material, from any texel of the object.
  void read_originals(const MaterialAtlas& atlas);
  /// A tile as kernels take it, and room for what is not stored as such.
  struct TileInput {
    composition::BaseTile base;
    alignas(64) std::uint16_t originals[kMaxMaterials][composition::kTile];
    alignas(64) std::uint16_t pictures[kMaxMaterials][3 * composition::kTile];
    composition::ComposeTask task;
  };
  void prepare(const MaterialAtlas& atlas, TileIndex tile, TileInput& in);
  /// Codes and heights of a tile; leaves what changed in `flags`.
  void take(TileIndex tile, const std::uint32_t* new_codes, const std::int32_t* new_heights);
  void take_normals(TileIndex tile, const std::uint8_t* normal);
  /// Color, specular value and height of a tile.
  void compose_tile(const MaterialAtlas& atlas, TileIndex tile);
  /// The same of many, and normals. @returns false where there is no device or it has failed.
  bool composed_on_device(const MaterialAtlas& atlas, std::span<const TileIndex> tiles, const RunControl& control);
  bool normals_on_device(std::span<const TileIndex> tiles, const RunControl& control);
  template <class Work>
  bool worked_on_device(const Work& work);
  /// Normals of a tile; leaves whether they changed in `normal_flags`.
  void compose_normals(TileIndex tile);
  /// Whether heights changed that the tile's slopes use.
  [[nodiscard]] bool needs_normals(TileIndex tile) const;
  /// Tiles around changed heights of `tiles`, in order.
  [[nodiscard]] std::vector<TileIndex> tiles_around(const std::vector<TileIndex>& tiles);
  void slopes_of(TileIndex tile, composition::SlopeTile& slopes) const;

  static constexpr std::uint8_t kCodesChanged = 1;
  static constexpr std::uint8_t kHeightsChanged = 2;
  static constexpr std::uint8_t kMarked = 4;
  static constexpr std::uint8_t kEdge = 16;  ///< << 0, 1, 2, 3: heights changed at the right, left, lower, upper edge.

  const SurfaceAtlas* surface;
  double quanta_per_mm;
  composition::BaseLayer base;
  composition::HeightFrames frames;
  std::vector<TileIndex> covered_tiles;
  std::vector<TexelIndex> texel_of_object;  ///< kNoTexel when it shows in none.
  std::vector<composition::QuantizedAppearance> appearance;
  std::vector<composition::Picture> pictures;
  composition::Grain grain;
  ColorForm form;
  const composition::Kernels* kernels;
  std::shared_ptr<const ComposeDevice> device;
  std::unique_ptr<composition::DeviceSurface> on_device;
  bool is_all_dirty = true;

  /// By object and material: 64 times the amount when new.
  std::vector<std::array<std::uint16_t, composition::kTile>> originals;
  std::vector<std::uint32_t> codes;
  std::vector<std::int32_t> heights;  ///< Empty while everything is flat.
  std::vector<std::uint8_t> normals;
  std::vector<std::uint8_t> flags;  ///< By tile; 0 between calls, as the next.
  std::vector<std::uint8_t> normal_flags;
};

}  // namespace patinate::simulation
