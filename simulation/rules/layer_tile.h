/// \file
/// The layers of one tile while rules act on it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/simulation/layer_atlas.h"
#include "simulation/layers/crack_growth.h"
#include "simulation/rules/compiled_rules.h"
#include "simulation/rules/tile_facts.h"

namespace patinate::simulation {

/// What is the same at all tiles: by object, what its layers are made of, and which are meant by the rules' targets.
struct LayerFacts {
  LayerFacts() = default;
  /// @param layers,rules,facts  Outlive it.
  LayerFacts(const LayerAtlas& layers, const CompiledRules& rules, const TileFacts& facts);

  const LayerAtlas* layers = nullptr;
  const CompiledRules* rules = nullptr;
  const TileFacts* facts = nullptr;
  /// By object, layer, material; 0 of objects without layers.
  std::vector<std::array<std::array<float, kMaxMaterials>, kMaxLayers>> composition;
  std::vector<std::vector<std::int8_t>> targets;  ///< By target, then object; -1 = it has none of that name.
  float edge_per_mm = 0.0F;
};

[[nodiscard]] LayerNames layer_names_of(const LayerAtlas& layers);

/// The tile and those with neighbors of its texels: where rules may have something to do when its layers open.
[[nodiscard]] std::vector<TileIndex> tiles_at(TileIndex tile, const SurfaceAtlas& surface);

/// By LayerAtlas::account_index(), and by material.
struct LayerSums {
  std::vector<std::int64_t> worn, flaked;
  std::array<std::int64_t, kMaxMaterials> overflow{};  ///< Came out from below a layer where there was no room for it.

  /// Moves what was worn and what flaked.
  void enter(std::span<LayerAccount> accounts);
};

/// Copies a tile's thicknesses and adhesion, lets rules change them one after the other, and stores them again.
class LayerTile {
 public:
  static constexpr std::size_t kTile = TileGrid::kTileTexels;
  using Quanta = std::array<std::uint16_t, kTile>;

  explicit LayerTile(const LayerFacts& facts) : f_(&facts) {}
  void load(TileIndex tile);
  /// Fills the values that the rule's driver asks for, and the states that it changes.
  /// @param slots,quanta  As RuleKernel::apply() takes them: of all slots.
  /// @param covered       1 or 0. @returns where the rule acts, alike: `covered`, or own memory.
  [[nodiscard]] const float* begin(const CompiledRule& rule, const float* covered, float* slots, std::int32_t* quanta);
  /// Takes over the states. @param weights  0 where nothing is covered.
  void end(const CompiledRule& rule, const std::int32_t* quanta, const std::array<std::uint32_t, kTile>& weights,
           LayerSums& sums);
  /// Of what fell as CrackCells say: the layer goes at a texel of the tile, with all above it.
  void drop(std::size_t texel, int layer, LayerSums& sums);
  /// Layers without adhesion fall off with all that is above them, those that crack left out; what was below a layer
  /// that is gone lies below the next one above it, or on the surface. @param atlas  Its amounts of the tile are
  /// stored.
  /// @returns whether anything changed. @param is_opened  Set if another layer shows somewhere.
  [[nodiscard]] bool store(LayerAtlas& layers, MaterialAtlas& atlas, LayerSums& sums, bool& is_opened);
  /// Appends where layers that crack have lost their adhesion since load().
  void find_loosened(std::vector<LayerTexel>& out) const;

 private:
  void find_acting(const CompiledRule& rule);
  void fill(const LayerValue& value, const float* slots, float* out) const;
  void fill_composition(const std::array<std::uint8_t, kTile>& layer, int material, float* out) const;
  void fill_edge(float* out) const;
  template <class IsOpen>
  void fill_edge(IsOpen&& is_open, float* out) const;
  [[nodiscard]] const std::array<Quanta, kMaxLayers>& planes_of(std::size_t state) const;
  [[nodiscard]] std::array<Quanta, kMaxLayers>& planes_of(std::size_t state);
  [[nodiscard]] bool does_crack(std::size_t texel, int layer) const;
  void fill_state(std::size_t state, float* amounts, std::int32_t* quanta) const;
  /// A quantity of the acting layers; 0 where they are not.
  void gather(const std::array<Quanta, kMaxLayers>& planes, Quanta& out) const;
  void drop_loose_layers(LayerSums& sums);
  void uncover(LayerAtlas& layers, MaterialAtlas& atlas, LayerSums& sums) const;

  const LayerFacts* f_;
  TileIndex tile_ = 0;
  int num_layers_ = 0;
  std::array<std::uint16_t, kTile> object_{};
  std::array<std::uint8_t, kTile> top_{};
  bool has_one_object_ = false;
  std::array<std::int8_t, kTile> acting_{};  ///< -1 where the layer that the rule acts on is not.
  int acting_everywhere_ = -1;               ///< The same layer at all texels, and there; -1 otherwise.
  std::array<float, kTile> where_{};
  std::array<Quanta, kMaxLayers> thickness_{}, adhesion_{}, stress_{};
  std::array<bool, kMaxLayers> has_new_thickness_{}, has_new_adhesion_{}, has_new_stress_{};
  struct Interfaces {
    std::array<Quanta, kMaxLayers> amounts{};
    std::array<bool, kMaxLayers> is_new{};
  };
  std::vector<Interfaces> interfaces_;  ///< By state of CompiledRules; those of other kinds are not used.
};

}  // namespace patinate::simulation
