#include "simulation/tracing/device_rays.h"

#include <algorithm>
#include <array>

namespace patinate::simulation {

using device::Buffer;

namespace {

constexpr std::size_t kRayGroup = 64;
constexpr std::size_t kRayBatch = std::size_t{1} << 18;  // Rays of one launch, which stays short.

device::Program build_ray_program(const device::Device& device) {
  const std::array<std::string_view, 4> sources{kRayTypes, kRayLanes, kRayKernel, kRayEntries};
  return device.build("rays", sources);
}

}  // namespace

struct DeviceRays::State {
  State(const device::Device& its_device, const RayTracer& rays)
      : device(its_device),
        first_hits(build_ray_program(device).kernel("first_hits")),
        frame(rays.frame()),
        has_nodes(!rays.nodes().empty()),
        nodes(device.upload(rays.nodes())),
        blocks(device.upload(rays.blocks())) {}

  device::Device device;
  device::Kernel first_hits;
  RayFrame frame;
  bool has_nodes;
  Buffer<BvhNode> nodes;
  Buffer<TriangleBlock> blocks;
};

DeviceRays::DeviceRays(const device::Device& device, const RayTracer& rays)
    : state_(std::make_unique<State>(device, rays)) {}
DeviceRays::~DeviceRays() = default;

std::vector<RayAnswer> DeviceRays::first_hits(std::span<const RayQuery> queries) {
  State& s = *state_;
  std::vector<RayAnswer> answers(queries.size());
  for (std::size_t begin = 0; s.has_nodes && begin < queries.size(); begin += kRayBatch) {
    const std::size_t num = std::min(kRayBatch, queries.size() - begin),
                      whole = (num + kRayGroup - 1) / kRayGroup * kRayGroup;
    std::vector<RayQuery> batch(whole);  // Those behind the last have no direction, and hit nothing.
    std::copy_n(queries.begin() + static_cast<std::ptrdiff_t>(begin), num, batch.begin());
    const auto found = s.device.allocate<RayAnswer>(whole);
    s.first_hits.run({.num = whole, .group = kRayGroup}, s.frame, s.nodes, s.blocks, s.device.upload(batch), found);
    s.device.read(found, std::span(answers).subspan(begin, num));
  }
  return answers;
}

}  // namespace patinate::simulation
