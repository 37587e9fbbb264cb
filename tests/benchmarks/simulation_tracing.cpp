#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/device/device.h"
#include "libcommon/geometry/ray_scene.h"
#include "patinate/mesh_files/mesh_io.h"
#include "simulation/tracing/device_rays.h"
#include "simulation/tracing/motion.h"
#include "simulation/tracing/ray_tracer.h"
#include "tests/benchmarks/device_share.h"
#include "tests/benchmarks/simulation_parts.h"
#include "tests/benchmarks/timing.h"
#include "tests/libcommon/geometry/shapes.h"

namespace patinate::benchmarks {

namespace {

constexpr double kTurn = 6.283185307179586;

/// A bumpy torus of about 2 n^2 triangles, 400 mm across, with UVs.
Mesh bumpy_torus(int n) {
  return testing_support::make_patch(n, n, [](double u, double v) {
    const double bump = 50.0 + 6.0 * std::sin(12.0 * kTurn * u) * std::sin(9.0 * kTurn * v);
    const double r = 150.0 + bump * std::cos(kTurn * v);
    return Vec3(r * std::cos(kTurn * u), r * std::sin(kTurn * u), bump * std::sin(kTurn * v));
  });
}

Vec3 random_vector(RandomStream& random) {
  return {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
}

simulation::Scene scene_of(Mesh mesh, std::string name) {
  simulation::Scene scene;
  scene.materials = {"water"};
  scene.appearance.resize(1);
  simulation::SceneObject object;
  object.name = std::move(name);
  object.mesh = std::move(mesh);
  scene.objects.push_back(std::move(object));
  simulation::Emitter rain;
  rain.name = "rain";
  rain.shape = simulation::EmitterShape::Sky;
  rain.spread_deg = 10.0;
  rain.speed_mm_s = 3000.0;
  scene.emitters.push_back(rain);
  return scene;
}

void measure(const simulation::Scene& made, std::int64_t n) {
  simulation::Scene scene = made;
  scene.emitters[0].gammatons = n;
  const simulation::SceneMesh mesh = simulation::make_scene_mesh(scene);
  const simulation::SurfaceAtlas surface(mesh, scene.resolution);
  simulation::GammatonTracer tracer(mesh, surface);
  simulation::Gammatons gammatons = simulation::make_gammatons(scene);
  simulation::TraceResult traced, responded;
  std::int64_t iteration = 0;
  const auto step = [&](int num_threads, double& trace_s, double& respond_s, std::int64_t& segments,
                        std::int64_t& contacts) {
    RunControl control;
    control.num_threads = num_threads;
    trace_s += seconds([&] { tracer.trace(gammatons, scene, iteration, traced, control); });
    respond_s += seconds([&] { tracer.respond(gammatons, scene, iteration, responded, nullptr, control); });
    segments += traced.counters.segments;
    contacts += traced.counters.contacts;
    ++iteration;
  };
  double ignored = 0.0;
  std::int64_t uncounted = 0;
  for (int k = 0; k < 60; ++k) step(2, ignored, ignored, uncounted, uncounted);
  const int steps = n > 500000 ? 5 : (n > 50000 ? 20 : 200);
  const auto report = [&](const std::string& where, int num_threads) {
    double trace_s = 0.0, respond_s = 0.0;
    std::int64_t segments = 0, contacts = 0;
    for (int k = 0; k < steps; ++k) step(num_threads, trace_s, respond_s, segments, contacts);
    std::printf(
        "%-16s %8lld gammatons, %s: %6.2f M segments/s, %6.2f M contacts/s; %.2f segments and %.2f contacts a "
        "gammaton; trace %.3f ms, respond %.3f ms an iteration\n",
        scene.objects[0].name.c_str(), static_cast<long long>(n), where.c_str(),
        static_cast<double>(segments) / (trace_s + respond_s) * 1e-6,
        static_cast<double>(contacts) / (trace_s + respond_s) * 1e-6,
        static_cast<double>(segments) / static_cast<double>(n * steps),
        static_cast<double>(contacts) / static_cast<double>(n * steps), 1e3 * trace_s / steps, 1e3 * respond_s / steps);
  };
  for (const int num_threads : {1, 2}) report(std::to_string(num_threads) + " threads", num_threads);
}

/// Traces the rays on every OpenCL device, the way there and back included.
void rays_on_devices(const simulation::RayTracer& rays, const std::vector<Vec3>& origins,
                     const std::vector<Vec3>& directions, double reach) {
  std::vector<simulation::RayQuery> queries(origins.size());
  for (std::size_t i = 0; i < queries.size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      queries[i].origin[a] = origins[i][a];
      queries[i].direction[a] = directions[i][a];
    }
    queries[i].max_distance = reach;
  }
  for (const device::DeviceInfo& info : device::list_devices()) {
    const device::Device device(info);
    simulation::DeviceRays there(device, rays);
    const DeviceShare share(device);
    const double time = median_of_five([&] { (void)there.first_hits(queries); });
    std::printf("  %s: %.2f M/s, %s\n", info.name.c_str(), static_cast<double>(queries.size()) / time * 1e-6,
                share.text(5).c_str());
  }
}

}  // namespace

void rays() {
  for (const int n : {187, 367}) {
    const Mesh mesh = bumpy_torus(n);
    simulation::RayTracer ours{Mesh{}};
    const double build = seconds([&] { ours = simulation::RayTracer(mesh); });
    const RayScene embree(mesh);
    constexpr int kRays = 400000;
    std::vector<Vec3> origins, directions;
    RandomStream random(1, 0);
    for (int i = 0; i < kRays; ++i) {
      origins.push_back(500.0 * random_vector(random));
      directions.push_back(random_vector(random).normalized());
    }
    for (const double reach : {1e30, 5.0}) {
      if (reach < 1e30) {  // short rays start on the surface
        for (int i = 0; i < kRays; ++i) {
          const auto t = static_cast<std::size_t>(random.below(static_cast<std::uint32_t>(mesh.num_triangles())));
          origins[i] = mesh.positions[mesh.triangles[t][0]] + random_vector(random);
        }
      }
      std::int64_t hits = 0, their_hits = 0;
      const double a = median_of_five([&] {
        hits = 0;
        for (std::size_t i = 0; i < origins.size(); ++i)
          hits += ours.first_hit(origins[i], directions[i], 0.0, reach).triangle >= 0 ? 1 : 0;
      });
      const double b = median_of_five([&] {
        their_hits = 0;
        for (std::size_t i = 0; i < origins.size(); ++i)
          their_hits += embree.first_hit(origins[i], directions[i], 0.0, reach) ? 1 : 0;
      });
      std::printf(
          "%d triangles, rays of %s: ours %.2f M/s, Embree %.2f M/s, ratio %.2f; hits %lld and %lld; built in %.0f "
          "ms\n",
          mesh.num_triangles(), reach > 1e9 ? "any length" : "5 mm", kRays / a * 1e-6, kRays / b * 1e-6, b / a,
          static_cast<long long>(hits), static_cast<long long>(their_hits), 1e3 * build);
      rays_on_devices(ours, origins, directions, reach);
    }
  }
}

void gammatons() {
  const char* data = std::getenv("PATINATE_DATA");
  const std::filesystem::path hydrant =
      std::filesystem::path(data == nullptr ? "" : data) / "meshes/fire_hydrant/fire_hydrant_1k.gltf";
  std::vector<simulation::Scene> scenes{scene_of(bumpy_torus(187), "torus")};
  if (std::filesystem::exists(hydrant)) {
    Mesh mesh = read_mesh(hydrant);
    mesh = select_surfaces(mesh, mesh.surfaces.front().node, "");
    scale_mesh(mesh, 1000.0);
    scenes.push_back(scene_of(std::move(mesh), "fire_hydrant"));
  }
  for (const simulation::Scene& scene : scenes) {
    for (const std::int64_t n : {5000, 100000, 1000000}) measure(scene, n);
  }
}

}  // namespace patinate::benchmarks
