#include "simulation/rules/layer_values.h"

#include <array>
#include <utility>

namespace patinate::simulation {

namespace {

constexpr std::array<std::pair<std::string_view, LayerValueKind>, 3> kOfMaterials{
    {{"top.", LayerValueKind::Top}, {"below.", LayerValueKind::Below}, {"interface.", LayerValueKind::Interface}}};
constexpr std::array<std::pair<std::string_view, LayerValueKind>, 6> kOfLayers{
    {{"thickness", LayerValueKind::Thickness},
     {"depth", LayerValueKind::Depth},
     {"adhesion", LayerValueKind::Adhesion},
     {"edge", LayerValueKind::Edge},
     {"stress", LayerValueKind::Stress},
     {"crack", LayerValueKind::Crack}}};

}  // namespace

std::vector<std::string> layer_value_names(std::span<const std::string> materials) {
  std::vector<std::string> names;
  for (const auto& [name, kind] : kOfLayers) names.emplace_back(name);
  for (const auto& [prefix, kind] : kOfMaterials) {
    for (const std::string& material : materials) names.push_back(std::string(prefix) + material);
  }
  return names;
}

std::optional<LayerValue> layer_value_of(std::string_view name, std::span<const std::string> materials) {
  for (const auto& [own, kind] : kOfLayers) {
    if (name == own) return LayerValue{.kind = kind};
  }
  for (const auto& [prefix, kind] : kOfMaterials) {
    if (!name.starts_with(prefix)) continue;
    for (std::size_t m = 0; m < materials.size(); ++m) {
      if (name.substr(prefix.size()) == materials[m]) return LayerValue{.kind = kind, .material = static_cast<int>(m)};
    }
  }
  return std::nullopt;
}

std::optional<std::string_view> interface_material(std::string_view name) {
  constexpr std::string_view kPrefix = "interface.";
  return name.starts_with(kPrefix) ? std::optional(name.substr(kPrefix.size())) : std::nullopt;
}

}  // namespace patinate::simulation
