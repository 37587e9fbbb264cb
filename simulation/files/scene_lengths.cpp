#include "simulation/files/scene_lengths.h"

#include <vector>

namespace patinate::simulation {

Range up_to_farthest(double mm_per_unit) { return between(0, kFarthest_mm / mm_per_unit); }

Range above_0_up_to_farthest(double mm_per_unit) {
  Range range = above(0);
  range.high = kFarthest_mm / mm_per_unit;
  return range;
}

Vec3 checked_position(const JsonReader& json, const Vec3& position_mm) {
  if (!(position_mm.cwiseAbs().maxCoeff() <= kFarthest_mm)) json.fail("a position within 1e9 mm of the origin");
  return position_mm;
}

Vec3 read_position(const JsonReader& json, double mm_per_unit) {
  const std::vector<double> v = json.numbers(3);
  return checked_position(json, Vec3(v[0], v[1], v[2]) * mm_per_unit);
}

}  // namespace patinate::simulation
