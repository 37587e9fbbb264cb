#include "patinate/simulation/compose.h"

#include <algorithm>
#include <cstring>
#include <iterator>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"
#include "simulation/composition/composer_state.h"

namespace patinate::simulation {

using namespace composition;

namespace {

constexpr std::int64_t kChunk = 512;  // tiles
constexpr std::size_t kDense = 32;    // from a 32nd of the tiles on, looking at all is cheaper than lists

bool differ(const std::uint16_t* a, const std::uint16_t* b) {
  unsigned difference = 0;
  for (int l = 0; l < kTile; ++l) difference |= static_cast<unsigned>(a[l] ^ b[l]);
  return difference != 0;
}

/// Which edges of a tile differ, as State::kEdge has them.
unsigned changed_edges(const std::int32_t* a, const std::int32_t* b) {
  std::int32_t right = 0, left = 0, below = 0, above = 0;
  for (int l = 0; l < 8; ++l) {
    right |= a[8 * l + 7] ^ b[8 * l + 7];
    left |= a[8 * l] ^ b[8 * l];
    below |= a[56 + l] ^ b[56 + l];
    above |= a[l] ^ b[l];
  }
  return (right != 0 ? 1u : 0u) | (left != 0 ? 2u : 0u) | (below != 0 ? 4u : 0u) | (above != 0 ? 8u : 0u);
}

bool has_relief(const std::vector<QuantizedAppearance>& appearance) {
  return std::any_of(appearance.begin(), appearance.end(),
                     [](const QuantizedAppearance& look) { return look.height != 0; });
}

}  // namespace

Composer::State::State(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface_atlas,
                       ColorForm color_form, const RunControl& control)
    : surface(&surface_atlas),
      quanta_per_mm(kHeightQuanta / surface_atlas.median_texel_size_mm()),
      base(scene, scene_mesh, surface_atlas, quanta_per_mm, control.part(0.0, 0.7)),
      frames(scene_mesh, surface_atlas, control.part(0.7, 1.0)),
      texel_of_object(scene.objects.size(), kNoTexel),
      grain(scene_mesh, surface_atlas),
      form(color_form),
      kernels(&composition::kernels(instruction_set())),
      codes(surface_atlas.grid().num_texels()),
      normals(std::size_t{surface_atlas.grid().num_tiles()} * 3 * kTile),
      flags(surface_atlas.grid().num_tiles()),
      normal_flags(surface_atlas.grid().num_tiles()) {
  for (TileIndex tile = 0; tile < surface->grid().num_tiles(); ++tile) {
    if (base.object(tile) == BaseLayer::kNone) continue;
    covered_tiles.push_back(tile);
    for (std::uint32_t l = 0; l < kTile; ++l) {
      const int triangle = surface->triangle(tile * kTile + l);
      if (triangle >= 0) texel_of_object[static_cast<std::size_t>(surface->object(triangle))] = tile * kTile + l;
    }
    std::uint8_t* normal = normals.data() + std::size_t{tile} * 3 * kTile;
    std::fill_n(normal, 2 * kTile, std::uint8_t{128});
    std::fill_n(normal + 2 * kTile, kTile, std::uint8_t{255});
  }
  set_appearance(scene.appearance);
}

void Composer::State::set_appearance(const std::vector<MaterialAppearance>& new_appearance) {
  std::vector<QuantizedAppearance> quantized;
  std::vector<Picture> new_pictures;
  for (std::size_t i = 0; i < new_appearance.size(); ++i) {
    quantized.push_back(quantize(new_appearance[i], quanta_per_mm, noise_key(static_cast<int>(i))));
    new_pictures.push_back(make_picture(new_appearance[i].color.image));
  }
  std::vector<double> lengths;
  for (const MaterialAppearance& look : new_appearance) lengths.push_back(look.grain_mm);
  grain.set_lengths(lengths);
  appearance = std::move(quantized);
  pictures = std::move(new_pictures);
  if (heights.empty() && (base.has_heights() || has_relief(appearance)))
    heights.assign(surface->grid().num_texels(), 0);
  is_all_dirty = true;
}

void Composer::State::read_originals(const MaterialAtlas& atlas) {
  originals.resize(texel_of_object.size() * appearance.size());
  for (std::size_t object = 0; object < texel_of_object.size(); ++object) {
    for (std::size_t m = 0; m < appearance.size(); ++m) {
      const TexelIndex t = texel_of_object[object];
      originals[object * appearance.size() + m].fill(t == kNoTexel ? std::uint16_t{0}
                                                                   : atlas.original(static_cast<int>(m), t));
    }
  }
}

void Composer::State::prepare(const MaterialAtlas& atlas, TileIndex tile, TileInput& in) {
  const std::uint16_t object = base.object(tile);
  ComposeTask& task = in.task;
  task = ComposeTask{};
  task.first_texel = tile * kTile;
  for (std::size_t m = 0; m < appearance.size(); ++m) {
    const std::span<const std::uint16_t> amount = atlas.tile(static_cast<int>(m), tile);
    if (amount.empty()) continue;
    const std::uint16_t* original = in.originals[m];
    if (object != BaseLayer::kSeveral) {
      original = originals[object * appearance.size() + m].data();
    } else {
      for (std::uint32_t l = 0; l < kTile; ++l)
        in.originals[m][l] = atlas.original(static_cast<int>(m), task.first_texel + l);
    }
    if (!differ(amount.data(), original)) continue;
    const auto k = static_cast<std::size_t>(task.num_materials++);
    task.look[k] = &appearance[m];
    task.amount[k] = amount.data();
    task.original[k] = original;
    if (grain.has(m)) task.grain[k] = grain.tile(m, tile);
    if (pictures[m].empty()) continue;
    pictures[m].read_tile(surface->grid().x(task.first_texel), surface->grid().y(task.first_texel), in.pictures[m]);
    task.picture[k] = in.pictures[m];
  }
  task.base = &base.tile(tile, in.base);
  task.height = base.heights(tile);
  task.srgb = srgb8_of_linear16().data();
  task.is_published_form = form == ColorForm::Published ? 1 : 0;
}

void Composer::State::take(TileIndex tile, const std::uint32_t* new_codes, const std::int32_t* new_heights) {
  const std::size_t first = std::size_t{tile} * kTile;
  unsigned changed = kernels->replace(&codes[first], new_codes, kTile) ? kCodesChanged : 0u;
  if (!heights.empty()) {
    std::int32_t* old = &heights[first];
    const unsigned edges = changed_edges(old, new_heights);
    // As words: signed and unsigned may stand for one another.
    const bool is_changed = kernels->replace(reinterpret_cast<std::uint32_t*>(old),
                                             reinterpret_cast<const std::uint32_t*>(new_heights), kTile);
    if (is_changed) changed |= kHeightsChanged | edges * kEdge;
  }
  flags[tile] = static_cast<std::uint8_t>(changed);
}

void Composer::State::compose_tile(const MaterialAtlas& atlas, TileIndex tile) {
  TileInput in;
  prepare(atlas, tile, in);
  if (in.task.num_materials == 0) return take(tile, in.task.base->code, in.task.height);
  alignas(64) std::uint32_t rgba[kTile];
  alignas(64) std::int32_t height[kTile];
  kernels->compose(in.task, rgba, height);
  take(tile, rgba, height);
}

void Composer::State::slopes_of(TileIndex tile, SlopeTile& slopes) const {
  const std::array<TileIndex, 4> beside = tiles_beside(surface->grid(), tile);
  const auto heights_of = [&](TileIndex other) { return heights.data() + std::size_t{other} * kTile; };
  const NormalTask task{.here = heights_of(tile),
                        .right = heights_of(beside[0]),
                        .left = heights_of(beside[1]),
                        .below = heights_of(beside[2]),
                        .above = heights_of(beside[3]),
                        .triangle = surface->triangles().data() + std::size_t{tile} * kTile,
                        .frame = frames.frames().data()};
  kernels->slopes(task, slopes);
  for (const BorderTexel& texel : frames.border(tile)) {
    slopes.along_t[texel.texel % kTile] = kernels->border_slope(&texel, texel.along_t.data(), heights.data());
    slopes.along_b[texel.texel % kTile] = kernels->border_slope(&texel, texel.along_b.data(), heights.data());
  }
}

void Composer::State::compose_normals(TileIndex tile) {
  SlopeTile slopes;
  slopes_of(tile, slopes);
  alignas(64) std::uint8_t normal[3 * kTile];
  kernels->encode(slopes, normal);
  take_normals(tile, normal);
}

void Composer::State::take_normals(TileIndex tile, const std::uint8_t* normal) {
  constexpr std::size_t kSize = 3 * kTile;
  std::uint8_t* old = &normals[std::size_t{tile} * kSize];
  if (std::memcmp(old, normal, kSize) == 0) return;
  std::memcpy(old, normal, kSize);
  normal_flags[tile] = 1;
}

bool Composer::State::needs_normals(TileIndex tile) const {
  if ((flags[tile] & kHeightsChanged) != 0) return true;
  const std::array<TileIndex, 4> beside = tiles_beside(surface->grid(), tile);
  for (std::size_t k = 0; k < 4; ++k) {
    if ((flags[beside[k]] & kEdge << (k ^ 1)) != 0) return true;  // the right neighbor's left edge, and so on
  }
  for (const BorderTexel& texel : frames.border(tile)) {
    for (const TexelIndex n : texel.neighbor) {
      if ((flags[TileGrid::tile_of(n)] & kHeightsChanged) != 0) return true;
    }
  }
  return false;
}

std::vector<TileIndex> Composer::State::tiles_around(const std::vector<TileIndex>& tiles) {
  std::vector<TileIndex> around;
  const auto mark = [&](TileIndex tile) {
    if ((flags[tile] & kMarked) != 0 || base.object(tile) == BaseLayer::kNone) return;
    flags[tile] |= kMarked;
    around.push_back(tile);
  };
  for (const TileIndex tile : tiles) {
    if ((flags[tile] & kHeightsChanged) == 0) continue;
    mark(tile);
    const std::array<TileIndex, 4> beside = tiles_beside(surface->grid(), tile);
    for (std::size_t k = 0; k < 4; ++k) {
      if ((flags[tile] & kEdge << k) != 0 || !frames.border(beside[k]).empty()) mark(beside[k]);
    }
    for (const TileIndex other : frames.dependents(tile)) mark(other);
  }
  std::sort(around.begin(), around.end());
  return around;
}

Composer::Composer(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface, ColorForm form,
                   const RunControl& control)
    : state_(std::make_unique<State>(scene, scene_mesh, surface, form, control)) {}
Composer::~Composer() = default;
Composer::Composer(Composer&&) noexcept = default;
Composer& Composer::operator=(Composer&&) noexcept = default;

void Composer::set_appearance(const std::vector<MaterialAppearance>& appearance) {
  if (appearance.size() != state_->appearance.size()) {
    throw InvalidInput(std::to_string(appearance.size()) + " appearances were given for " +
                       std::to_string(state_->appearance.size()) + " materials");
  }
  state_->set_appearance(appearance);
}

void Composer::set_form(ColorForm form) {
  state_->is_all_dirty = state_->is_all_dirty || form != state_->form;
  state_->form = form;
}

void Composer::use(InstructionSet set) {
  if (!has_instruction_set(set))
    throw InvalidInput("this machine lacks " + std::string(kInstructionSetNames[static_cast<std::size_t>(set)]));
  state_->kernels = &composition::kernels(set);
}

void Composer::use(std::shared_ptr<const ComposeDevice> device) {
  state_->device = std::move(device);
  state_->on_device.reset();
}

std::vector<TileIndex> Composer::compose(const MaterialAtlas& atlas, std::span<const TileIndex> dirty,
                                         const RunControl& control) {
  State& s = *state_;
  if (&atlas.surface() != s.surface || atlas.num_materials() != static_cast<int>(s.appearance.size())) {
    throw InvalidInput("the atlas is not that of the composer");
  }
  const bool is_all = s.is_all_dirty;
  std::vector<TileIndex> tiles;
  for (const TileIndex tile : is_all ? std::span<const TileIndex>() : dirty) {
    if (tile >= s.flags.size()) throw InvalidInput("there is no tile " + std::to_string(tile));
    if (s.base.object(tile) != BaseLayer::kNone) tiles.push_back(tile);
  }
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  s.is_all_dirty = true;  // should this be canceled
  s.read_originals(atlas);
  const auto for_each = [&](const std::vector<TileIndex>& list, const RunControl& part, const auto& work) {
    parallel_for(static_cast<std::int64_t>(list.size()), kChunk, part, [&](std::int64_t begin, std::int64_t end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) work(list[i]);
    });
  };
  const std::vector<TileIndex>& first = is_all ? s.covered_tiles : tiles;
  std::vector<TileIndex> changed;
  try {
    const bool is_dense = first.size() * kDense > s.covered_tiles.size();
    if (!is_dense || !s.composed_on_device(atlas, first, control.part(0.0, 0.6)))
      for_each(first, control.part(0.0, 0.6), [&](TileIndex tile) { s.compose_tile(atlas, tile); });
    const std::vector<TileIndex> around =
        is_dense || s.heights.empty() ? std::vector<TileIndex>() : s.tiles_around(first);
    const RunControl rest = control.part(0.6, 1.0);
    std::vector<TileIndex> due;
    if (s.device && is_dense && !s.heights.empty())
      std::copy_if(s.covered_tiles.begin(), s.covered_tiles.end(), std::back_inserter(due),
                   [&](TileIndex tile) { return s.needs_normals(tile); });
    if (!due.empty() && s.normals_on_device(due, rest)) {
    } else if (is_dense && !s.heights.empty()) {
      for_each(s.covered_tiles, rest, [&](TileIndex tile) {
        if (s.needs_normals(tile)) s.compose_normals(tile);
      });
    } else {
      for_each(around, rest, [&](TileIndex tile) { s.compose_normals(tile); });
    }
    std::vector<TileIndex> seen;
    if (!is_dense) std::set_union(first.begin(), first.end(), around.begin(), around.end(), std::back_inserter(seen));
    for (const TileIndex tile : is_dense ? s.covered_tiles : seen) {
      if (((s.flags[tile] & ~State::kMarked) | s.normal_flags[tile]) != 0) changed.push_back(tile);
      s.flags[tile] = s.normal_flags[tile] = 0;
    }
  } catch (...) {  // canceled
    std::fill(s.flags.begin(), s.flags.end(), std::uint8_t{0});
    std::fill(s.normal_flags.begin(), s.normal_flags.end(), std::uint8_t{0});
    throw;
  }
  s.is_all_dirty = false;
  return changed;
}

}  // namespace patinate::simulation
