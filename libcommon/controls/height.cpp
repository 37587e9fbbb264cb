#include "libcommon/controls/height.h"

#include "libcommon/controls/part_controls.h"

namespace patinate {

ControlMap height_map(const TexelMap& map, const std::array<double, 3>& up, const RunControl& control) {
  ControlMap out = height_part(map, up, map.rect(), control);
  control.report(1.0);
  return out;
}

}  // namespace patinate
