#include "libcommon/controls/spray_path_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(spray_path) {
  for (const SprayStop& stop : read_spray_path(fuzz::fuzz_file("path.csv", bytes), Vec3(0, 0, 0))) {
    fuzz::require(stop.position_mm.allFinite() && stop.aim_mm.allFinite(), "stops are finite");
  }
}
