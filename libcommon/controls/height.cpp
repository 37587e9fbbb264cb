#include "libcommon/controls/height.h"

#include <algorithm>
#include <limits>

#include "libcommon/core/parallel.h"

namespace patinate {

ControlMap height_map(const TexelMap& map, const std::array<double, 3>& up_numbers, const RunControl& control) {
  const Vec3 up = unit_direction(up_numbers, "up");
  const Mesh& mesh = map.mesh();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Triangle& t : mesh.triangles) {
    for (const int corner : t) {
      const double height = mesh.positions[corner].dot(up);
      low = std::min(low, height);
      high = std::max(high, height);
    }
  }
  const double range = high > low ? high - low : 1.0;
  ImageF values(map.width(), map.height());
  parallel_for(map.num_texels(), 4096, control, [&](TexelId begin, TexelId end) {
    for (TexelId t = begin; t < end; ++t) {
      if (!map.is_covered(t)) continue;
      const double height = static_cast<double>(static_cast<float>(map.position_mm(t).dot(up) - low));
      values.values()[t] = static_cast<float>(std::clamp(height / range, 0.0, 1.0));
    }
  });
  control.report(1.0);
  return {std::move(values), 0.0, range, "mm", false, {}};
}

}  // namespace patinate
