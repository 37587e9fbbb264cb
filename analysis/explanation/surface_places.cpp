#include "analysis/explanation/surface_places.h"

#include <Eigen/Geometry>

namespace patinate::analysis {

std::vector<double> SurfacePlaces::values_of(const ImageF& image) const {
  std::vector<double> values;
  values.reserve(texels.size());
  for (const TexelId t : texels) values.push_back(static_cast<double>(image.values()[t]));
  return values;
}

SurfacePlaces surface_places(const TexelMap& map, const ImageU8& mask, int count) {
  std::vector<double> texel_mm2;  // Texel area of each triangle.
  for (int t = 0; t < map.mesh().num_triangles(); ++t) {
    const Eigen::Matrix<double, 3, 2> steps = map.mm_per_texel(t);
    texel_mm2.push_back(Vec3(steps.col(0)).cross(Vec3(steps.col(1))).norm());
  }
  const auto area_of = [&](TexelId t) {
    if (!map.is_covered(t) || (!mask.empty() && mask.values()[t] == 0)) return 0.0;
    return texel_mm2[map.triangle(t)];
  };
  SurfacePlaces places;
  for (TexelId t = 0; t < map.num_texels(); ++t) places.area_mm2 += area_of(t);
  const double share = places.area_mm2 / count;
  double passed = 0.0, next = 0.5 * share;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    const double area = area_of(t);
    passed += area;
    if (!(area > 0.0) || passed < next) continue;
    while (next <= passed) next += share;
    places.texels.push_back(t);
    places.positions_mm.push_back(map.position_mm(t));
  }
  return places;
}

}  // namespace patinate::analysis
