#include "libcommon/controls/height.h"

#include <algorithm>
#include <limits>

#include "libcommon/controls/light_set.h"

namespace patinate {

ControlMap height_map(const TexelMap& map, const std::array<double, 3>& up_numbers, const RunControl& control) {
  const Vec3 up = unit_direction(up_numbers, "up");
  const Mesh& mesh = map.mesh();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Triangle& t : mesh.triangles) {
    for (const int corner : t) {
      const double height = mesh.positions[static_cast<std::size_t>(corner)].dot(up);
      low = std::min(low, height);
      high = std::max(high, height);
    }
  }
  ImageF values(map.width(), map.height());
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (map.is_covered(t))
      values.values()[static_cast<std::size_t>(t)] = static_cast<float>(map.position_mm(t).dot(up) - low);
  }
  ControlMap out = normalized_control(values, map, {0.0, high > low ? high - low : 1.0}, "mm");
  control.report(1.0);
  return out;
}

}  // namespace patinate
