#include "libcommon/controls/spray_path_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

/// Painted strokes as JSON; spray_path has the CSV forms.
PATINATE_FUZZ_TARGET(strokes) {
  for (const SprayStop& stop : read_spray_path(fuzz::fuzz_file("strokes.json", bytes), Vec3(0, 0, 0))) {
    fuzz::require(stop.position_mm.allFinite() && stop.aim_mm.allFinite(), "stops are finite");
  }
}
