/// \file
/// What a Composer holds.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "patinate/simulation/compose.h"
#include "simulation/composition/base_layer.h"
#include "simulation/composition/coats.h"
#include "simulation/composition/compose_device.h"
#include "simulation/composition/compose_kernel.h"
#include "simulation/composition/grain.h"
#include "simulation/composition/height_frames.h"
#include "simulation/composition/laid_picture.h"
#include "simulation/composition/quantized_appearance.h"

namespace patinate::simulation {

/// Tiles that several threads add to at once.
class TileSet {
 public:
  explicit TileSet(std::uint32_t num_pages) : pages_(num_pages) {}
  void add(TileIndex tile) {
    std::atomic<std::uint64_t>& page = pages_[tile / TileGrid::kPageTiles];
    const std::uint64_t bit = std::uint64_t{1} << tile % TileGrid::kPageTiles;
    if ((page.load(std::memory_order_relaxed) & bit) == 0) page.fetch_or(bit, std::memory_order_relaxed);
  }
  /// All of them, rising; none is left.
  [[nodiscard]] std::vector<TileIndex> take();
  [[nodiscard]] std::size_t memory() const { return pages_.size() * sizeof(pages_[0]); }

 private:
  std::vector<std::atomic<std::uint64_t>> pages_;  ///< A bit for each tile.
};

/// Parts of the composition, wherever it is done.
struct ComposerParts {
  ComposerParts(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface_atlas,
                ColorForm color_form, const RunControl& control);
  /// Whether all texels of a tile have the original amounts of its object.
  [[nodiscard]] bool has_shared_originals(TileIndex tile) const {
    const std::uint16_t object = base.object(tile);
    return object != composition::BaseLayer::kSeveral && (is_whole[tile] || has_no_originals[object]);
  }
  /// The amount that a texel has when it is new; 0 where it is not covered. @param material  Number of it.
  [[nodiscard]] std::uint16_t original(std::size_t material, TexelIndex texel) const;

  const SurfaceAtlas* surface;
  double quanta_per_mm;
  composition::BaseLayer base;
  composition::Coats coats;
  composition::HeightFrames frames;
  std::vector<TileIndex> covered_tiles;
  std::vector<bool> is_whole;               ///< By tile: all texels are covered.
  std::vector<TexelIndex> texel_of_object;  ///< kNoTexel when it shows in none.
  std::vector<composition::QuantizedAppearance> appearance;
  composition::TexelPlaces places;
  composition::MaterialPictures pictures;
  composition::Grain grain;
  ColorForm form;
  /// By object and material: 64 times the amount when new.
  std::vector<std::array<std::uint16_t, composition::kTile>> originals;
  std::vector<bool> has_no_originals;  ///< By object: all of them are 0.
};

struct Composer::State : ComposerParts {
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
    composition::Coats::Tile coats;
    composition::ComposeTask task;
  };
  void prepare(const MaterialAtlas& atlas, TileIndex tile, TileInput& in);
  /// Codes and heights of a tile; adds it to `changed`, and tiles whose slopes use heights that changed to
  /// `stale_normals`.
  void take(TileIndex tile, const std::uint32_t* new_codes, const std::int32_t* new_heights);
  void take_normals(TileIndex tile, const std::uint8_t* normal);
  /// Color, specular value and height of a tile.
  void compose_tile(const MaterialAtlas& atlas, TileIndex tile);
  /// Normals of a tile; adds it to `changed`.
  void compose_normals(TileIndex tile);
  /// @param edges  Those of the tile where heights changed: bits for right, left, lower and upper.
  void mark_slopes(TileIndex tile, unsigned edges);
  /// Asks memory for what compose_tile() and compose_normals() will read.
  void prefetch(const MaterialAtlas& atlas, TileIndex tile) const;
  void prefetch_heights(TileIndex tile) const;
  void slopes_of(TileIndex tile, composition::SlopeTile& slopes) const;
  /// Copies to the host what was composed on a device.
  void bring_back();
  [[nodiscard]] composition::Textures textures() { return {.codes = codes, .heights = heights, .normals = normals}; }

  const composition::Kernels* kernels;
  bool is_all_dirty = true;

  std::vector<std::uint32_t> codes;
  std::vector<std::int32_t> heights;  ///< Empty while everything is flat.
  std::vector<std::uint8_t> normals;
  TileSet changed;  ///< Both empty between calls, but after one that was canceled.
  TileSet stale_normals;

  std::unique_ptr<composition::DeviceComposition> there;  ///< Null before a device is asked.
  bool is_behind = false;                                 ///< The device has composed since.
  std::function<void()> on_asked;                         ///< Before what a device has composed comes here.
  std::function<void(const device::DeviceError&)>
      on_lost;  ///< Composes here what a device had composed and cannot give back.
};

}  // namespace patinate::simulation
