#include <algorithm>
#include <span>

#include "libcommon/core/parallel.h"
#include "patinate/controls/exposure.h"

namespace patinate {

void describe(OptionVisitor& v, FacingOptions& o) {
  v.visit({"direction", "direction from the surface to the source of light, rain or dust", "", {}},
          std::span<double>(o.direction));
}

ControlMap facing_map(const TexelMap& map, const FacingOptions& options, const RunControl& control) {
  check_ranges(options);
  const Vec3 direction = unit_direction(options.direction, "direction");
  ImageF values(map.width(), map.height());
  parallel_for(map.num_texels(), 4096, control, [&](TexelId begin, TexelId end) {
    for (TexelId t = begin; t < end; ++t) {
      if (map.is_covered(t))
        values.values()[t] = static_cast<float>(std::clamp(map.normal(t).dot(direction), 0.0, 1.0));
    }
  });
  return {std::move(values), 0.0, 1.0, "cosine", false, {}};
}

}  // namespace patinate
