#include "simulation/tracing/device_motion.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <vector>

#include "libcommon/core/portable_math.h"
#include "libcommon/core/random.h"
#include "patinate/simulation/material_atlas.h"
#include "simulation/atlas/places.h"
#include "simulation/tracing/device_rays.h"

namespace patinate::simulation {

using device::Buffer;
using device::Device;

namespace {

constexpr std::size_t kGroup = 64;
constexpr std::size_t kBatch = std::size_t{1} << 16;  // Gammatons of one launch, which stays short.

device::Program build(const Device& device) {
  const std::array<std::string_view, 16> sources{kPhiloxKernel,   kPortableMath, kRayTypes,       kRayLanes,
                                                 kRayKernel,      kMotionTypes,  kMotionVectors,  kRandomDirection,
                                                 kPlaceKernel,    kMotionArrays, kFlightKernel,   kWalkKernel,
                                                 kFloatingKernel, kBirthKernel,  kResponseKernel, kMotionEntries};
  return device.build("motion", sources);
}

/// Devices have no empty arrays.
template <class T>
Buffer<T> upload(const Device& device, std::span<const T> values) {
  static const T nothing{};
  return device.upload(values.empty() ? std::span<const T>(&nothing, 1) : values);
}

}  // namespace

struct DeviceMotion::State {
  State(const Device& its_device, const MotionScene& scene, const SurfaceAtlas& surface, const RunControl& control)
      : device(its_device),
        program(build(device)),
        trace(program.kernel("trace_drops")),
        respond(program.kernel("respond_drops")),
        nodes(upload(device, scene.rays.nodes())),
        blocks(upload(device, scene.rays.blocks())),
        frames(upload(device, scene.frames.frames())),
        corner_normals(upload(device, scene.frames.corner_normals())),
        links(upload(device, scene.links.codes())),
        empty_cells(upload(device, scene.free_space.empty())),
        clear(upload(device, std::span<const std::uint8_t>(scene.clearance.all(control)))),
        places{.width = surface.grid().width, .height = surface.grid().height},
        corner_texels(upload(device, surface.corner_texels())),
        charts(upload(device, surface.charts())),
        fallbacks(upload(device, surface.fallbacks())),
        tile_charts(upload(device, surface.tile_charts())),
        triangles(upload(device, surface.triangles())),
        wet(device.allocate<std::uint16_t>(1)) {}

  /// Brings what is wet to the device: pages that have changed.
  void update_wet(const WetPaths& paths);

  /// Calls launch(items) with the drops of each batch on the device.
  template <class Launch>
  void in_batches(std::span<DropRecord> drops, Launch&& launch) {
    for (std::size_t begin = 0; begin < drops.size(); begin += kBatch) {
      const std::span<DropRecord> batch = drops.subspan(begin, std::min(kBatch, drops.size() - begin));
      if (records.size() < batch.size()) records = device.allocate<DropRecord>(std::min(kBatch, drops.size()));
      device.write(std::span<const DropRecord>(batch), records);
      launch(begin, static_cast<std::uint32_t>(batch.size()),
             device::Items{.num = (batch.size() + kGroup - 1) / kGroup * kGroup, .group = kGroup});
      device.read(records, batch);
    }
  }

  Device device;
  device::Program program;
  device::Kernel trace, respond;
  Buffer<BvhNode> nodes;
  Buffer<TriangleBlock> blocks;
  Buffer<TriangleFrame> frames;
  Buffer<CornerNormals> corner_normals;
  Buffer<TriangleLinks> links;
  Buffer<std::uint8_t> empty_cells, clear;
  place_types::PlaceFacts places;
  Buffer<std::array<float, 6>> corner_texels;
  Buffer<std::int32_t> charts;
  Buffer<std::uint32_t> fallbacks;
  Buffer<std::int32_t> tile_charts, triangles;
  Buffer<std::uint16_t> wet;
  std::vector<std::uint16_t> wet_there;  ///< What `wet` holds.
  Buffer<DropRecord> records;
};

void DeviceMotion::State::update_wet(const WetPaths& paths) {
  const TileGrid& grid = paths.atlas->surface().grid();
  const bool is_new = wet_there.size() != grid.num_texels();
  if (is_new) {
    wet = device.allocate<std::uint16_t>(grid.num_texels());
    wet_there.assign(grid.num_texels(), 0);
  }
  std::array<std::uint16_t, TileGrid::kPageTexels> page{};
  for (std::uint32_t p = 0; p < grid.num_pages(); ++p) {
    const TexelIndex first = p * TileGrid::kPageTexels;
    const std::span<const std::uint16_t> stored = paths.atlas->page(paths.material, p);
    if (stored.empty()) {
      for (std::uint32_t t = 0; t < TileGrid::kPageTexels; ++t)
        page[t] = paths.atlas->amount(paths.material, first + t);
    }
    const std::span<const std::uint16_t> now = stored.empty() ? std::span<const std::uint16_t>(page) : stored;
    std::uint16_t* const there = wet_there.data() + first;
    if (!is_new && std::memcmp(there, now.data(), now.size_bytes()) == 0) continue;
    std::copy(now.begin(), now.end(), there);
    device.write(now, wet, first);
  }
}

DeviceMotion::DeviceMotion(const Device& device, const MotionScene& scene, const SurfaceAtlas& surface,
                           const RunControl& control)
    : state_(std::make_unique<State>(device, scene, surface, control)) {}
DeviceMotion::~DeviceMotion() = default;

void DeviceMotion::trace(const MotionScene& scene, const MotionCall& call, std::span<const EmitterFacts> emitters,
                         std::uint32_t first, std::span<DropRecord> drops) {
  State& s = *state_;
  const Buffer<EmitterFacts> from = upload(s.device, emitters);
  s.in_batches(drops, [&](std::size_t begin, std::uint32_t num, const device::Items& items) {
    s.trace.run(items, scene.facts, s.nodes, s.blocks, s.frames, s.corner_normals, s.links, s.empty_cells, s.clear,
                s.places, s.corner_texels, s.charts, s.fallbacks, s.tile_charts, s.triangles, s.wet, call, from,
                first + static_cast<std::uint32_t>(begin), num, s.records);
  });
}

void DeviceMotion::respond(const MotionScene& scene, const MotionCall& call, std::uint32_t first,
                           std::span<DropRecord> drops) {
  State& s = *state_;
  if (scene.wet != nullptr) s.update_wet(*scene.wet);
  s.in_batches(drops, [&](std::size_t begin, std::uint32_t num, const device::Items& items) {
    s.respond.run(items, scene.facts, s.nodes, s.blocks, s.frames, s.corner_normals, s.links, s.empty_cells, s.clear,
                  s.places, s.corner_texels, s.charts, s.fallbacks, s.tile_charts, s.triangles, s.wet, call,
                  first + static_cast<std::uint32_t>(begin), num, s.records);
  });
}

}  // namespace patinate::simulation
