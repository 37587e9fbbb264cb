#include <cmath>

#include "libcommon/geometry/light_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(lights_json) {
  for (const Light& light : read_lights(fuzz::fuzz_file("lights.json", bytes), 1000.0)) {
    fuzz::require(light.position.allFinite() && std::abs(light.direction.norm() - 1.0) < 1e-9,
                  "lights stand somewhere");
    fuzz::require((light.intensity.array() > 0).all(), "lights shine");
  }
}
