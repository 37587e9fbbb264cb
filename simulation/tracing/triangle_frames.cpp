#include "simulation/tracing/triangle_frames.h"

#include <Eigen/Geometry>

namespace patinate::simulation {

TriangleFrames::TriangleFrames(const SceneMesh& scene_mesh, const RayTracer& tracer) : center_(tracer.center()) {
  const Mesh& mesh = scene_mesh.mesh;
  const auto narrow = [](const Vec3& v) {
    return Float3{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
  };
  frames_.reserve(mesh.triangles.size());
  corner_normals_.reserve(mesh.normals.empty() ? 0 : mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Vec3, 3> p;
    TriangleFrame frame{};
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = tracer.rounded(mesh.positions[static_cast<std::size_t>(mesh.triangles[t][k])]) - center_;
      frame.corner[k] = narrow(p[k]);
    }
    const Vec3 e1 = p[1] - p[0], e2 = p[2] - p[0], area = e1.cross(e2);
    const double square = area.squaredNorm();
    if (square > 0.0) {
      frame.normal = narrow(area / std::sqrt(square));
      frame.gradient_1 = narrow(e2.cross(area) / square);
      frame.gradient_2 = narrow(area.cross(e1) / square);
    }
    frames_.push_back(frame);
    if (mesh.normals.empty()) continue;
    std::array<Float3, 3> normals{};
    for (std::size_t k = 0; k < 3; ++k)
      normals[k] = narrow(mesh.normals[static_cast<std::size_t>(mesh.normal_triangles[t][k])]);
    corner_normals_.push_back(normals);
  }
}

Vec3 TriangleFrames::point(const SurfacePlace& at) const {
  return (1.0 - at.b1 - at.b2) * corner(at.triangle, 0) + at.b1 * corner(at.triangle, 1) +
         at.b2 * corner(at.triangle, 2);
}

Vec3 TriangleFrames::shading_normal(const SurfacePlace& at) const {
  if (corner_normals_.empty()) return normal(at.triangle);
  const std::array<Float3, 3>& n = corner_normals_[static_cast<std::size_t>(at.triangle)];
  const Vec3 sum = (1.0 - at.b1 - at.b2) * wide(n[0]) + at.b1 * wide(n[1]) + at.b2 * wide(n[2]);
  const double length = std::sqrt(sum.squaredNorm());
  return length > 1e-3 ? Vec3(sum / length) : normal(at.triangle);
}

}  // namespace patinate::simulation
