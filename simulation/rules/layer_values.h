/// \file
/// What drivers of rules may ask for in a scene with layers (docs/algorithms/layers.md).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace patinate::simulation {

enum class LayerValueKind {
  Top,        ///< top.MATERIAL: of what the outermost layer is made.
  Below,      ///< below.MATERIAL: the same of the one below the layer that the rule acts on.
  Interface,  ///< interface.MATERIAL: the amount between these two.
  Thickness,  ///< um, of the layer that the rule acts on.
  Depth,      ///< um, of it and all layers above it.
  Adhesion,   ///< Of it, [0, 1].
  Edge,       ///< 1/mm: where it ends beside this place; its rate is then a speed in mm.
  Stress,     ///< Of it; 0 of one that does not crack.
  Crack,      ///< 1 where it has a crack.
  Whole       ///< MATERIAL where layers are made of it: the amount, and what the outermost layer has of it.
};

/// A value of layers, as a name of drivers says it.
struct LayerValue {
  LayerValueKind kind = LayerValueKind::Top;
  int material = -1;  ///< Of the first three and the last.
  friend bool operator==(const LayerValue&, const LayerValue&) = default;
};

/// Names that drivers have besides where there are layers.
[[nodiscard]] std::vector<std::string> layer_value_names(std::span<const std::string> materials);
/// Nothing for a name that is none of them.
[[nodiscard]] std::optional<LayerValue> layer_value_of(std::string_view name, std::span<const std::string> materials);

/// "interface." before a material, in products and reactants.
[[nodiscard]] std::optional<std::string_view> interface_material(std::string_view name);

}  // namespace patinate::simulation
