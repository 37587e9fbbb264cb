#include <algorithm>

#include "libcommon/core/parallel.h"
#include "patinate/controls/exposure.h"

namespace patinate {

void describe(OptionVisitor& v, FacingOptions& o) {
  v.visit({"direction", "what `facing` faces: from the surface to where light, rain or dust comes from", "", {}},
          std::span<double>(o.direction));
}

ControlMap facing_map(const TexelMap& map, const FacingOptions& options, const RunControl& control) {
  check_ranges(options);
  const Vec3 direction = unit_direction(options.direction, "direction");
  ControlMap out{ImageF(map.width(), map.height()), 0.0, 1.0, "cosine", {}};
  parallel_for(map.num_texels(), 16384, control, [&](TexelId begin, TexelId end) {
    for (TexelId t = begin; t < end; ++t) {
      if (!map.is_covered(t)) continue;
      const double cosine = map.normal(t).dot(direction);
      out.values.values()[static_cast<std::size_t>(t)] = static_cast<float>(std::clamp(cosine, 0.0, 1.0));
    }
  });
  return out;
}

}  // namespace patinate
