#include <cmath>

#include "libcommon/geometry/light_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(lights_text) {
  const std::filesystem::path file = fuzz::fuzz_file("dome.lp", bytes);
  for (const auto kind : {LightRows::Kind::Positions, LightRows::Kind::Directions}) {
    for (const Light& light : read_lights(file, 1000.0, nullptr, {.kind = kind, .frame = LightRows::Frame::Scanner})) {
      fuzz::require(light.position.allFinite() && std::abs(light.direction.norm() - 1.0) < 1e-9,
                    "lights stand somewhere");
    }
  }
}
