#include "patinate/simulation/layer_atlas.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "libcommon/core/hash.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"

namespace patinate::simulation {

namespace {

using Quanta = std::array<std::uint16_t, kMaxMaterials>;

/// Of an expression that is a number; 0 of others, whose values are laid later. @param most,one  Range, and quanta
/// of 1.
std::uint16_t quanta_of(const std::string& text, double most, double one) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return 0;
  return static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0, most) * one));
}

template <class Value>
std::vector<Quanta> layer_quanta(const Scene& scene, Value&& value) {
  std::vector<Quanta> quanta;
  for (const SceneObject& object : scene.objects) {
    Quanta& of = quanta.emplace_back(Quanta{});
    for (std::size_t l = 1; l < object.layers.size(); ++l) of[l] = value(object.layers[l]);
  }
  return quanta;
}

std::vector<Quanta> no_quanta(const Scene& scene) { return std::vector<Quanta>(scene.objects.size(), Quanta{}); }

int most_layers(const Scene& scene) {
  std::size_t most = 0;
  for (const SceneObject& object : scene.objects) most = std::max(most, object.layers.size());
  return static_cast<int>(most);
}

}  // namespace

LayerAtlas::LayerAtlas(const SurfaceAtlas& surface, const Scene& scene)
    : surface_(&surface),
      num_layers_(most_layers(scene)),
      thickness_(
          surface, num_layers_,
          layer_quanta(
              scene, [](const Layer& layer) { return quanta_of(layer.thickness_um, kMaxThicknessUm, kQuantaPerUm); })),
      adhesion_(surface, num_layers_,
                layer_quanta(scene, [](const Layer& layer) { return quanta_of(layer.adhesion, 1.0, kAdhesionOne); })),
      stress_(surface, simulation::has_cracks(scene) ? num_layers_ : 0, no_quanta(scene)),
      strength_(surface, stress_.num_materials(),
                layer_quanta(scene,
                             [](const Layer& layer) {
                               return layer.cracks ? quanta_of(layer.cracks->strength, kMaxStrength, kAmountOne)
                                                   : std::uint16_t{0};
                             })),
      next_look_(surface, stress_.num_materials(), no_quanta(scene)),
      crack_(surface, stress_.num_materials(), no_quanta(scene)),
      tops_(num_layers_ == 0 ? 0 : surface.grid().num_texels()),
      cracked_(stress_.num_materials() == 0 ? 0 : tops_.size()),
      loose_(cracked_.size()),
      accounts_(scene.objects.size() * kMaxLayers) {
  const auto num_materials = static_cast<int>(scene.materials.size());
  for (int l = 1; l < num_layers_; ++l) interfaces_.emplace_back(surface, num_materials, no_quanta(scene));
  for (const SceneObject& object : scene.objects) {
    std::vector<Stacked>& stack = stacks_.emplace_back();
    for (const Layer& layer : object.layers)
      stack.push_back({layer.name, layer.look.amounts, layer.look.metalness, layer.cracks});
  }
}

int LayerAtlas::layer_named(int object, std::string_view name) const {
  const std::vector<Stacked>& stack = stacks_[object];
  for (std::size_t l = 0; l < stack.size(); ++l) {
    if (stack[l].name == name) return static_cast<int>(l);
  }
  return -1;
}

void LayerAtlas::renew_tops(TileIndex tile) {
  std::uint8_t* tops = tops_.data() + std::size_t{tile} * TileGrid::kTileTexels;
  std::fill_n(tops, TileGrid::kTileTexels, std::uint8_t{0});
  std::array<std::uint16_t, TileGrid::kTileTexels> thickness;
  for (int l = 1; l < num_layers_; ++l) {
    thickness_.read_tile(l, tile, thickness);
    for (std::size_t i = 0; i < TileGrid::kTileTexels; ++i)
      tops[i] = thickness[i] != 0 ? static_cast<std::uint8_t>(l) : tops[i];
  }
  if (has_cracks()) renew_cracks(tile);
}

void LayerAtlas::add_crack(int layer, TexelIndex texel) {
  crack_.writable_tile(layer, TileGrid::tile_of(texel))[texel % TileGrid::kTileTexels] = kAmountOne;
  cracked_[texel] |= static_cast<std::uint8_t>(1U << layer);
}

void LayerAtlas::renew_cracks(TileIndex tile) {
  const std::size_t first = std::size_t{tile} * TileGrid::kTileTexels;
  std::fill_n(cracked_.data() + first, TileGrid::kTileTexels, std::uint8_t{0});
  std::fill_n(loose_.data() + first, TileGrid::kTileTexels, std::uint8_t{0});
  std::array<std::uint16_t, TileGrid::kTileTexels> crack, thickness, adhesion;
  for (int l = 1; l < num_layers_; ++l) {
    const auto bit = static_cast<std::uint8_t>(1U << l);
    crack_.read_tile(l, tile, crack);
    thickness_.read_tile(l, tile, thickness);
    adhesion_.read_tile(l, tile, adhesion);
    for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
      if (crack[i] != 0) cracked_[first + i] |= bit;
      if (thickness[i] == 0 || adhesion[i] != 0) continue;
      const int triangle = surface_->triangle(static_cast<TexelIndex>(first) + i);
      const std::vector<Stacked>* stack = triangle < 0 ? nullptr : &stacks_[surface_->object(triangle)];
      if (stack && stack->size() > static_cast<std::size_t>(l) && (*stack)[l].cracks) loose_[first + i] |= bit;
    }
  }
}

void LayerAtlas::renew_tops(const RunControl& control) {
  parallel_for(std::int64_t{surface_->grid().num_tiles()}, 1024, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t tile = begin; tile < end; ++tile) renew_tops(static_cast<TileIndex>(tile));
  });
}

std::vector<std::int64_t> LayerAtlas::remaining(const RunControl& control) const {
  using Sums = std::vector<std::int64_t>;
  return parallel_reduce(
      std::int64_t{surface_->grid().num_texels()}, 1 << 16, control, Sums(accounts_.size()),
      [&](std::int64_t begin, std::int64_t end) {
        Sums sums(accounts_.size());
        for (auto t = static_cast<TexelIndex>(begin); t < end; ++t) {
          if (!surface_->is_covered(t)) continue;
          const int object = surface_->object(surface_->triangle(t));
          for (int l = 1; l < num_layers(object); ++l)
            sums[account_index(object, l)] += std::int64_t{thickness_.amount(l, t)} * surface_->weight(t);
        }
        return sums;
      },
      [](Sums a, const Sums& b) {
        for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
        return a;
      });
}

std::int64_t LayerAtlas::interface_mass(int material, const RunControl& control) const {
  std::int64_t sum = 0;
  for (const MaterialAtlas& interface : interfaces_) {
    for (std::uint32_t page = 0; page < surface_->grid().num_pages(); ++page) {
      if (interface.page(material, page).empty()) continue;
      sum += interface.mass(material, control);
      break;
    }
  }
  return sum;
}

void LayerAtlas::begin_accounts(const RunControl& control) {
  const std::vector<std::int64_t> there = remaining(control);
  std::fill(accounts_.begin(), accounts_.end(), LayerAccount{});
  for (std::size_t i = 0; i < there.size(); ++i) accounts_[i].start += there[i];
}

std::string LayerAtlas::audit(const RunControl& control) const {
  const std::vector<std::int64_t> there = remaining(control);
  for (int object = 0; object < num_objects(); ++object) {
    for (int l = 1; l < num_layers(object); ++l) {
      const LayerAccount& of = account(object, l);
      MassSum rest = of.start;
      rest -= of.worn;
      rest -= of.flaked;
      rest += -there[account_index(object, l)];
      if (rest != MassSum{})
        return "layer '" + name(object, l) + "': start - worn - flaked differs from what is there by " +
               number_text(rest.value()) + " quanta";
    }
  }
  return "";
}

std::string LayerAtlas::hash() const {
  ContentHash hash;
  hash.add(thickness_.hash());
  hash.add(adhesion_.hash());
  for (const MaterialAtlas& interface : interfaces_) hash.add(interface.hash());
  if (has_cracks()) {
    hash.add(stress_.hash());
    hash.add(crack_.hash());
    hash.add(std::as_bytes(std::span(tips_)));
  }
  return hash.hex();
}

std::size_t LayerAtlas::memory() const {
  std::size_t bytes = thickness_.memory() + adhesion_.memory() + stress_.memory() + strength_.memory() +
                      next_look_.memory() + crack_.memory() + tops_.size() + cracked_.size() + loose_.size();
  for (const MaterialAtlas& interface : interfaces_) bytes += interface.memory();
  return bytes;
}

std::vector<int> materials_at_interfaces(const Scene& scene) {
  std::array<bool, kMaxMaterials> is_made{};
  const auto add = [&](const LayerShares& shares) {
    for (std::size_t m = 0; m < kMaxMaterials; ++m) is_made[m] = is_made[m] || shares.at_interface[m] > 0.0;
  };
  const auto add_event = [&](const SceneAction& what) {
    const auto* event = std::get_if<RuleEvent>(&what);
    if (!event) return;
    if (event->change.layer_products) add(*event->change.layer_products);
    if (event->change.begins) add(event->change.begins->layer_products);
  };
  for (const Rule& rule : scene.rules) add(rule.layer_products);
  for (const SceneEvent& event : scene.events) add_event(event.what);
  for (const EventSeries& series : scene.series) add_event(series.what);
  std::vector<int> materials;
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    if (is_made[m]) materials.push_back(static_cast<int>(m));
  }
  return materials;
}

}  // namespace patinate::simulation
