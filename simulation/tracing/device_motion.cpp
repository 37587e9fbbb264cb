#include "simulation/tracing/device_motion.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "libcommon/core/portable_math.h"
#include "libcommon/core/random.h"
#include "patinate/simulation/material_atlas.h"
#include "simulation/atlas/places.h"
#include "simulation/device/device_amounts.h"
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
        no_wet(device.allocate<std::uint16_t>(1)) {}

  /// Calls launch(items) for the drops of each batch.
  template <class Launch>
  void in_batches(std::size_t num, Launch&& launch) {
    for (std::size_t begin = 0; begin < num; begin += kBatch) {
      const std::size_t size = std::min(kBatch, num - begin);
      launch(device::Items{.first = begin, .num = (size + kGroup - 1) / kGroup * kGroup, .group = kGroup});
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
  Buffer<std::uint16_t> no_wet;  ///< For kernels that read none.
  Buffer<DropRecord> records;
};

DeviceMotion::DeviceMotion(const Device& device, const MotionScene& scene, const SurfaceAtlas& surface,
                           const RunControl& control)
    : state_(std::make_unique<State>(device, scene, surface, control)) {}
DeviceMotion::~DeviceMotion() = default;

void DeviceMotion::put(std::span<const DropRecord> drops) {
  State& s = *state_;
  if (s.records.size() < drops.size()) s.records = s.device.allocate<DropRecord>(drops.size());
  s.device.write(drops, s.records);
}

void DeviceMotion::trace(const MotionScene& scene, const MotionCall& call, std::span<const EmitterFacts> emitters,
                         std::uint32_t first, std::span<DropRecord> drops) {
  State& s = *state_;
  const Buffer<EmitterFacts> from = upload(s.device, emitters);
  s.in_batches(drops.size(), [&](const device::Items& items) {
    s.trace.run(items, scene.facts, s.nodes, s.blocks, s.frames, s.corner_normals, s.links, s.empty_cells, s.clear,
                s.places, s.corner_texels, s.charts, s.fallbacks, s.tile_charts, s.triangles, s.no_wet,
                std::uint64_t{0}, call, from, first, static_cast<std::uint32_t>(drops.size()), s.records);
  });
  s.device.read(s.records, drops);
}

void DeviceMotion::respond(const MotionScene& scene, const MotionCall& call, std::uint32_t first,
                           std::span<DropRecord> drops) {
  State& s = *state_;
  const WetPaths* wet = scene.wet;
  const Buffer<std::uint16_t>& amounts = wet != nullptr ? wet->on_device->planes() : s.no_wet;
  const std::uint64_t first_wet =
      wet != nullptr ? static_cast<std::uint64_t>(wet->material) * wet->atlas->surface().grid().num_texels() : 0;
  s.in_batches(drops.size(), [&](const device::Items& items) {
    s.respond.run(items, scene.facts, s.nodes, s.blocks, s.frames, s.corner_normals, s.links, s.empty_cells, s.clear,
                  s.places, s.corner_texels, s.charts, s.fallbacks, s.tile_charts, s.triangles, amounts, first_wet,
                  call, first, static_cast<std::uint32_t>(drops.size()), s.records);
  });
  s.device.read(s.records, drops);
}

}  // namespace patinate::simulation
