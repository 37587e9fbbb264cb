#include "patinate/simulation/compose.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"
#include "simulation/composition/composer_state.h"

namespace patinate::simulation {

using namespace composition;

namespace {

constexpr std::int64_t kChunk = 512;  // tiles
constexpr std::size_t kAhead = 3;     // tiles that memory is asked for before their turn

bool differ(const std::uint16_t* a, const std::uint16_t* b) {
  unsigned difference = 0;
  for (int l = 0; l < kTile; ++l) difference |= static_cast<unsigned>(a[l] ^ b[l]);
  return difference != 0;
}

/// Edges of a tile that differ: bits for right, left, lower and upper.
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

void prefetch_lines(const void* first, std::size_t num_bytes) {
  for (std::size_t b = 0; b < num_bytes; b += 64) __builtin_prefetch(static_cast<const char*>(first) + b, 1);
}

bool has_relief(const std::vector<QuantizedAppearance>& appearance) {
  return std::any_of(appearance.begin(), appearance.end(),
                     [](const QuantizedAppearance& look) { return look.height != 0; });
}

}  // namespace

ComposerParts::ComposerParts(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface_atlas,
                             ColorForm color_form, const RunControl& control)
    : surface(&surface_atlas),
      quanta_per_mm(kHeightQuanta / surface_atlas.median_texel_size_mm()),
      base(scene, scene_mesh, surface_atlas, quanta_per_mm, control.part(0.0, 0.6)),
      coats(scene, scene_mesh, surface_atlas, quanta_per_mm, control.part(0.6, 0.7)),
      frames(scene_mesh, surface_atlas, control.part(0.7, 1.0)),
      is_whole(surface_atlas.grid().num_tiles(), false),
      texel_of_object(scene.objects.size(), kNoTexel),
      places(scene_mesh, surface_atlas),
      pictures(places),
      grain(places),
      form(color_form) {
  for (TileIndex tile = 0; tile < surface->grid().num_tiles(); ++tile) {
    if (base.object(tile) == BaseLayer::kNone) continue;
    covered_tiles.push_back(tile);
    int num_covered = 0;
    for (std::uint32_t l = 0; l < kTile; ++l) {
      const int triangle = surface->triangle(tile * kTile + l);
      if (triangle < 0) continue;
      ++num_covered;
      texel_of_object[surface->object(triangle)] = tile * kTile + l;
    }
    is_whole[tile] = num_covered == kTile;
  }
}

std::uint16_t ComposerParts::original(std::size_t material, TexelIndex texel) const {
  const int triangle = surface->triangle(texel);
  if (triangle < 0) return 0;
  return originals[static_cast<std::size_t>(surface->object(triangle)) * appearance.size() + material][0];
}

Composer::State::State(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface_atlas,
                       ColorForm color_form, const RunControl& control)
    : ComposerParts(scene, scene_mesh, surface_atlas, color_form, control),
      kernels(&composition::kernels(instruction_set())),
      codes(surface_atlas.grid().num_texels()),
      normals(std::size_t{surface_atlas.grid().num_tiles()} * 3 * kTile),
      changed(surface_atlas.grid().num_pages()),
      stale_normals(surface_atlas.grid().num_pages()) {
  for (const TileIndex tile : covered_tiles) {
    std::uint8_t* normal = normals.data() + std::size_t{tile} * 3 * kTile;
    std::fill_n(normal, 2 * kTile, std::uint8_t{128});
    std::fill_n(normal + 2 * kTile, kTile, std::uint8_t{255});
  }
  set_appearance(scene.appearance);
}

void Composer::State::set_appearance(const std::vector<MaterialAppearance>& new_appearance) {
  std::vector<QuantizedAppearance> quantized;
  for (std::size_t i = 0; i < new_appearance.size(); ++i) {
    quantized.push_back(quantize(new_appearance[i], quanta_per_mm, noise_key(static_cast<int>(i))));
  }
  std::vector<double> lengths;
  for (const MaterialAppearance& look : new_appearance) lengths.push_back(look.grain_mm);
  grain.set_lengths(lengths);
  pictures.set(new_appearance);
  appearance = std::move(quantized);
  if (heights.empty() && (base.has_heights() || coats.has_any() || has_relief(appearance)))
    heights.assign(surface->grid().num_texels(), 0);
  is_all_dirty = true;
  there.reset();
}

void Composer::State::read_originals(const MaterialAtlas& atlas) {
  originals.resize(texel_of_object.size() * appearance.size());
  has_no_originals.assign(texel_of_object.size(), true);
  for (std::size_t object = 0; object < texel_of_object.size(); ++object) {
    for (std::size_t m = 0; m < appearance.size(); ++m) {
      const TexelIndex t = texel_of_object[object];
      originals[object * appearance.size() + m].fill(t == kNoTexel ? std::uint16_t{0}
                                                                   : atlas.original(static_cast<int>(m), t));
      if (originals[object * appearance.size() + m][0] != 0) has_no_originals[object] = false;
    }
  }
}

void Composer::State::prepare(const MaterialAtlas& atlas, TileIndex tile, TileInput& in) {
  const std::uint16_t object = base.object(tile);
  // Amounts of uncovered texels do not count.
  const bool has_shared = has_shared_originals(tile);
  ComposeTask& task = in.task;
  task = ComposeTask{};
  task.first_texel = tile * kTile;
  for (std::size_t m = 0; m < appearance.size(); ++m) {
    const std::span<const std::uint16_t> amount = atlas.tile(static_cast<int>(m), tile);
    if (amount.empty()) continue;
    const std::uint16_t* original = in.originals[m];
    if (has_shared) {
      original = originals[object * appearance.size() + m].data();
    } else {
      for (std::uint32_t l = 0; l < kTile; ++l) in.originals[m][l] = this->original(m, task.first_texel + l);
    }
    if (!differ(amount.data(), original)) continue;
    const auto k = static_cast<std::size_t>(task.num_materials++);
    task.look[k] = &appearance[m];
    task.amount[k] = amount.data();
    task.original[k] = original;
    if (grain.has(m)) task.grain[k] = grain.tile(m, tile);
    if (!pictures.has(m)) continue;
    pictures.read_tile(m, tile, in.pictures[m]);
    task.picture[k] = in.pictures[m];
  }
  task.base = &base.tile(tile, in.base);
  task.height = base.heights(tile);
  if (coats.has_any()) coats.cover(tile, appearance, in.coats, task);
  task.srgb = srgb8_of_linear16().data();
  task.form = static_cast<std::int32_t>(form);
}

void Composer::State::take(TileIndex tile, const std::uint32_t* new_codes, const std::int32_t* new_heights) {
  const std::size_t first = std::size_t{tile} * kTile;
  if (kernels->replace(&codes[first], new_codes, kTile)) changed.add(tile);
  if (!heights.empty()) {
    std::int32_t* old = &heights[first];
    const unsigned edges = changed_edges(old, new_heights);
    // Compares words: signed and unsigned may stand for one another.
    const bool is_changed = kernels->replace(reinterpret_cast<std::uint32_t*>(old),
                                             reinterpret_cast<const std::uint32_t*>(new_heights), kTile);
    if (is_changed) {
      changed.add(tile);
      mark_slopes(tile, edges);
    }
  }
}

void Composer::State::mark_slopes(TileIndex tile, unsigned edges) {
  const auto mark = [&](TileIndex other) {
    if (base.object(other) != BaseLayer::kNone) stale_normals.add(other);
  };
  mark(tile);
  const std::array<TileIndex, 4> beside = tiles_beside(surface->grid(), tile);
  for (std::size_t k = 0; k < 4; ++k) {
    if ((edges & 1u << k) != 0 || !frames.border(beside[k]).empty()) mark(beside[k]);
  }
  for (const TileIndex other : frames.dependents(tile)) mark(other);
}

void Composer::State::prefetch(const MaterialAtlas& atlas, TileIndex tile) const {
  for (std::size_t m = 0; m < appearance.size(); ++m) {
    const std::span<const std::uint16_t> amount = atlas.tile(static_cast<int>(m), tile);
    if (!amount.empty()) prefetch_lines(amount.data(), kTile * sizeof(std::uint16_t));
  }
  prefetch_lines(&codes[std::size_t{tile} * kTile], kTile * sizeof(std::uint32_t));
  if (!heights.empty()) prefetch_lines(&heights[std::size_t{tile} * kTile], kTile * sizeof(std::int32_t));
}

void Composer::State::prefetch_heights(TileIndex tile) const {
  prefetch_lines(&heights[std::size_t{tile} * kTile], kTile * sizeof(std::int32_t));
  prefetch_lines(&normals[std::size_t{tile} * 3 * kTile], 3 * kTile);
  prefetch_lines(surface->triangles().data() + std::size_t{tile} * kTile, kTile * sizeof(std::int32_t));
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
  changed.add(tile);
}

std::vector<TileIndex> TileSet::take() {
  std::vector<TileIndex> tiles;
  for (std::size_t page = 0; page < pages_.size(); ++page) {
    for (std::uint64_t bits = pages_[page].exchange(0, std::memory_order_relaxed); bits != 0; bits &= bits - 1) {
      tiles.push_back(static_cast<TileIndex>(page) * TileGrid::kPageTiles +
                      static_cast<std::uint32_t>(std::countr_zero(bits)));
    }
  }
  return tiles;
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
  state_->bring_back();
  state_->set_appearance(appearance);
}

void Composer::set_form(ColorForm form) {
  state_->bring_back();
  if (form == state_->form) return;
  state_->is_all_dirty = true;
  state_->there.reset();
  state_->form = form;
}

void Composer::set_layers(const LayerAtlas* layers) {
  state_->bring_back();
  state_->is_all_dirty = true;
  state_->coats.set(layers);
}

void Composer::use(InstructionSet set) {
  if (!has_instruction_set(set))
    throw InvalidInput("this machine lacks " + std::string(kInstructionSetNames[static_cast<std::size_t>(set)]));
  state_->kernels = &composition::kernels(set);
}

std::vector<TileIndex> Composer::compose(const MaterialAtlas& atlas, std::span<const TileIndex> dirty,
                                         const RunControl& control) {
  State& s = *state_;
  if (&atlas.surface() != s.surface || atlas.num_materials() != static_cast<int>(s.appearance.size())) {
    throw InvalidInput("the atlas is not that of the composer");
  }
  s.bring_back();
  s.there.reset();  // Its content is old from now on.
  const bool is_all = s.is_all_dirty;
  std::vector<TileIndex> tiles;
  for (const TileIndex tile : is_all ? std::span<const TileIndex>() : dirty) {
    if (tile >= s.surface->grid().num_tiles()) throw InvalidInput("there is no tile " + std::to_string(tile));
    if (s.base.object(tile) != BaseLayer::kNone) tiles.push_back(tile);
  }
  const auto is_behind = [](TileIndex a, TileIndex b) { return a >= b; };
  if (std::adjacent_find(tiles.begin(), tiles.end(), is_behind) != tiles.end()) {
    std::sort(tiles.begin(), tiles.end());
    tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  }
  s.is_all_dirty = true;  // should this be canceled
  s.read_originals(atlas);
  const auto for_each = [&](const std::vector<TileIndex>& list, const RunControl& part, const auto& ask,
                            const auto& work) {
    parallel_for(static_cast<std::int64_t>(list.size()), kChunk, part, [&](std::int64_t begin, std::int64_t end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
        if (i + kAhead < static_cast<std::size_t>(end)) ask(list[i + kAhead]);
        work(list[i]);
      }
    });
  };
  std::vector<TileIndex> stale;
  try {
    for_each(
        is_all ? s.covered_tiles : tiles, control.part(0.0, 0.6), [&](TileIndex tile) { s.prefetch(atlas, tile); },
        [&](TileIndex tile) { s.compose_tile(atlas, tile); });
    stale = s.stale_normals.take();
    for_each(
        stale, control.part(0.6, 1.0), [&](TileIndex tile) { s.prefetch_heights(tile); },
        [&](TileIndex tile) { s.compose_normals(tile); });
  } catch (...) {  // Canceled: what was done stays marked, since the next call finds it up to date.
    for (const TileIndex tile : stale) s.stale_normals.add(tile);
    throw;
  }
  s.is_all_dirty = false;
  return s.changed.take();
}

void Composer::compose_there(const MaterialAtlas& atlas, DeviceArrays& arrays, const RunControl& control) {
  State& s = *state_;
  if (!s.there) {
    s.read_originals(atlas);
    s.there = std::make_unique<DeviceComposition>(arrays, s, s.textures(), control);
    const std::array<std::uint32_t, 2> none{};
    arrays.device.write(std::span<const std::uint32_t>(none), arrays.tally, tally_types::kNumStale);
  }
  if (s.is_all_dirty) list_tiles(s.covered_tiles, arrays);
  s.is_all_dirty = false;
  s.is_behind = true;
  s.there->compose(arrays);
}

std::vector<TileIndex> Composer::changed_there() const {
  if (state_->on_asked) state_->on_asked();
  return state_->there ? state_->there->changed_tiles() : std::vector<TileIndex>();
}

void Composer::on_asked(std::function<void()> make_sure) { state_->on_asked = std::move(make_sure); }

void Composer::on_lost(std::function<void(const device::DeviceError&)> compose_here) {
  state_->on_lost = std::move(compose_here);
}

void Composer::forget_there() {
  state_->there.reset();
  state_->is_all_dirty = true;
  state_->is_behind = false;
}

void Composer::State::bring_back() {
  if (!is_behind) return;
  try {
    if (on_asked) on_asked();
    if (!is_behind) return;
    there->bring_back(textures());
    is_behind = false;
  } catch (const device::DeviceError& error) {
    on_lost(error);
  }
}

}  // namespace patinate::simulation
