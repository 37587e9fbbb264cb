#include "simulation/tracing/scene_checks.h"

#include <array>

#include "libcommon/geometry/topology.h"
#include "patinate/core/error.h"
#include "simulation/tracing/emitter.h"

namespace patinate::simulation {

namespace {

constexpr std::uint32_t kBirthsLookedAt = 32;  ///< Births whose way is followed.

/// Directions without symmetry, so that grids and axes are not met edge-on.
const std::array<Vec3, 5> kDirections{Vec3(0.267, 0.805, 0.529), Vec3(-0.712, 0.341, 0.613), Vec3(0.493, -0.671, 0.554),
                                      Vec3(0.173, 0.247, -0.953), Vec3(-0.481, -0.539, -0.691)};

Mesh part_of(const SceneMesh& scene_mesh, int object) {
  return select_surfaces(scene_mesh.mesh, scene_mesh.mesh.surfaces[object].node, "");
}

}  // namespace

std::vector<std::string> describe_meshes(const SceneMesh& scene_mesh) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < scene_mesh.mesh.surfaces.size(); ++i) {
    const std::string name = "object '" + scene_mesh.mesh.surfaces[i].node + "'";
    const MeshTopology topology = mesh_topology(part_of(scene_mesh, static_cast<int>(i)));
    if (!topology.is_closed()) {
      lines.push_back(
          name + " is open (" + std::to_string(topology.num_boundary_loops) + " holes, " +
          std::to_string(topology.num_nonmanifold_triangles) +
          " triangles too many at an edge): gammatons may get behind its surface, and age both sides as one");
    } else if (signed_volume(scene_mesh, static_cast<int>(i)) < 0.0) {
      lines.push_back(name +
                      " is inside out (its normals point inward): it ages as it should, but its normal map would be "
                      "wrong; turn its triangles");
    }
  }
  return lines;
}

bool is_inside(const SceneMesh& scene_mesh, const RayTracer& tracer, int object, const Vec3& p) {
  int num_inside = 0;
  for (const Vec3& direction : kDirections) {
    int num_crossings = 0;
    double from = 0.0;
    while (true) {
      const TriangleHit hit = tracer.first_hit(p, direction, from, 1e30);
      if (hit.triangle < 0) break;
      from = hit.distance;
      if (scene_mesh.object[hit.triangle] == object) ++num_crossings;
    }
    num_inside += num_crossings % 2;
  }
  return num_inside >= 3;
}

void check_emitters(const Scene& scene, const SceneMesh& scene_mesh, const RayTracer& tracer) {
  std::vector<int> closed;
  for (int i = 0; i < static_cast<int>(scene_mesh.mesh.surfaces.size()); ++i) {
    if (mesh_topology(part_of(scene_mesh, i)).is_closed()) closed.push_back(i);
  }
  for (const Emitter& emitter : scene.emitters) {
    if (!emitter.is_on) continue;
    const PlacedEmitter placed = place_emitter(emitter, scene_mesh, tracer, scene.gravity_mm_s2);
    const std::uint32_t n = emitter.shape == EmitterShape::Point ? 1 : kBirthsLookedAt;
    for (std::uint32_t k = 0; k < n; ++k) {
      const Vec3 p = make_birth(placed, scene.seed, 0, k).position;
      for (const int object : closed) {
        if (!is_inside(scene_mesh, tracer, object, p)) continue;
        throw InvalidInput("emitter '" + emitter.name + "' lies " + (n > 1 ? "in part " : "") + "inside object '" +
                           scene_mesh.mesh.surfaces[object].node + "': its gammatons could not get out; move it");
      }
    }
  }
}

}  // namespace patinate::simulation
