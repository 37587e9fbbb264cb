#include "simulation/rules/layer_tile.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace patinate::simulation {

namespace {

constexpr std::int32_t kMaxStored = 65535;  ///< kMaxQuanta of rule_kernel.inl.
constexpr float kUmPerQuantum = 1.0F / LayerAtlas::kQuantaPerUm;
constexpr float kAmountPerQuantum = 1.0F / static_cast<float>(kAmountOne);
constexpr int kSide = TileGrid::kTileSide;
/// Speeds of straight and of diagonal edges are alike: in a diagonal one a texel ends at two sides, and the next row is
/// 1 / sqrt(2) texels away.
constexpr std::array<float, 5> kRoots{0.0F, 1.0F, 1.41421356F, 1.73205081F, 2.0F};

void read_quanta(const MaterialAtlas& atlas, int layer, TileIndex tile, bool is_uniform, LayerTile::Quanta& out) {
  const std::span<const std::uint16_t> stored = atlas.tile(layer, tile);
  if (!stored.empty()) {
    std::copy(stored.begin(), stored.end(), out.begin());
  } else if (is_uniform) {
    out.fill(atlas.original(layer, tile * TileGrid::kTileTexels));
  } else {
    atlas.read_tile(layer, tile, out);
  }
}

void write_quanta(const LayerTile::Quanta& quanta, int layer, TileIndex tile, MaterialAtlas& atlas) {
  const std::span<std::uint16_t> stored = atlas.writable_tile(layer, tile);
  std::copy(quanta.begin(), quanta.end(), stored.begin());
}

/// Moves what fits. @returns what does not.
std::int64_t add_quanta(std::uint16_t more, std::uint16_t& to) {
  const std::uint32_t sum = std::uint32_t{to} + more, kept = std::min(sum, kMaxAmount);
  to = static_cast<std::uint16_t>(kept);
  return sum - kept;
}

}  // namespace

LayerNames layer_names_of(const LayerAtlas& layers) {
  LayerNames out;
  for (int object = 0; object < layers.num_objects(); ++object) {
    for (int l = 0; l < layers.num_layers(object); ++l) {
      const std::string& name = layers.name(object, l);
      if (l > 0 && std::find(out.names.begin(), out.names.end(), name) == out.names.end()) out.names.push_back(name);
      for (std::size_t m = 0; m < kMaxMaterials; ++m)
        out.is_part_of[m] = out.is_part_of[m] || layers.composition(object, l)[m] > 0.0;
    }
  }
  return out;
}

std::vector<TileIndex> tiles_at(TileIndex tile, const SurfaceAtlas& surface) {
  std::vector<TileIndex> tiles{tile};
  if (surface.is_plain(tile)) {
    const TileGrid& grid = surface.grid();
    const TexelIndex first = tile * TileGrid::kTileTexels;
    for (const auto& [dx, dy] : {std::array{-1, 0}, {kSide, 0}, {0, -1}, {0, kSide}})
      tiles.push_back(TileGrid::tile_of(grid.index(grid.x(first) + dx, grid.y(first) + dy)));
    return tiles;
  }
  for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
    const TexelIndex t = tile * TileGrid::kTileTexels + i;
    if (!surface.is_covered(t)) continue;
    std::array<SurfaceAtlas::Link, 4> plain;
    for (const SurfaceAtlas::Link& link : surface.links(t, plain)) tiles.push_back(TileGrid::tile_of(link.texel));
  }
  return tiles;
}

LayerFacts::LayerFacts(const LayerAtlas& layer_atlas, const CompiledRules& compiled, const TileFacts& tile_facts)
    : layers(&layer_atlas), rules(&compiled), facts(&tile_facts), composition(layer_atlas.num_objects()) {
  edge_per_mm = static_cast<float>(1.0 / layer_atlas.surface().median_texel_size_mm());
  for (int object = 0; object < layer_atlas.num_objects(); ++object) {
    for (int l = 0; l < layer_atlas.num_layers(object); ++l) {
      for (std::size_t m = 0; m < kMaxMaterials; ++m)
        composition[object][l][m] = static_cast<float>(layer_atlas.composition(object, l)[m]);
    }
  }
  for (const std::string& name : compiled.targets) {
    std::vector<std::int8_t>& of = targets.emplace_back();
    for (int object = 0; object < layer_atlas.num_objects(); ++object)
      of.push_back(static_cast<std::int8_t>(layer_atlas.layer_named(object, name)));
  }
}

void LayerSums::enter(std::span<LayerAccount> accounts) {
  for (std::size_t i = 0; i < worn.size(); ++i) {
    accounts[i].worn += std::exchange(worn[i], 0);
    accounts[i].flaked += std::exchange(flaked[i], 0);
  }
}

void LayerTile::load(TileIndex tile) {
  const LayerAtlas& layers = *f_->layers;
  const SurfaceAtlas& surface = layers.surface();
  const bool is_uniform = f_->facts->is_uniform(tile);
  tile_ = tile;
  num_layers_ = layers.num_layers();
  has_one_object_ = is_uniform;
  if (is_uniform) {
    object_.fill(static_cast<std::uint16_t>(surface.object(surface.triangle(tile * TileGrid::kTileTexels))));
  } else {
    for (std::uint32_t i = 0; i < kTile; ++i) {
      const int triangle = surface.triangle(tile * TileGrid::kTileTexels + i);
      object_[i] = static_cast<std::uint16_t>(triangle < 0 ? 0 : surface.object(triangle));
    }
  }
  std::copy_n(layers.tops().data() + std::size_t{tile} * kTile, kTile, top_.begin());
  for (int l = 1; l < num_layers_; ++l) {
    read_quanta(layers.thickness(), l, tile, is_uniform, thickness_[l]);
    read_quanta(layers.adhesion(), l, tile, is_uniform, adhesion_[l]);
    if (layers.has_cracks()) read_quanta(layers.stress(), l, tile, true, stress_[l]);
  }
  has_new_thickness_.fill(false);
  has_new_stress_.fill(false);
  has_new_adhesion_.fill(false);
  interfaces_.resize(f_->rules->layer_states.size());
  for (std::size_t s = 0; s < interfaces_.size(); ++s) {
    const LayerState& state = f_->rules->layer_states[s];
    if (state.kind != LayerStateKind::Interface) continue;
    interfaces_[s].is_new.fill(false);
    for (int l = 1; l < num_layers_; ++l)
      read_quanta(layers.interface_below(l), state.material, tile, true, interfaces_[s].amounts[l]);
  }
}

void LayerTile::find_acting(const CompiledRule& rule) {
  const std::vector<std::int8_t>& of_object = f_->targets[rule.target];
  for (std::size_t i = 0; i < kTile; ++i) {
    const int layer = rule.target == 0 ? top_[i] : of_object[object_[i]];
    acting_[i] = static_cast<std::int8_t>(layer >= 1 && thickness_[layer][i] != 0 ? layer : -1);
  }
  const bool is_one = std::all_of(acting_.begin(), acting_.end(), [&](std::int8_t l) { return l == acting_[0]; });
  acting_everywhere_ = is_one ? acting_[0] : -1;
}

void LayerTile::gather(const std::array<Quanta, kMaxLayers>& planes, Quanta& out) const {
  if (acting_everywhere_ >= 0) {
    out = planes[acting_everywhere_];
    return;
  }
  for (std::size_t i = 0; i < kTile; ++i) out[i] = acting_[i] < 0 ? std::uint16_t{0} : planes[acting_[i]][i];
}

void LayerTile::fill_composition(const std::array<std::uint8_t, kTile>& layer, int material, float* out) const {
  for (std::size_t i = 0; i < kTile; ++i) out[i] = f_->composition[object_[i]][layer[i]][material];
}

void LayerTile::fill_edge(float* out) const {
  const LayerAtlas& layers = *f_->layers;
  if (!layers.has_cracks())
    return fill_edge([tops = layers.tops()](TexelIndex t, std::int8_t layer) { return tops[t] < layer; }, out);
  fill_edge([&layers](TexelIndex t,
                      std::int8_t layer) { return layers.is_open(layer, t) || (layers.loose()[t] >> layer & 1) != 0; },
            out);
}

/// @param is_open  is_open(texel, layer): whether the layer ends there.
template <class IsOpen>
void LayerTile::fill_edge(IsOpen&& is_open, float* out) const {
  const SurfaceAtlas& surface = f_->layers->surface();
  const TileGrid& grid = surface.grid();
  const auto count = [&](std::size_t i, TexelIndex neighbor) { return is_open(neighbor, acting_[i]) ? 1 : 0; };
  const TexelIndex first = tile_ * TileGrid::kTileTexels;
  const int x0 = grid.x(first), y0 = grid.y(first);
  for (std::size_t i = 0; i < kTile; ++i) {
    int num_gone = 0;
    if (acting_[i] >= 0) {
      const int x = static_cast<int>(i) % kSide, y = static_cast<int>(i) / kSide;
      const bool is_inner = x > 0 && x < kSide - 1 && y > 0 && y < kSide - 1;
      if (surface.is_plain(tile_) && is_inner) {
        const auto t = first + static_cast<TexelIndex>(i);
        num_gone = count(i, t + 1) + count(i, t - 1) + count(i, t + kSide) + count(i, t - kSide);
      } else if (surface.is_plain(tile_)) {
        num_gone = count(i, grid.index(x0 + x + 1, y0 + y)) + count(i, grid.index(x0 + x - 1, y0 + y)) +
                   count(i, grid.index(x0 + x, y0 + y + 1)) + count(i, grid.index(x0 + x, y0 + y - 1));
      } else if (surface.is_covered(first + static_cast<TexelIndex>(i))) {
        for (const TexelIndex n : surface.neighbors(first + static_cast<TexelIndex>(i)))
          num_gone += n == kNoTexel ? 0 : count(i, n);
      }
    }
    out[i] = kRoots[num_gone] * f_->edge_per_mm;
  }
}

void LayerTile::fill(const LayerValue& value, const float* slots, float* out) const {
  Quanta quanta;
  const auto scaled = [&](float one) {
    for (std::size_t i = 0; i < kTile; ++i) out[i] = static_cast<float>(quanta[i]) * one;
  };
  switch (value.kind) {
    case LayerValueKind::Top:
      return fill_composition(top_, value.material, out);
    case LayerValueKind::Whole: {
      fill_composition(top_, value.material, out);
      const float* amounts = slots + std::size_t(f_->rules->slot_of_material(value.material)) * kTile;
      for (std::size_t i = 0; i < kTile; ++i) out[i] += amounts[i];
      return;
    }
    case LayerValueKind::Below: {
      for (std::size_t i = 0; i < kTile; ++i) {
        int layer = acting_[i] - 1;
        while (layer > 0 && thickness_[layer][i] == 0) --layer;
        out[i] = layer < 0 ? 0.0F : f_->composition[object_[i]][layer][value.material];
      }
      return;
    }
    case LayerValueKind::Interface: {
      const auto& states = f_->rules->layer_states;
      const LayerState state{LayerStateKind::Interface, value.material};
      gather(interfaces_[std::find(states.begin(), states.end(), state) - states.begin()].amounts, quanta);
      return scaled(kAmountPerQuantum);
    }
    case LayerValueKind::Thickness:
      gather(thickness_, quanta);
      return scaled(kUmPerQuantum);
    case LayerValueKind::Depth: {
      std::array<std::int32_t, kTile> sum{};
      for (int l = 1; l < num_layers_; ++l) {
        for (std::size_t i = 0; i < kTile; ++i) sum[i] += acting_[i] > 0 && acting_[i] <= l ? thickness_[l][i] : 0;
      }
      for (std::size_t i = 0; i < kTile; ++i) out[i] = static_cast<float>(sum[i]) * kUmPerQuantum;
      return;
    }
    case LayerValueKind::Adhesion:
      gather(adhesion_, quanta);
      return scaled(kAmountPerQuantum);
    case LayerValueKind::Edge:
      return fill_edge(out);
    case LayerValueKind::Stress:
      gather(stress_, quanta);
      return scaled(kAmountPerQuantum);
    case LayerValueKind::Crack: {
      const std::span<const std::uint8_t> cracked = f_->layers->cracked();
      for (std::size_t i = 0; i < kTile; ++i) {
        const bool is_cracked =
            !cracked.empty() && acting_[i] >= 0 && (cracked[tile_ * kTile + i] >> acting_[i] & 1) != 0;
        out[i] = is_cracked ? 1.0F : 0.0F;
      }
    }
  }
}

const std::array<LayerTile::Quanta, kMaxLayers>& LayerTile::planes_of(std::size_t state) const {
  switch (f_->rules->layer_states[state].kind) {
    case LayerStateKind::Wear:
      return thickness_;
    case LayerStateKind::Loosening:
      return adhesion_;
    case LayerStateKind::Stress:
      return stress_;
    case LayerStateKind::Interface:
      break;
  }
  return interfaces_[state].amounts;
}

std::array<LayerTile::Quanta, kMaxLayers>& LayerTile::planes_of(std::size_t state) {
  return const_cast<std::array<Quanta, kMaxLayers>&>(std::as_const(*this).planes_of(state));  // own ones
}

void LayerTile::fill_state(std::size_t state, float* amounts, std::int32_t* quanta) const {
  const LayerStateKind kind = f_->rules->layer_states[state].kind;
  Quanta stored;
  gather(planes_of(state), stored);
  const bool is_rest = kind == LayerStateKind::Wear || kind == LayerStateKind::Loosening;
  for (std::size_t i = 0; i < kTile; ++i) {
    quanta[i] = is_rest ? kMaxStored - stored[i] : stored[i];
    amounts[i] = static_cast<float>(quanta[i]) * kAmountPerQuantum;
  }
}

const float* LayerTile::begin(const CompiledRule& rule, const float* covered, float* slots, std::int32_t* quanta) {
  const CompiledRules& rules = *f_->rules;
  find_acting(rule);
  const std::size_t first_value = static_cast<std::size_t>(rules.first_layer_value);
  for (const std::size_t v : rule.values) fill(rules.layer_values[v], slots, slots + (first_value + v) * kTile);
  for (const std::size_t s : rule.states) {
    const std::size_t slot = (rules.materials.size() + s) * kTile;
    fill_state(s, slots + slot, quanta + slot);
  }
  if (!rule.acts_on_layer) return covered;
  for (std::size_t i = 0; i < kTile; ++i) where_[i] = acting_[i] < 0 ? 0.0F : covered[i];
  return where_.data();
}

void LayerTile::end(const CompiledRule& rule, const std::int32_t* quanta,
                    const std::array<std::uint32_t, kTile>& weights, LayerSums& sums) {
  const std::size_t num_materials = f_->rules->materials.size();
  for (const std::size_t s : rule.states) {
    const LayerStateKind kind = f_->rules->layer_states[s].kind;
    const std::int32_t* now = quanta + (num_materials + s) * kTile;
    std::array<Quanta, kMaxLayers>& planes = planes_of(s);
    std::array<bool, kMaxLayers>& is_new = kind == LayerStateKind::Wear        ? has_new_thickness_
                                           : kind == LayerStateKind::Loosening ? has_new_adhesion_
                                           : kind == LayerStateKind::Stress    ? has_new_stress_
                                                                               : interfaces_[s].is_new;
    const bool is_rest = kind == LayerStateKind::Wear || kind == LayerStateKind::Loosening;
    for (std::size_t i = 0; i < kTile; ++i) {
      if (acting_[i] < 0) continue;
      const auto stored = static_cast<std::uint16_t>(is_rest ? kMaxStored - now[i] : now[i]);
      std::uint16_t& own = planes[acting_[i]][i];
      if (stored == own) continue;
      if (kind == LayerStateKind::Wear)
        sums.worn[LayerAtlas::account_index(object_[i], acting_[i])] += std::int64_t{own - stored} * weights[i];
      own = stored;
      is_new[acting_[i]] = true;
    }
  }
}

void LayerTile::drop(std::size_t texel, int layer, LayerSums& sums) {
  const auto at = tile_ * TileGrid::kTileTexels + static_cast<TexelIndex>(texel);
  if (thickness_[layer][texel] == 0) return;
  for (int above = layer; above < num_layers_; ++above) {
    std::uint16_t& thickness = thickness_[above][texel];
    if (thickness == 0) continue;
    sums.flaked[LayerAtlas::account_index(object_[texel], above)] +=
        std::int64_t{thickness} * f_->layers->surface().weight(at);
    thickness = 0;
    has_new_thickness_[above] = true;
  }
}

bool LayerTile::does_crack(std::size_t texel, int layer) const {
  const LayerAtlas& layers = *f_->layers;
  return layers.has_cracks() && layer < layers.num_layers(object_[texel]) && layers.cracks(object_[texel], layer);
}

/// Before thicknesses are stored.
void LayerTile::drop_loose_layers(LayerSums& sums) {
  for (int l = 1; l < num_layers_; ++l) {
    unsigned any = 0;
    for (std::size_t i = 0; i < kTile; ++i) any |= (thickness_[l][i] != 0 && adhesion_[l][i] == 0) ? 1U : 0U;
    if (any == 0) continue;
    for (std::size_t i = 0; i < kTile; ++i) {
      if (thickness_[l][i] != 0 && adhesion_[l][i] == 0 && !does_crack(i, l)) drop(i, l, sums);
    }
  }
}

void LayerTile::find_loosened(std::vector<LayerTexel>& out) const {
  const std::uint8_t* loose = f_->layers->loose().data() + std::size_t{tile_} * kTile;
  for (int l = 1; l < num_layers_; ++l) {
    if (!has_new_adhesion_[l]) continue;
    for (std::size_t i = 0; i < kTile; ++i) {
      if (adhesion_[l][i] == 0 && thickness_[l][i] != 0 && (loose[i] >> l & 1) == 0 && does_crack(i, l))
        out.push_back({.texel = tile_ * TileGrid::kTileTexels + static_cast<TexelIndex>(i),
                       .layer = static_cast<std::uint32_t>(l)});
    }
  }
}

/// After everything is stored.
void LayerTile::uncover(LayerAtlas& layers, MaterialAtlas& atlas, LayerSums& sums) const {
  for (int l = 1; l < num_layers_; ++l) {
    for (int m = 0; m < atlas.num_materials(); ++m) {
      if (layers.interface_below(l).tile(m, tile_).empty()) continue;
      const std::span<std::uint16_t> from = layers.interface_below(l).writable_tile(m, tile_);
      for (std::size_t i = 0; i < kTile; ++i) {
        if (from[i] == 0 || thickness_[l][i] != 0) continue;
        int above = l + 1;
        while (above < num_layers_ && thickness_[above][i] == 0) ++above;
        std::uint16_t& to = above < num_layers_ ? layers.interface_below(above).writable_tile(m, tile_)[i]
                                                : atlas.writable_tile(m, tile_)[i];
        sums.overflow[m] += add_quanta(from[i], to) *
                            layers.surface().weight(tile_ * TileGrid::kTileTexels + static_cast<TexelIndex>(i));
        from[i] = 0;
      }
    }
  }
}

bool LayerTile::store(LayerAtlas& layers, MaterialAtlas& atlas, LayerSums& sums, bool& is_opened) {
  drop_loose_layers(sums);
  bool is_changed = false;
  for (int l = 1; l < num_layers_; ++l) {
    if (has_new_thickness_[l]) write_quanta(thickness_[l], l, tile_, layers.thickness());
    if (has_new_adhesion_[l]) write_quanta(adhesion_[l], l, tile_, layers.adhesion());
    if (has_new_stress_[l]) write_quanta(stress_[l], l, tile_, layers.stress());
    is_changed = is_changed || has_new_thickness_[l] || has_new_adhesion_[l] || has_new_stress_[l];
    for (std::size_t s = 0; s < interfaces_.size(); ++s) {
      const LayerState& state = f_->rules->layer_states[s];
      if (state.kind != LayerStateKind::Interface || !interfaces_[s].is_new[l]) continue;
      write_quanta(interfaces_[s].amounts[l], state.material, tile_, layers.interface_below(l));
      is_changed = true;
    }
  }
  bool is_gone = false;
  for (int l = 1; l < num_layers_ && !is_gone; ++l)
    is_gone = has_new_thickness_[l] && std::find(thickness_[l].begin(), thickness_[l].end(), 0) != thickness_[l].end();
  if (!is_gone) return is_changed;
  uncover(layers, atlas, sums);
  for (std::size_t i = 0; i < kTile; ++i) {
    int top = num_layers_ - 1;
    while (top > 0 && thickness_[top][i] == 0) --top;
    is_opened = is_opened || top != top_[i];
  }
  return true;
}

}  // namespace patinate::simulation
