#include "simulation/tracing/device_motion.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "libcommon/core/portable_math.h"
#include "libcommon/core/random.h"
#include "simulation/atlas/places.h"
#include "simulation/tracing/device_rays.h"
#include "simulation/transport/transfer.h"

namespace patinate::simulation {

using device::Buffer;
using device::Device;

namespace {

constexpr std::size_t kGammatonGroup = 64;
constexpr std::size_t kGammatonBatch = std::size_t{1} << 16;  // Gammatons of one launch, which stays short.

device::Program build_motion_program(const Device& device) {
  const std::array<std::string_view, 20> sources{
      kPhiloxKernel,    kPortableMath,   kRayTypes,     kRayLanes,     kRayKernel,   kMotionTypes,    kMotionVectors,
      kRandomDirection, kPlaceKernel,    kMotionArrays, kFlightKernel, kWalkKernel,  kFloatingKernel, kBirthKernel,
      kResponseKernel,  kTransferKernel, kSpreadKernel, kTallyTypes,   kTallyKernel, kMotionEntries};
  return device.build("motion", sources);
}

template <class T>
bool is_bytewise_same(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

}  // namespace

struct DeviceMotion::State {
  State(const Device& its_device, const MotionScene& scene, const SurfaceAtlas& surface, const RunControl& control)
      : device(its_device),
        program(build_motion_program(device)),
        trace(program.kernel("trace_drops")),
        respond(program.kernel("respond_drops")),
        end(program.kernel("end_lives")),
        nodes(upload_some(device, scene.rays.nodes())),
        blocks(upload_some(device, scene.rays.blocks())),
        frames(upload_some(device, scene.frames.frames())),
        corner_normals(upload_some(device, scene.frames.corner_normals())),
        links(upload_some(device, scene.links.codes())),
        empty_cells(upload_some(device, scene.free_space.empty())),
        clear(upload_some(device, std::span<const std::uint8_t>(scene.clearance.all(control)))),
        places{.width = surface.grid().width, .height = surface.grid().height},
        corner_texels(upload_some(device, surface.corner_texels())),
        charts(upload_some(device, surface.charts())),
        fallbacks(upload_some(device, surface.fallbacks())),
        tile_charts(upload_some(device, surface.tile_charts())),
        no_wet(device.allocate<std::uint16_t>(1)) {}

  /// Calls launch(items) for the drops of each batch.
  template <class Launch>
  void in_batches(std::size_t num, Launch&& launch) {
    for (std::size_t begin = 0; begin < num; begin += kGammatonBatch) {
      const std::size_t size = std::min(kGammatonBatch, num - begin);
      launch(device::Items{.first = begin,
                           .num = (size + kGammatonGroup - 1) / kGammatonGroup * kGammatonGroup,
                           .group = kGammatonGroup});
    }
  }

  Device device;
  device::Program program;
  device::Kernel trace, respond, end;
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
  Buffer<std::int32_t> tile_charts;
  Buffer<std::uint16_t> no_wet;        ///< For kernels that read none.
  std::vector<EmitterFacts> emitters;  ///< Emitters as the device has them.
  Buffer<EmitterFacts> emitters_there;
  std::vector<std::uint32_t> loads;
  Buffer<std::uint32_t> loads_there;
};

DeviceMotion::DeviceMotion(const Device& device, const MotionScene& scene, const SurfaceAtlas& surface,
                           const RunControl& control)
    : state_(std::make_unique<State>(device, scene, surface, control)) {}
DeviceMotion::~DeviceMotion() = default;

void DeviceMotion::trace(const MotionScene& scene, const MotionCall& call, std::span<const EmitterFacts> emitters,
                         const LifeCall& life, DeviceArrays& a) {
  State& s = *state_;
  if (!is_bytewise_same(emitters, std::span<const EmitterFacts>(s.emitters))) {
    if (s.emitters_there.size() != emitters.size()) s.emitters_there = s.device.allocate<EmitterFacts>(emitters.size());
    s.emitters.assign(emitters.begin(), emitters.end());
    s.device.write_soon(emitters, s.emitters_there);
  }
  if (!is_bytewise_same(life.loads, std::span<const std::uint32_t>(s.loads))) {
    if (s.loads_there.size() != life.loads.size()) s.loads_there = s.device.allocate<std::uint32_t>(life.loads.size());
    s.loads.assign(life.loads.begin(), life.loads.end());
    s.device.write_soon(life.loads, s.loads_there);
  }
  s.in_batches(a.num_gammatons, [&](const device::Items& items) {
    s.trace.run(items, scene.facts, s.nodes, s.blocks, s.frames, s.corner_normals, s.links, s.empty_cells, s.clear,
                s.places, s.corner_texels, s.charts, s.fallbacks, s.tile_charts, a.triangles, s.no_wet,
                std::uint64_t{0}, call, s.emitters_there, a.num_gammatons, a.drops, a.num_materials,
                life.is_deposited ? 1U : 0U, a.cargo, a.trails, a.ended, a.endings[0], a.tally, s.loads_there, a.met,
                a.contacts);
  });
}

void DeviceMotion::respond(const MotionScene& scene, const MotionCall& call, bool is_deposited, DeviceArrays& a) {
  State& s = *state_;
  const bool is_wet = scene.wet != nullptr;
  const std::uint64_t first_wet = is_wet ? static_cast<std::uint64_t>(scene.wet->material) * a.num_texels : 0;
  s.in_batches(a.num_gammatons, [&](const device::Items& items) {
    s.respond.run(items, scene.facts, s.nodes, s.blocks, s.frames, s.corner_normals, s.links, s.empty_cells, s.clear,
                  s.places, s.corner_texels, s.charts, s.fallbacks, s.tile_charts, a.triangles,
                  is_wet ? a.amounts : s.no_wet, first_wet, call, a.num_gammatons, a.drops, a.num_materials,
                  is_deposited ? 1U : 0U, a.cargo, a.trails, a.ended, a.endings[1], a.tally);
  });
}

void DeviceMotion::end_lives(DeviceArrays& a) {
  state_->in_batches(a.num_gammatons, [&](const device::Items& items) {
    state_->end.run(items, a.num_gammatons, a.num_materials, a.cargo, a.ended, a.tally);
  });
}

}  // namespace patinate::simulation
