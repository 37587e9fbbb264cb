#include "simulation/composition/compose_device.h"

#include <algorithm>
#include <array>

#include "simulation/composition/quantized_appearance.h"

namespace patinate::simulation {

using device::Buffer;

namespace composition {

namespace {

/// Appends `num` values. @returns which plane of that size they are.
template <class T>
std::int32_t append(std::vector<T>& pool, const T* values, std::size_t num) {
  const auto plane = static_cast<std::int32_t>(pool.size() / num);
  pool.insert(pool.end(), values, values + num);
  return plane;
}

}  // namespace

void PackedTiles::add(const ComposeTask& task) {
  PackedTask packed;
  packed.num_materials = task.num_materials;
  packed.first_texel = task.first_texel;
  packed.is_published_form = task.is_published_form;
  for (std::size_t k = 0; k < static_cast<std::size_t>(task.num_materials); ++k) {
    packed.look[k] = static_cast<std::int32_t>(task.look[k] - looks_.data());
    packed.amount[k] = amounts_ != nullptr ? amounts_->tile_plane(packed.look[k], task.first_texel / kTile)
                                           : append(planes_, task.amount[k], kTile);
    const auto [original, is_new] = originals_.try_emplace(task.original[k], 0);
    if (is_new) original->second = append(planes_, task.original[k], kTile);
    packed.original[k] = original->second;
    packed.grain[k] = task.grain[k] == nullptr ? -1 : append(grains_, task.grain[k], kTile);
    packed.picture[k] = task.picture[k] == nullptr ? -1 : append(pictures_, task.picture[k], 3 * kTile);
  }
  // Objects without maps have one tile for all; a buffer is another tile each time.
  const bool is_same_base = task.base == last_base_ && !bases_.empty() &&
                            std::equal(task.base->code, task.base->code + kTile, bases_.back().code);
  if (!is_same_base) bases_.push_back(*task.base);
  const bool is_same_height = task.height == last_height_ && !heights_.empty();
  if (!is_same_height) heights_.insert(heights_.end(), task.height, task.height + kTile);
  last_base_ = task.base;
  last_height_ = task.height;
  packed.base = static_cast<std::int32_t>(bases_.size()) - 1;
  packed.height = static_cast<std::int32_t>(heights_.size() / kTile) - 1;
  tasks_.push_back(packed);
}

void PackedTiles::clear() {
  tasks_.clear();
  planes_.clear();
  originals_.clear();
  pictures_.clear();
  grains_.clear();
  bases_.clear();
  heights_.clear();
}

struct DeviceSurface::State {
  State(const device::Device& its_device, const SurfaceAtlas& its_surface, const HeightFrames& its_frames)
      : device(its_device),
        surface(its_surface),
        frames(its_frames),
        program(build(device)),
        compose(program.kernel("compose_tiles")),
        normals(program.kernel("compose_normals")),
        srgb(device.upload(std::span<const std::uint8_t>(srgb8_of_linear16()))),
        triangles(device.upload(surface.triangles())),
        frame_of_triangle(device.upload(frames.frames())),
        border(device.upload(frames.border())) {}

  static device::Program build(const device::Device& device) {
    const std::array<std::string_view, 3> sources{kComposeTypes, kComposeKernel, kComposeEntries};
    return device.build("composition", sources);
  }

  device::Device device;
  const SurfaceAtlas& surface;
  const HeightFrames& frames;
  device::Program program;
  device::Kernel compose, normals;
  Buffer<std::uint8_t> srgb;
  Buffer<std::int32_t> triangles;
  Buffer<Frame> frame_of_triangle;
  Buffer<BorderTexel> border;
  Buffer<std::int32_t> heights;  // Of the whole atlas.
};

DeviceSurface::DeviceSurface(const device::Device& device, const SurfaceAtlas& surface, const HeightFrames& frames)
    : state_(std::make_unique<State>(device, surface, frames)) {}
DeviceSurface::~DeviceSurface() = default;

void DeviceSurface::compose(const PackedTiles& tiles, std::vector<std::uint32_t>& codes,
                            std::vector<std::int32_t>& heights) {
  State& s = *state_;
  const device::Device& d = s.device;
  const std::size_t num_items = tiles.size() * kTile;
  const auto new_codes = d.allocate<std::uint32_t>(num_items);
  const auto new_heights = d.allocate<std::int32_t>(num_items);
  const Buffer<std::uint16_t> planes = d.upload(tiles.planes_);
  s.compose.run({.num = num_items, .group = kTile}, d.upload(tiles.tasks_), d.upload(tiles.looks_),
                tiles.amounts_ != nullptr ? tiles.amounts_->planes() : planes, planes, d.upload(tiles.grains_),
                d.upload(tiles.pictures_), d.upload(tiles.bases_), d.upload(tiles.heights_), s.srgb, new_codes,
                new_heights);
  codes.resize(num_items);
  heights.resize(num_items);
  d.read(new_codes, std::span(codes));
  d.read(new_heights, std::span(heights));
}

void DeviceSurface::set_heights(std::span<const std::int32_t> heights) {
  state_->heights = state_->device.upload(heights);
}

void DeviceSurface::normals(std::span<const TileIndex> tiles, std::vector<std::uint8_t>& normals) {
  State& s = *state_;
  std::vector<PackedNormal> tasks;
  tasks.reserve(tiles.size());
  for (const TileIndex tile : tiles) {
    const std::array<TileIndex, 4> beside = tiles_beside(s.surface.grid(), tile);
    tasks.push_back({.tile = tile,
                     .beside = beside,
                     .border_begin = s.frames.border_begin(tile),
                     .border_end = s.frames.border_begin(tile + 1)});
  }
  const std::size_t size = 3 * kTile * tiles.size();
  const auto found = s.device.allocate<std::uint8_t>(size);
  s.normals.run({.num = tiles.size() * kTile, .group = kTile}, s.device.upload(tasks), s.heights, s.triangles,
                s.frame_of_triangle, s.border, found);
  normals.resize(size);
  s.device.read(found, std::span(normals));
}

}  // namespace composition

}  // namespace patinate::simulation
