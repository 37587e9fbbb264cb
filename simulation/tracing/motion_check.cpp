#include <cstring>
#include <optional>
#include <vector>

#include "libcommon/core/random.h"
#include "simulation/device/check_scene.h"
#include "simulation/device/device_amounts.h"
#include "simulation/tracing/device_motion.h"
#include "simulation/tracing/emitter.h"

namespace patinate::simulation {

namespace {

constexpr std::uint32_t kGammatons = 2048;
constexpr std::uint64_t kIterations = 24;

/// The plate of other checks, with hills; it rains on it, and drops bounce, float and follow what is wet.
Scene hills_in_the_rain() {
  constexpr int kCells = 24;
  Scene scene = check_scene();
  Mesh& mesh = scene.objects[0].mesh;
  mesh.positions.clear(), mesh.uvs.clear(), mesh.triangles.clear(), mesh.uv_triangles.clear();
  for (int y = 0; y <= kCells; ++y) {
    for (int x = 0; x <= kCells; ++x) {
      RandomStream random(8, static_cast<std::uint64_t>(y * (kCells + 1) + x));
      mesh.positions.emplace_back(2.0 * x, 4.0 * random.uniform(), 2.0 * y);
      mesh.uvs.emplace_back((x + 0.5) / (kCells + 1), (y + 0.5) / (kCells + 1));
    }
  }
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const int i = y * (kCells + 1) + x;
      mesh.triangles.push_back({i, i + kCells + 2, i + 1});
      mesh.triangles.push_back({i, i + kCells + 1, i + kCells + 2});
    }
  }
  mesh.uv_triangles = mesh.triangles;
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  scene.emitters.push_back({.name = "rain",
                            .shape = EmitterShape::Sky,
                            .direction = Vec3(0.2, -1, 0.1),
                            .spread_deg = 20,
                            .speed_mm_s = 2000,
                            .gammatons = kGammatons});
  scene.behavior = {.bounce = 0.2, .floating = 0.75, .absorb = 0.05};
  scene.tracing.wet_attraction = 0.5;
  scene.tracing.rivulet_mm = 3.0;
  return scene;
}

/// What a device's entries do (motion_device.cl), here.
void trace_here(const MotionScene& scene, const MotionCall& call, const EmitterFacts& emitter,
                const SurfaceAtlas& surface, std::uint32_t gammaton, DropRecord& record) {
  Drop g = drop_of(&record);
  const Told told = trace_drop(scene, call, emitter, gammaton, g, record.num_births);
  put_drop(&g, &record);
  record.texel = told.end == motion_types::kEndContact ? surface.texel_of(g.at.triangle, g.at.b1, g.at.b2) : kNoTexel;
  record.end = told.end;
  record.is_born = told.is_born;
  record.is_landing = told.is_landing;
  record.num_pieces = told.num_pieces;
}

void respond_here(const MotionScene& scene, const MotionCall& call, std::uint32_t gammaton, DropRecord& record) {
  record.end = motion_types::kStaysAlive;
  if (record.state != motion_types::kIsInContact) return;
  Drop g = drop_of(&record);
  const Outcome outcome = respond_to_contact(scene, call, gammaton, g, shading_normal(scene, g.at));
  if (outcome != Outcome::Alive) g.state = motion_types::kIsWaiting;
  put_drop(&g, &record);
  record.end = static_cast<std::uint32_t>(outcome);
}

}  // namespace

device::CheckResult check_motion(const device::Device& device) {
  const Scene scene = hills_in_the_rain();
  const CheckSurface on(scene);
  const MaterialAtlas wet = on.any_amounts();
  const RayTracer rays(on.mesh.mesh);
  const TriangleFrames frames(on.mesh, rays);
  const SurfaceLinks links(on.mesh);
  const FreeSpace free_space(rays);
  Clearance clearance(rays, frames, on.mesh.mesh.num_triangles(), scene.tracing.epsilon_mm);
  DeviceAmounts wet_there(device, wet);
  wet_there.update(wet);
  const WetPaths paths{
      .atlas = &wet, .on_device = &wet_there, .material = 0, .weight = scene.tracing.wet_attraction, .width_mm = 3.0};
  const MotionScene motion = motion_scene(scene, rays, frames, links, free_space, clearance, &paths);
  const EmitterFacts rain = facts_of(place_emitter(scene.emitters[0], on.mesh, rays, scene.gravity_mm_s2));
  DeviceMotion there(device, motion, on.surface, {});
  DropRecord waiting{};
  waiting.triangle = -1;
  std::vector<DropRecord> drops(kGammatons, waiting);
  device::CheckResult check;
  for (std::uint64_t i = 0; i < kIterations; ++i) {
    const MotionCall call{.iteration = i, .seed = 9, .begin = 0, .num_shares = 1, .born_share = 0};
    std::vector<DropRecord> here = drops;
    const auto compare = [&] {
      for (std::size_t k = 0; k < drops.size(); ++k)
        check.num_different += std::memcmp(&here[k], &drops[k], sizeof(DropRecord)) == 0 ? 0 : 1;
      check.num_items += static_cast<std::int64_t>(drops.size());
    };
    for (std::uint32_t k = 0; k < kGammatons; ++k) trace_here(motion, call, rain, on.surface, k, here[k]);
    there.put(drops);
    there.trace(motion, call, std::span(&rain, 1), 0, drops);
    compare();
    for (std::uint32_t k = 0; k < kGammatons; ++k) respond_here(motion, call, k, here[k]);
    there.respond(motion, call, 0, drops);
    compare();
  }
  return check;
}

}  // namespace patinate::simulation
