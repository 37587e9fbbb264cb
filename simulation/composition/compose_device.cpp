#include "simulation/composition/compose_device.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>

#include "libcommon/core/parallel.h"
#include "simulation/composition/composer_state.h"

namespace patinate::simulation::composition {

using device::Buffer;
using device::Device;

namespace {

constexpr std::size_t kNormalWords = 3 * kTile / sizeof(std::uint32_t);

device::Program build(const Device& device) {
  const std::array<std::string_view, 5> sources{kTallyTypes, kTallyKernel, kComposeTypes, kComposeKernel,
                                                kComposeEntries};
  return device.build("composition", sources);
}

/// Appearance of new tiles, each kind of tile once.
struct Bases {
  std::vector<TileFacts> facts;
  std::vector<std::uint16_t> originals;
  std::vector<BaseTile> tiles;
  std::vector<std::int32_t> heights;

  explicit Bases(ComposerParts& parts);

 private:
  std::map<const void*, std::int32_t> known_tiles_, known_heights_;
};

Bases::Bases(ComposerParts& parts) : facts(parts.surface->grid().num_tiles()) {
  const std::size_t num_materials = parts.appearance.size();
  for (const auto& plane : parts.originals) originals.insert(originals.end(), plane.begin(), plane.end());
  for (TileIndex tile = 0; tile < facts.size(); ++tile) {
    TileFacts& of = facts[tile];
    of.beside = tiles_beside(parts.surface->grid(), tile);
    of.border_begin = parts.frames.border_begin(tile);
    of.border_end = parts.frames.border_begin(tile + 1);
    of.dependents_begin = parts.frames.dependents_begin(tile);
    of.dependents_end = parts.frames.dependents_begin(tile + 1);
    const std::uint16_t object = parts.base.object(tile);
    if (object == BaseLayer::kNone) continue;
    of.is_covered = 1;
    if (!parts.has_shared_originals(tile)) {
      of.originals = static_cast<std::int32_t>(originals.size() / kTile);
      for (std::size_t m = 0; m < num_materials; ++m) {
        for (std::uint32_t l = 0; l < kTile; ++l) originals.push_back(parts.original(m, tile * kTile + l));
      }
    } else {
      of.originals = static_cast<std::int32_t>(object * num_materials);
    }
    // A buffer is another tile each time; objects without maps have one for all.
    BaseTile buffer;
    const BaseTile& base = parts.base.tile(tile, buffer);
    const void* key = &base == &buffer ? nullptr : &base;
    const auto [at, is_new] = known_tiles_.try_emplace(key, static_cast<std::int32_t>(tiles.size()));
    if (is_new || key == nullptr) {
      at->second = static_cast<std::int32_t>(tiles.size());
      tiles.push_back(base);
    }
    of.base = at->second;
    const std::int32_t* height = parts.base.heights(tile);
    const auto [known, is_other] =
        known_heights_.try_emplace(height, static_cast<std::int32_t>(heights.size() / kTile));
    if (is_other) heights.insert(heights.end(), height, height + kTile);
    of.height = known->second;
  }
}

}  // namespace

struct DeviceComposition::State {
  State(const DeviceArrays& arrays, ComposerParts& parts, const Textures& textures, const RunControl& control);
  void bring_layers(ComposerParts& parts, const RunControl& control);

  Device device;
  device::Program program;
  device::Kernel compose, normals, gather;
  ComposeCall call;
  std::size_t num_groups;
  std::uint32_t brought_back = 0;  ///< Changes by calls until this one are on the host.
  Buffer<QuantizedAppearance> looks;
  Buffer<std::uint16_t> originals, pictures;
  Buffer<std::uint8_t> grains, srgb, normals_there;
  Buffer<BaseTile> bases;
  Buffer<std::int32_t> base_heights, heights;
  Buffer<TileFacts> facts;
  Buffer<TileIndex> dependents;
  Buffer<Frame> frames;
  Buffer<BorderTexel> border;
  Buffer<std::uint32_t> stale_in, stale, codes, composed_in;
};

DeviceComposition::State::State(const DeviceArrays& arrays, ComposerParts& parts, const Textures& textures,
                                const RunControl& control)
    : device(arrays.device),
      program(build(device)),
      compose(program.kernel("compose_touched")),
      normals(program.kernel("compose_normals")),
      gather(program.kernel("gather_words")),
      num_groups(32 * static_cast<std::size_t>(std::max(1, device.info().num_units))),
      looks(device.upload(std::span<const QuantizedAppearance>(parts.appearance))),
      srgb(device.upload(std::span<const std::uint8_t>(srgb8_of_linear16()))),
      normals_there(device.upload(textures.normals)),
      heights(upload_some(device, std::span<const std::int32_t>(textures.heights))),
      dependents(upload_some(device, parts.frames.dependents())),
      frames(device.upload(parts.frames.frames())),
      border(upload_some(device, parts.frames.border())),
      stale_in(device.allocate<std::uint32_t>(arrays.num_tiles)),
      stale(device.allocate<std::uint32_t>(arrays.num_tiles)),
      codes(device.upload(textures.codes)),
      composed_in(device.allocate<std::uint32_t>(arrays.num_tiles)) {
  const Bases of(parts);
  originals = device.upload(of.originals);
  bases = upload_some(device, std::span<const BaseTile>(of.tiles));
  base_heights = upload_some(device, std::span<const std::int32_t>(of.heights));
  facts = device.upload(of.facts);
  device.fill_zero(stale_in.memory());
  device.fill_zero(composed_in.memory());
  call.num_materials = arrays.num_materials;
  call.num_texels = arrays.num_texels;
  call.has_heights = textures.heights.empty() ? 0 : 1;
  call.form = static_cast<std::int32_t>(parts.form);
  bring_layers(parts, control);
}

void DeviceComposition::State::bring_layers(ComposerParts& parts, const RunControl& control) {
  RunControl silent = control;
  silent.on_progress = nullptr;
  constexpr std::int64_t kChunk = 256;  // Tiles.
  const auto num_covered = static_cast<std::int64_t>(parts.covered_tiles.size());
  std::vector<std::size_t> grained, pictured;
  for (std::size_t m = 0; m < 8; ++m) call.grain_layer[m] = call.picture_layer[m] = -1;
  for (std::size_t m = 0; m < call.num_materials; ++m) {
    if (parts.grain.has(m)) {
      call.grain_layer[m] = static_cast<std::int32_t>(grained.size());
      grained.push_back(m);
    }
    if (parts.pictures.has(m)) {
      call.picture_layer[m] = static_cast<std::int32_t>(pictured.size());
      pictured.push_back(m);
    }
  }
  // By all threads: both are made when they are first asked for.
  const auto bring = [&]<class T>(const std::vector<std::size_t>& materials, std::size_t each, Buffer<T>& buffer,
                                  const auto& fill) {
    const std::size_t plane = call.num_texels * each;
    buffer = device.allocate<T>(std::max<std::size_t>(1, materials.size() * plane));
    std::vector<T> values(materials.empty() ? 0 : plane);
    for (std::size_t layer = 0; layer < materials.size(); ++layer) {
      parallel_for(num_covered, kChunk, silent, [&](std::int64_t begin, std::int64_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          const TileIndex tile = parts.covered_tiles[i];
          fill(materials[layer], tile, values.data() + std::size_t{tile} * kTile * each);
        }
      });
      device.write(std::span<const T>(values), buffer, layer * plane);
    }
  };
  bring(grained, 1, grains,
        [&](std::size_t m, TileIndex tile, std::uint8_t* out) { std::copy_n(parts.grain.tile(m, tile), kTile, out); });
  bring(pictured, 3, pictures,
        [&](std::size_t m, TileIndex tile, std::uint16_t* out) { parts.pictures.read_tile(m, tile, out); });
}

DeviceComposition::DeviceComposition(const DeviceArrays& arrays, ComposerParts& parts, const Textures& textures,
                                     const RunControl& control)
    : state_(std::make_unique<State>(arrays, parts, textures, control)) {}
DeviceComposition::~DeviceComposition() = default;

void DeviceComposition::compose(DeviceArrays& a) {
  State& s = *state_;
  ++s.call.number;
  const device::Items items{.num = s.num_groups * kTile, .group = kTile};
  s.compose.run(items, s.call, s.looks, a.amounts, s.originals, s.grains, s.pictures, s.bases, s.base_heights, s.srgb,
                s.facts, s.dependents, a.is_listed, a.touched, s.stale_in, s.stale, s.codes, s.heights, s.composed_in,
                a.tally);
  s.normals.run(items, s.call, s.facts, s.heights, a.triangles, s.frames, s.border, s.stale, s.normals_there,
                s.composed_in, a.tally);
}

std::vector<TileIndex> DeviceComposition::changed_tiles() const {
  const State& s = *state_;
  std::vector<std::uint32_t> composed(s.composed_in.size());
  s.device.read(s.composed_in, std::span(composed));
  std::vector<TileIndex> tiles;
  for (TileIndex t = 0; t < composed.size(); ++t) {
    if (composed[t] == s.call.number) tiles.push_back(t);
  }
  return tiles;
}

void DeviceComposition::bring_back(const Textures& to) {
  State& s = *state_;
  if (s.brought_back == s.call.number) return;
  std::vector<std::uint32_t> composed(s.composed_in.size());
  s.device.read(s.composed_in, std::span(composed));
  std::vector<TileIndex> tiles;
  for (TileIndex t = 0; t < composed.size(); ++t) {
    if (composed[t] > s.brought_back) tiles.push_back(t);
  }
  constexpr std::size_t kBatch = std::size_t{1} << 16;  // Tiles.
  // All at once, so that a device that is lost leaves what was there.
  std::vector<std::uint32_t> words(tiles.size() * (2 * kTile + kNormalWords));
  std::uint32_t* out = words.data();
  const Buffer<std::uint32_t> room = s.device.allocate<std::uint32_t>(std::min(kBatch, tiles.size()) * kTile);
  const auto bring = [&](std::span<const TileIndex> batch, std::size_t each, const auto& from) {
    s.gather.run({.num = batch.size() * each}, s.device.upload(batch), static_cast<std::uint32_t>(each), from, room);
    s.device.read(room, std::span(out, batch.size() * each));
    out += batch.size() * each;
  };
  for (std::size_t begin = 0; begin < tiles.size(); begin += kBatch) {
    const std::span<const TileIndex> batch = std::span(tiles).subspan(begin, std::min(kBatch, tiles.size() - begin));
    bring(batch, kTile, s.codes);
    if (s.call.has_heights != 0) bring(batch, kTile, s.heights);
    bring(batch, kNormalWords, s.normals_there);
  }
  const std::uint32_t* in = words.data();
  const auto take = [&]<class T>(std::span<const TileIndex> batch, std::size_t each, std::vector<T>& values) {
    for (const TileIndex t : batch) {
      std::memcpy(values.data() + std::size_t{t} * each, in, each * sizeof(T));
      in += each * sizeof(T) / sizeof(*in);
    }
  };
  for (std::size_t begin = 0; begin < tiles.size(); begin += kBatch) {
    const std::span<const TileIndex> batch = std::span(tiles).subspan(begin, std::min(kBatch, tiles.size() - begin));
    take(batch, kTile, to.codes);
    if (s.call.has_heights != 0) take(batch, kTile, to.heights);
    take(batch, 3 * kTile, to.normals);
  }
  s.brought_back = s.call.number;
}

}  // namespace patinate::simulation::composition
