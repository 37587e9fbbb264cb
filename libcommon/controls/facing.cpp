#include "libcommon/controls/part_controls.h"

namespace patinate {

void describe(OptionVisitor& v, FacingOptions& o) {
  v.visit({"direction", "what `facing` faces: from the surface to where light, rain or dust comes from", "", {}},
          std::span<double>(o.direction));
}

ControlMap facing_map(const TexelMap& map, const FacingOptions& options, const RunControl& control) {
  return facing_part(map, options, map.rect(), control);
}

}  // namespace patinate
