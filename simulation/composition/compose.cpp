#include "simulation/composition/compose.h"

#include <algorithm>
#include <cstring>

#include "libcommon/core/error.h"
#include "libcommon/core/parallel.h"
#include "simulation/composition/composer_state.h"

namespace patinate {

using namespace composition;

namespace {

constexpr std::int64_t kChunk = 256;  // tiles
constexpr std::int32_t kBorderHalf = 2048;
constexpr int kBorderShift = 12;

bool differ(const std::uint16_t* a, const std::uint16_t* b) { return std::memcmp(a, b, kTile * sizeof(std::uint16_t)) != 0; }

/// Copies and tells whether anything was different.
template <class T>
bool replace(T* to, const T* from, std::size_t n) {
  if (std::memcmp(to, from, n * sizeof(T)) == 0) return false;
  std::memcpy(to, from, n * sizeof(T));
  return true;
}

bool has_relief(const std::vector<QuantisedLook>& looks) {
  return std::any_of(looks.begin(), looks.end(), [](const QuantisedLook& look) { return look.height != 0; });
}

std::int32_t slope_at_border(const BorderTexel& texel, const std::array<std::int32_t, 4>& weights, const std::vector<std::int32_t>& heights) {
  std::int64_t sum = kBorderHalf;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::int32_t step = std::clamp(heights[texel.neighbor[k]] - heights[texel.texel], -kMaxStep, kMaxStep);
    sum += std::int64_t{step} * weights[k];
  }
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(sum >> kBorderShift, -kMaxSlope, kMaxSlope));
}

}  // namespace

Composer::State::State(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface_atlas, ColorForm color_form,
                       const RunControl& control)
    : surface(&surface_atlas),
      quanta_per_mm(kHeightQuanta / surface_atlas.median_texel_size_mm()),
      base(scene, scene_mesh, surface_atlas, quanta_per_mm, control.part(0.0, 0.7)),
      frames(scene_mesh, surface_atlas, control.part(0.7, 1.0)),
      texel_of_object(scene.objects.size(), kNoTexel),
      form(color_form),
      kernels(&composition::kernels(instruction_set())),
      codes(surface_atlas.grid().num_texels()),
      normals(std::size_t{surface_atlas.grid().num_tiles()} * 3 * kTile),
      flags(surface_atlas.grid().num_tiles()) {
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
  set_looks(scene.looks);
}

void Composer::State::set_looks(const std::vector<MaterialLook>& new_looks) {
  std::vector<QuantisedLook> quantised;
  std::vector<Picture> new_pictures;
  for (std::size_t i = 0; i < new_looks.size(); ++i) {
    quantised.push_back(quantise(new_looks[i], quanta_per_mm, noise_key(static_cast<int>(i))));
    new_pictures.push_back(make_picture(new_looks[i].color.image));
  }
  looks = std::move(quantised);
  pictures = std::move(new_pictures);
  if (heights.empty() && (base.has_heights() || has_relief(looks))) heights.assign(surface->grid().num_texels(), 0);
  is_all_dirty = true;
}

void Composer::State::read_originals(const MaterialAtlas& atlas) {
  originals.resize(texel_of_object.size() * looks.size());
  for (std::size_t object = 0; object < texel_of_object.size(); ++object) {
    for (std::size_t m = 0; m < looks.size(); ++m) {
      const TexelIndex t = texel_of_object[object];
      originals[object * looks.size() + m].fill(t == kNoTexel ? std::uint16_t{0} : atlas.original(static_cast<int>(m), t));
    }
  }
}

void Composer::State::compose_tile(const MaterialAtlas& atlas, TileIndex tile) {
  BaseTile base_buffer;
  alignas(64) std::uint16_t original_buffer[kMaxMaterials][kTile];
  alignas(64) std::uint16_t picture_buffer[kMaxMaterials][3 * kTile];
  const std::uint16_t object = base.object(tile);
  ComposeTask task;
  task.first_texel = tile * kTile;
  for (std::size_t m = 0; m < looks.size(); ++m) {
    const std::span<const std::uint16_t> amount = atlas.tile(static_cast<int>(m), tile);
    if (amount.empty()) continue;
    const std::uint16_t* original = original_buffer[m];
    if (object != BaseLayer::kSeveral) {
      original = originals[object * looks.size() + m].data();
    } else {
      for (std::uint32_t l = 0; l < kTile; ++l) original_buffer[m][l] = atlas.original(static_cast<int>(m), task.first_texel + l);
    }
    if (!differ(amount.data(), original)) continue;
    const auto k = static_cast<std::size_t>(task.num_materials++);
    task.look[k] = &looks[m];
    task.amount[k] = amount.data();
    task.original[k] = original;
    if (pictures[m].empty()) continue;
    pictures[m].read_tile(surface->grid().x(task.first_texel), surface->grid().y(task.first_texel), picture_buffer[m]);
    task.picture[k] = picture_buffer[m];
  }
  const BaseTile& new_tile = base.tile(tile, base_buffer);
  alignas(64) std::uint32_t rgba[kTile];
  alignas(64) std::int32_t height[kTile];
  const std::uint32_t* out_codes = new_tile.code;
  const std::int32_t* out_heights = base.heights(tile);
  if (task.num_materials > 0) {
    task.base = &new_tile;
    task.height = out_heights;
    task.srgb = srgb8_of_linear16().data();
    task.is_published_form = form == ColorForm::Published;
    kernels->compose(task, rgba, height);
    out_codes = rgba;
    out_heights = height;
  }
  std::uint8_t changed = replace(&codes[task.first_texel], out_codes, kTile) ? kCodesChanged : std::uint8_t{0};
  if (!heights.empty() && replace(&heights[task.first_texel], out_heights, kTile)) changed |= kHeightsChanged;
  flags[tile] = static_cast<std::uint8_t>(flags[tile] | changed);
}

void Composer::State::slopes_of(TileIndex tile, SlopeTile& slopes) const {
  const std::array<TileIndex, 4> beside = tiles_beside(surface->grid(), tile);
  const auto heights_of = [&](TileIndex other) { return heights.data() + std::size_t{other} * kTile; };
  const NormalTask task{.here = heights_of(tile), .right = heights_of(beside[0]), .left = heights_of(beside[1]),
                        .below = heights_of(beside[2]), .above = heights_of(beside[3]),
                        .triangle = surface->triangles().data() + std::size_t{tile} * kTile, .frame = frames.frames().data()};
  kernels->slopes(task, slopes);
  for (const BorderTexel& texel : frames.border(tile)) {
    slopes.along_t[texel.texel % kTile] = slope_at_border(texel, texel.along_t, heights);
    slopes.along_b[texel.texel % kTile] = slope_at_border(texel, texel.along_b, heights);
  }
}

void Composer::State::compose_normals(TileIndex tile) {
  SlopeTile slopes;
  slopes_of(tile, slopes);
  alignas(64) std::uint8_t normal[3 * kTile];
  kernels->encode(slopes, normal);
  if (replace(&normals[std::size_t{tile} * 3 * kTile], normal, 3 * kTile)) flags[tile] |= kNormalsChanged;
}

Composer::Composer(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface, ColorForm form, const RunControl& control)
    : state_(std::make_unique<State>(scene, scene_mesh, surface, form, control)) {}
Composer::~Composer() = default;
Composer::Composer(Composer&&) noexcept = default;
Composer& Composer::operator=(Composer&&) noexcept = default;

void Composer::set_looks(const std::vector<MaterialLook>& looks) {
  if (looks.size() != state_->looks.size()) {
    throw InvalidInput(std::to_string(looks.size()) + " looks were given for " + std::to_string(state_->looks.size()) + " materials");
  }
  state_->set_looks(looks);
}

void Composer::set_form(ColorForm form) {
  state_->is_all_dirty = state_->is_all_dirty || form != state_->form;
  state_->form = form;
}

void Composer::use(InstructionSet set) {
  if (!has_instruction_set(set)) throw InvalidInput("this machine lacks " + std::string(kInstructionSetNames[static_cast<std::size_t>(set)]));
  state_->kernels = &composition::kernels(set);
}

std::vector<TileIndex> Composer::compose(const MaterialAtlas& atlas, std::span<const TileIndex> dirty, const RunControl& control) {
  State& s = *state_;
  if (&atlas.surface() != s.surface || atlas.num_materials() != static_cast<int>(s.looks.size())) {
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
  s.is_all_dirty = true;  // should this be cancelled
  s.read_originals(atlas);
  const auto for_each = [&](const std::vector<TileIndex>& list, const RunControl& part, const auto& work) {
    parallel_for(static_cast<std::int64_t>(list.size()), kChunk, part, [&](std::int64_t begin, std::int64_t end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) work(list[i]);
    });
  };
  const std::vector<TileIndex>& first = is_all ? s.covered_tiles : tiles;
  for_each(first, control.part(0.0, 0.6), [&](TileIndex tile) { s.compose_tile(atlas, tile); });

  // Slopes use the heights of the tiles beside, and of those across seams.
  std::vector<TileIndex> around;
  const auto mark = [&](TileIndex tile) {
    if ((s.flags[tile] & State::kMarked) != 0 || s.base.object(tile) == BaseLayer::kNone) return;
    s.flags[tile] |= State::kMarked;
    around.push_back(tile);
  };
  for (const TileIndex tile : first) {
    if ((s.flags[tile] & State::kHeightsChanged) == 0) continue;
    mark(tile);
    for (const TileIndex other : tiles_beside(s.surface->grid(), tile)) mark(other);
    for (const TileIndex other : s.frames.dependents(tile)) mark(other);
  }
  for_each(around, control.part(0.6, 1.0), [&](TileIndex tile) { s.compose_normals(tile); });

  std::vector<TileIndex> changed;
  const auto collect = [&](const std::vector<TileIndex>& list) {
    for (const TileIndex tile : list) {
      if ((s.flags[tile] & ~State::kMarked) != 0) changed.push_back(tile);
      s.flags[tile] = 0;
    }
  };
  collect(first);
  collect(around);
  std::sort(changed.begin(), changed.end());
  s.is_all_dirty = false;
  return changed;
}

}  // namespace patinate
