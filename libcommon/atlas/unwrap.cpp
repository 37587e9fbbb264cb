#include "libcommon/atlas/unwrap.h"

namespace patinate {

void describe(OptionVisitor& v, UnwrapOptions& o) {
  v.visit({"max_normal_angle_deg", "Half opening of the cone that a chart's normals keep to while it grows", "deg", between(5, 85)}, o.max_normal_angle_deg);
  v.visit({"max_stretch", "Charts are cut until 95 % of their area is stretched by no more than this", "", between(1.05, 10)}, o.max_stretch);
  v.visit({"resolution", "Texels along each side of the atlas that the UVs are packed for", "", between(16, 16384)}, o.resolution);
  v.visit({"gutter_texels", "Least number of texels between two charts", "", between(1, 64)}, o.gutter_texels);
}

}  // namespace patinate
