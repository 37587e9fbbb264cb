#include "simulation/composition/texel_places.h"

#include <cmath>

namespace patinate::simulation::composition {

TexelPlaces::TexelPlaces(const SceneMesh& scene_mesh, const SurfaceAtlas& surface) : surface_(&surface) {
  const Mesh& mesh = scene_mesh.mesh;
  const double side = surface.grid().width;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Matrix<double, 3, 2> step = surface.mm_per_texel(static_cast<int>(t)).cast<double>();
    const Vec2& uv = mesh.uvs[mesh.uv_triangles[t][0]];
    const Vec2 texel(uv.x() * side - 0.5, (1.0 - uv.y()) * side - 0.5);
    const Vec3& corner = mesh.positions[mesh.triangles[t][0]];
    Place place;
    place.step = step;
    for (int i = 0; i < 3; ++i) place.origin[i] = corner[i] - (step(i, 0) * texel.x() + step(i, 1) * texel.y());
    places_.push_back(place);
    std::array<Eigen::Vector3f, 3> normals;
    for (std::size_t k = 0; k < 3; ++k) normals[k] = mesh.normals[mesh.normal_triangles[t][k]].cast<float>();
    normals_.push_back(normals);
  }
}

Vec3 TexelPlaces::point(TexelIndex t) const {
  const int triangle = surface_->triangle(t);
  if (triangle < 0) return Vec3::Zero();
  const Place& place = places_[triangle];
  const double x = surface_->grid().x(t), y = surface_->grid().y(t);
  Vec3 point;
  for (int i = 0; i < 3; ++i) point[i] = place.origin[i] + (place.step(i, 0) * x + place.step(i, 1) * y);
  return point;
}

Vec3 TexelPlaces::normal(TexelIndex t) const {
  const int triangle = surface_->triangle(t);
  if (triangle < 0) return Vec3::Zero();
  const std::array<double, 3> weights = surface_->corner_weights(t);
  const std::array<Eigen::Vector3f, 3>& corners = normals_[triangle];
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) sum[i] += weights[k] * static_cast<double>(corners[k][i]);
  }
  const double length = std::sqrt(sum[0] * sum[0] + (sum[1] * sum[1] + sum[2] * sum[2]));
  return length > 1e-9 ? Vec3(sum / length) : Vec3(Vec3::Zero());
}

std::size_t TexelPlaces::memory() const {
  return places_.capacity() * sizeof(Place) + normals_.capacity() * sizeof(normals_[0]);
}

}  // namespace patinate::simulation::composition
