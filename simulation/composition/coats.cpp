#include "simulation/composition/coats.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulation/layers/crack_relief.h"

namespace patinate::simulation::composition {

namespace {

constexpr int kHeightShift = 20;

/// Objects as they look with their layer number `layer` outermost.
void put_on(const Scene& from, std::size_t layer, Scene& scene) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const std::vector<Layer>& layers = from.objects[i].layers;
    scene.objects[i].preset = layer < layers.size() ? layers[layer].look : Preset{};
  }
}

/// Without color, gloss and height maps, which are the substrates'.
Scene without_surfaces(const Scene& scene) {
  Scene copy = scene;
  for (SceneObject& object : copy.objects) object.color_map = object.specular_map = object.height_map = {};
  return copy;
}

void copy_texel(const BaseTile& from, std::size_t texel, BaseTile& to) {
  for (int c = 0; c < 3; ++c) to.linear[c][texel] = from.linear[c][texel];
  to.specular[texel] = from.specular[texel];
  to.code[texel] = from.code[texel];
}

/// The layer below the outermost one.
int next_below(const LayerAtlas& layers, TexelIndex texel) {
  int layer = layers.tops()[texel] - 1;
  while (layer > 0 && layers.thickness().amount(layer, texel) == 0) --layer;
  return layer;
}

/// Share of the light that comes to the ground of a crack: as much as to that of a groove with walls at right angles
/// and of half its depth.
double light_in(const LayerAtlas& layers, TexelIndex texel) {
  constexpr double kMmPerQuantum = 1e-3 / LayerAtlas::kQuantaPerUm;
  const int layer = layers.tops()[texel];
  const double width = crack_width_mm(layers, layer, texel);
  const double depth = layers.thickness().amount(layer, texel) * kMmPerQuantum;
  return width > 0.0 ? width / (width + depth) : 0.0;
}

/// @returns (1 - share) of one code's color and gloss, and the other's by `share`, its color darkened by `light`.
std::uint32_t mixed(std::uint32_t code, std::uint32_t other, double share, double light) {
  std::uint32_t out = 0;
  for (unsigned c = 0; c < 3; ++c) {
    const double own = linear16_of_srgb8()[code >> (8 * c) & 255], below = linear16_of_srgb8()[other >> (8 * c) & 255];
    const auto linear = static_cast<std::size_t>((1.0 - share) * own + share * light * below);
    out |= std::uint32_t{srgb8_of_linear16()[linear >> kSrgbShift]} << (8 * c);
  }
  const double gloss = (1.0 - share) * (code >> 24) + share * light * (other >> 24);
  return out | static_cast<std::uint32_t>(gloss + 0.5) << 24;
}

}  // namespace

Coats::Coats(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface, double quanta_per_mm,
             const RunControl& control) {
  if (!has_layers(scene)) return;
  texel_mm_ = surface.median_texel_size_mm();
  quanta_per_mm_ = quanta_per_mm;
  std::size_t most = 0;
  for (const SceneObject& object : scene.objects) most = std::max(most, object.layers.size());
  Scene coated = without_surfaces(scene);
  for (std::size_t l = 1; l < most; ++l) {
    put_on(scene, l, coated);
    looks_.emplace_back(coated, scene_mesh, surface, quanta_per_mm, control);
  }
  constexpr double kUmPerMm = 1000.0;
  height_scale_ = std::llround(std::ldexp(quanta_per_mm / (kUmPerMm * LayerAtlas::kQuantaPerUm), kHeightShift));
}

std::size_t Coats::memory() const {
  std::size_t bytes = 0;
  for (const BaseLayer& look : looks_) bytes += look.memory();
  return bytes;
}

void Coats::cover_look(TileIndex tile, Tile& own, ComposeTask& task) const {
  const std::uint8_t* tops = layers_->tops().data() + std::size_t{tile} * kTile;
  const auto [least, most] = std::minmax_element(tops, tops + kTile);
  if (*most == 0) return;
  if (*least == *most) {
    task.base = &looks_[*most - 1].tile(tile, own.base);
    return;
  }
  own.base = *task.base;
  for (std::uint8_t l = std::max<std::uint8_t>(1, *least); l <= *most; ++l) {
    const BaseTile& look = looks_[l - 1].tile(tile, own.buffer);
    for (std::size_t i = 0; i < kTile; ++i) {
      if (tops[i] == l) copy_texel(look, i, own.base);
    }
  }
  task.base = &own.base;
}

bool Coats::shows_crack(TexelIndex texel) const {
  return (layers_->cracked()[texel] >> layers_->tops()[texel] & 1) != 0;
}

bool Coats::is_cracked(TileIndex tile) const {
  if (!layers_->has_cracks()) return false;
  for (TexelIndex t = tile * kTile; t < (tile + 1) * kTile; ++t) {
    if (shows_crack(t)) return true;
  }
  return false;
}

double Coats::open_share(TexelIndex texel) const {
  return std::min(1.0, crack_width_mm(*layers_, layers_->tops()[texel], texel) / texel_mm_);
}

void Coats::draw_cracks(TileIndex tile, const BaseTile& substrate, Tile& own, ComposeTask& task) const {
  if (task.base != &own.base) own.base = *task.base;
  task.base = &own.base;
  for (int below = 0; below + 1 < layers_->num_layers(); ++below) {
    const BaseTile& look = below == 0 ? substrate : looks_[below - 1].tile(tile, own.buffer);
    for (std::size_t i = 0; i < kTile; ++i) {
      const TexelIndex t = tile * kTile + static_cast<TexelIndex>(i);
      if (!shows_crack(t) || next_below(*layers_, t) != below) continue;
      own.base.code[i] = mixed(own.base.code[i], look.code[i], open_share(t), light_in(*layers_, t));
      unpack(own.base.code[i], i, own.base);
    }
  }
}

void Coats::add_lifts(TileIndex tile, std::int32_t* heights) const {
  for (std::size_t i = 0; i < kTile; ++i) {
    const TexelIndex t = tile * kTile + static_cast<TexelIndex>(i);
    const int top = layers_->tops()[t];
    if ((layers_->loose()[t] >> top & 1) != 0)
      heights[i] += static_cast<std::int32_t>(std::lround(lift_mm(*layers_, top, t) * quanta_per_mm_));
  }
}

void Coats::add_heights(TileIndex tile, std::span<const QuantizedAppearance> looks, std::int32_t* heights) const {
  std::array<std::uint16_t, kTile> thickness;
  std::array<std::int64_t, kTile> sum{};
  for (int l = 1; l < layers_->num_layers(); ++l) {
    layers_->thickness().read_tile(l, tile, thickness);
    for (std::size_t i = 0; i < kTile; ++i) sum[i] += thickness[i];
  }
  if (layers_->has_cracks()) add_lifts(tile, heights);
  for (std::size_t i = 0; is_cracked(tile) && i < kTile; ++i) {
    const TexelIndex t = tile * kTile + static_cast<TexelIndex>(i);
    if (shows_crack(t)) sum[i] -= std::llround(open_share(t) * layers_->thickness().amount(layers_->tops()[t], t));
  }
  for (std::size_t i = 0; i < kTile; ++i)
    heights[i] += static_cast<std::int32_t>((sum[i] * height_scale_ + (1 << (kHeightShift - 1))) >> kHeightShift);
  for (int l = 1; l < layers_->num_layers(); ++l) {
    for (std::size_t m = 0; m < looks.size(); ++m) {
      if (looks[m].height == 0) continue;
      const std::span<const std::uint16_t> below = layers_->interface_below(l).tile(static_cast<int>(m), tile);
      for (std::size_t i = 0; i < below.size(); ++i) {
        const std::int64_t lift = std::int64_t{below[i]} * looks[m].height >> looks[m].height_shift;
        heights[i] += static_cast<std::int32_t>(std::clamp<std::int64_t>(lift, -kMaxHeight, kMaxHeight));
      }
    }
  }
  for (std::size_t i = 0; i < kTile; ++i) heights[i] = std::clamp(heights[i], -kMaxHeight, kMaxHeight);
}

void Coats::cover(TileIndex tile, std::span<const QuantizedAppearance> looks, Tile& own, ComposeTask& task) const {
  if (layers_ == nullptr) return;
  const BaseTile& substrate = *task.base;
  cover_look(tile, own, task);
  if (is_cracked(tile)) draw_cracks(tile, substrate, own, task);
  std::copy_n(task.height, kTile, own.heights);
  add_heights(tile, looks, own.heights);
  task.height = own.heights;
}

}  // namespace patinate::simulation::composition
