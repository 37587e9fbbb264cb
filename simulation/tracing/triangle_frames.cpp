#include "simulation/tracing/triangle_frames.h"

#include <Eigen/Geometry>
#include <array>

namespace patinate::simulation {

namespace {

void narrow(const Vec3& v, float (&out)[3]) {
  for (int a = 0; a < 3; ++a) out[a] = static_cast<float>(v[a]);
}

}  // namespace

TriangleFrames::TriangleFrames(const SceneMesh& scene_mesh, const RayTracer& tracer) : center_(tracer.center()) {
  const Mesh& mesh = scene_mesh.mesh;
  frames_.reserve(mesh.triangles.size());
  corner_normals_.reserve(mesh.normals.empty() ? 0 : mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Vec3, 3> p;
    TriangleFrame frame{};
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = tracer.rounded(mesh.positions[mesh.triangles[t][k]]) - center_;
      narrow(p[k], frame.corner[k]);
    }
    const Vec3 e1 = p[1] - p[0], e2 = p[2] - p[0], area = e1.cross(e2);
    const double square = area.squaredNorm();
    if (square > 0.0) {
      narrow(area / std::sqrt(square), frame.normal);
      narrow(e2.cross(area) / square, frame.gradient_1);
      narrow(area.cross(e1) / square, frame.gradient_2);
    }
    frames_.push_back(frame);
    if (mesh.normals.empty()) continue;
    CornerNormals normals{};
    for (std::size_t k = 0; k < 3; ++k) narrow(mesh.normals[mesh.normal_triangles[t][k]], normals.corner[k]);
    corner_normals_.push_back(normals);
  }
}

}  // namespace patinate::simulation
