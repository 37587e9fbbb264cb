/// \file
/// Layers of material on a surface: how thick each still is at every texel, how it adheres, and what lies below it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/ledger.h"
#include "patinate/simulation/material_atlas.h"
#include "patinate/simulation/scene.h"

namespace patinate::simulation {

/// What became of one layer of one object. Balance: start = worn + flaked + what remains. In thickness quanta times
/// area weights.
struct LayerAccount {
  MassSum start;   ///< At the start; of an object that is scaled since: as if it had been so then.
  MassSum worn;    ///< Taken by rules.
  MassSum flaked;  ///< Fallen off: by itself without adhesion, or with a layer below it.
};

/// A crack's end, which moves on.
struct CrackTip {
  TexelIndex texel = 0;
  std::uint32_t layer = 1;
  std::array<float, 2> place{};  ///< In the atlas, texels.
  std::array<float, 2> way{};    ///< Unit, on the surface, along the texel's row and at right angles to it.
  float waits_for = 0.0F;        ///< Amount of stress there below which it does not move on, quanta.
  friend bool operator==(const CrackTip&, const CrackTip&) = default;
};

/// Layers 1, 2, ... of every object from its substrate, layer 0, outward (SceneObject::layers). A layer is where its
/// thickness is above 0; the outermost one shows. Thicknesses and adhesion are kept as amounts are: integers in pages
/// of 64 x 64 texels that are made when first written, so that a layer costs memory only where it has changed or is
/// described by a map.
class LayerAtlas {
 public:
  static constexpr int kQuantaPerUm = 16;
  static constexpr std::uint32_t kAdhesionOne = kAmountOne;

  /// The layers as they are when all is new, without the maps of their thickness and adhesion
  /// (lay_initial_layers()). @param surface  Outlives the atlas.
  LayerAtlas(const SurfaceAtlas& surface, const Scene& scene);

  [[nodiscard]] const SurfaceAtlas& surface() const { return *surface_; }
  [[nodiscard]] int num_objects() const { return static_cast<int>(stacks_.size()); }
  /// Of the object with most, its substrate included.
  [[nodiscard]] int num_layers() const { return num_layers_; }
  /// 0 of an object without layers.
  [[nodiscard]] int num_layers(int object) const { return static_cast<int>(stacks_[object].size()); }
  [[nodiscard]] const std::string& name(int object, int layer) const { return stacks_[object][layer].name; }
  /// -1 = there is none. The substrate has no number but its own, 0.
  [[nodiscard]] int layer_named(int object, std::string_view name) const;
  /// Amounts of which a layer is made.
  [[nodiscard]] const MaterialValues& composition(int object, int layer) const {
    return stacks_[object][layer].composition;
  }
  [[nodiscard]] double metalness(int object, int layer) const { return stacks_[object][layer].metalness; }

  // By layer in place of the material.
  [[nodiscard]] const MaterialAtlas& thickness() const { return thickness_; }
  [[nodiscard]] MaterialAtlas& thickness() { return thickness_; }
  [[nodiscard]] const MaterialAtlas& adhesion() const { return adhesion_; }
  [[nodiscard]] MaterialAtlas& adhesion() { return adhesion_; }
  /// Amounts between a layer, [1, num_layers()), and what is below it.
  [[nodiscard]] const MaterialAtlas& interface_below(int layer) const { return interfaces_[layer - 1]; }
  [[nodiscard]] MaterialAtlas& interface_below(int layer) { return interfaces_[layer - 1]; }

  /// Nothing for a layer that never cracks.
  [[nodiscard]] const std::optional<LayerCracks>& cracks(int object, int layer) const {
    return stacks_[object][layer].cracks;
  }
  [[nodiscard]] bool has_cracks() const { return !cracked_.empty(); }
  // By layer too, in a scene where some layer cracks: amounts of stress and of strength; the stress at which to look
  // next whether a crack begins; where a crack is, kAmountOne.
  [[nodiscard]] const MaterialAtlas& stress() const { return stress_; }
  [[nodiscard]] MaterialAtlas& stress() { return stress_; }
  [[nodiscard]] const MaterialAtlas& strength() const { return strength_; }
  [[nodiscard]] MaterialAtlas& strength() { return strength_; }
  [[nodiscard]] const MaterialAtlas& next_look() const { return next_look_; }
  [[nodiscard]] MaterialAtlas& next_look() { return next_look_; }
  [[nodiscard]] const MaterialAtlas& crack() const { return crack_; }
  [[nodiscard]] MaterialAtlas& crack() { return crack_; }
  void add_crack(int layer, TexelIndex texel);
  /// CrackTension::along by triangle, along its row of texels and at right angles to it: as long as the unit vector's
  /// projection to the surface. Empty where no object's layer of that number has a direction (lay_initial_layers()).
  [[nodiscard]] const std::vector<std::array<float, 2>>& tension_axes(int layer) const { return tension_axes_[layer]; }
  [[nodiscard]] std::vector<std::array<float, 2>>& tension_axes(int layer) { return tension_axes_[layer]; }
  /// Whether a layer ends at a texel, by a crack of its own or because it is gone.
  [[nodiscard]] bool is_open(int layer, TexelIndex texel) const {
    return tops_[texel] < layer || (cracked_[texel] >> layer & 1) != 0;
  }
  [[nodiscard]] const std::vector<CrackTip>& tips() const { return tips_; }
  [[nodiscard]] std::vector<CrackTip>& tips() { return tips_; }

  /// The outermost layer by texel, in tile order; 0 outside the charts too.
  [[nodiscard]] std::span<const std::uint8_t> tops() const { return tops_; }
  /// A bit for each layer, by texel: where it has a crack; where one that cracks is there and has lost its adhesion.
  /// Empty where no layer cracks.
  [[nodiscard]] std::span<const std::uint8_t> cracked() const { return cracked_; }
  [[nodiscard]] std::span<const std::uint8_t> loose() const { return loose_; }
  /// After thicknesses, adhesion or cracks of a tile, or of all, were changed.
  void renew_tops(TileIndex tile);
  void renew_tops(const RunControl& control = {});

  [[nodiscard]] const LayerAccount& account(int object, int layer) const {
    return accounts_[account_index(object, layer)];
  }
  [[nodiscard]] std::span<LayerAccount> accounts() { return accounts_; }
  [[nodiscard]] std::span<const LayerAccount> accounts() const { return accounts_; }
  [[nodiscard]] static std::size_t account_index(int object, int layer) {
    return static_cast<std::size_t>(object) * kMaxLayers + static_cast<std::size_t>(layer);
  }
  /// What is there now, by account_index(). Slow, exact.
  [[nodiscard]] std::vector<std::int64_t> remaining(const RunControl& control = {}) const;
  /// Mass of a material at all interfaces.
  [[nodiscard]] std::int64_t interface_mass(int material, const RunControl& control = {}) const;
  /// Enters what is there as what there was at the start.
  void begin_accounts(const RunControl& control = {});
  /// What does not balance; "" if nothing.
  [[nodiscard]] std::string audit(const RunControl& control = {}) const;

  /// Of all thicknesses, adhesion, amounts at interfaces, stress and cracks.
  [[nodiscard]] std::string hash() const;
  [[nodiscard]] std::size_t memory() const;

 private:
  struct Stacked {
    std::string name;
    MaterialValues composition;
    double metalness;
    std::optional<LayerCracks> cracks;
  };
  void renew_cracks(TileIndex tile);

  const SurfaceAtlas* surface_;
  std::vector<std::vector<Stacked>> stacks_;  ///< By object.
  int num_layers_;
  MaterialAtlas thickness_;
  MaterialAtlas adhesion_;
  std::vector<MaterialAtlas> interfaces_;
  MaterialAtlas stress_;
  MaterialAtlas strength_;
  MaterialAtlas next_look_;
  MaterialAtlas crack_;
  std::array<std::vector<std::array<float, 2>>, kMaxLayers> tension_axes_;
  std::vector<CrackTip> tips_;
  std::vector<std::uint8_t> tops_;
  std::vector<std::uint8_t> cracked_;
  std::vector<std::uint8_t> loose_;
  std::vector<LayerAccount> accounts_;
};

/// Materials that the scene's rules and events make at interfaces.
[[nodiscard]] std::vector<int> materials_at_interfaces(const Scene& scene);

}  // namespace patinate::simulation
