#include "capture/unlighting/cast_shadows.h"

#include "capture/unlighting/unlight_work.h"
#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/geometry/ray_scene.h"
#include "patinate/core/error.h"

namespace patinate::capture {

double median_edge(const Mesh& mesh) {
  std::vector<double> lengths;
  lengths.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& a = mesh.positions[t[k]];
      lengths.push_back((mesh.positions[t[(k + 1) % 3]] - a).norm());
    }
  }
  return median(std::move(lengths));
}

ImageU8 cast_shadows(const Mesh& blockers, const ImageF& position_mm, const ImageF& normal, const ImageU8& mask,
                     const std::vector<Light>& lights, double offset_mm, const RunControl& control) {
  if (!(offset_mm >= 0.0)) throw InvalidInput("cast shadows: offset_mm must be >= 0");
  if (!position_mm.same_size(normal) || (!mask.empty() && !mask.same_size(normal)))
    throw InvalidInput("cast shadows: maps differ in size");
  const int width = normal.width(), height = normal.height();
  ImageU8 shadow(width, height, static_cast<int>(lights.size()));
  const RayScene scene(blockers);
  const double beyond = 4.0 * bounding_box(blockers).diagonal();
  constexpr std::int64_t kRows = 2;
  parallel_for(height, kRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        if (!is_inside(mask, x, y)) continue;
        const Vec3 n = vector_of(normal, x, y), p = vector_of(position_mm, x, y), from = p + offset_mm * n;
        for (std::size_t k = 0; k < lights.size(); ++k) {
          const Light& light = lights[k];
          if (n.dot(direction_to(light, p)) <= 0.0) continue;
          const Vec3 to = light.kind == Light::Kind::Near ? light.position : Vec3(from + beyond * light.direction);
          if (scene.is_blocked(from, to, offset_mm)) shadow.at(x, y, static_cast<int>(k)) = 255;
        }
      }
    }
  });
  return shadow;
}

}  // namespace patinate::capture
