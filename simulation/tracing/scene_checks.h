/// \file
/// What a user should know of a scene's meshes and emitters before it runs.
#pragma once

#include <string>
#include <vector>

#include "patinate/simulation/scene.h"
#include "patinate/simulation/surface_atlas.h"
#include "simulation/tracing/ray_tracer.h"

namespace patinate::simulation {

/// One line for each object that is open ("object 'x' is open ...") or inside out. Neither is an error: gammatons hit
/// both sides of every triangle, and move on the side that they hit. Only emitters on a surface ask which side is
/// outside.
[[nodiscard]] std::vector<std::string> describe_meshes(const SceneMesh& scene_mesh);

/// Whether a point is inside an object's triangles: for three of five directions, the way out crosses them an odd
/// number of times.
[[nodiscard]] bool is_inside(const SceneMesh& scene_mesh, const RayTracer& tracer, int object, const Vec3& p);

/// @throws InvalidInput naming the emitter that is switched on and has births inside a closed object, and that object.
/// Looked at are 32 births of each emitter; those inside open objects are not.
void check_emitters(const Scene& scene, const SceneMesh& scene_mesh, const RayTracer& tracer);

}  // namespace patinate::simulation
