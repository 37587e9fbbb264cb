#include "libcommon/output/hit_corners.h"

#include <algorithm>

#include "libcommon/output/sampling.h"

namespace patinate {

HitCorners corners_of(const Mesh& mesh, const std::vector<float>& open, std::size_t triangle) {
  HitCorners corners;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t corner = mesh.triangles[triangle][k];
    corners.positions[k] = mesh.positions[corner];
    corners.normals[k] = mesh.normals[mesh.normal_triangles[triangle][k]];
    corners.uvs[k] = mesh.uvs[mesh.uv_triangles[triangle][k]];
    corners.open[k] = static_cast<double>(open[corner]);
  }
  return corners;
}

Vec3 smooth_place(const HitCorners& corners, const RayHit& hit, double side) {
  const Vec3 place = blend(corners.positions, hit.b1, hit.b2);
  std::array<Vec3, 3> lifted;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 off = place - corners.positions[k];
    lifted[k] = place - std::min(0.0, off.dot(side * corners.normals[k])) * side * corners.normals[k];
  }
  return blend(lifted, hit.b1, hit.b2);
}

Vec3 mapped_normal(const CornerTangents& tangents, const RayHit& hit, const Vec3& smooth, const Vec3& n) {
  const auto triangle = static_cast<std::size_t>(hit.triangle);
  const Vec3 along = blend(tangents.tangent[triangle], hit.b1, hit.b2);
  const Vec3 flat = along - along.dot(smooth) * smooth;
  if (!(flat.norm() > 1e-9)) return smooth;
  const Vec3 tangent = flat.normalized();
  const Vec3 up = (tangents.is_mirrored[triangle] ? -1.0 : 1.0) * smooth.cross(tangent);
  const Vec3 normal = n.x() * tangent + n.y() * up + n.z() * smooth;
  return normal.norm() > 1e-6 ? Vec3(normal.normalized()) : smooth;
}

}  // namespace patinate
