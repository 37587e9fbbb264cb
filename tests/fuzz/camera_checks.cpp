#include "tests/fuzz/camera_checks.h"

#include <cmath>

#include "patinate/geometry/camera_io.h"

namespace patinate::fuzz {

void read_and_check_camera(const std::string& name, Bytes bytes) {
  const Camera camera = read_camera(fuzz_file(name, bytes));
  require(camera.center().allFinite(), "a camera stands somewhere");
  const CameraParameters& p = camera.parameters();
  for (const double x : {0.0, 0.5 * p.width, 1.0 * p.width}) {
    for (const double y : {0.0, 0.5 * p.height, 1.0 * p.height}) {
      const auto ray = camera.ray({x, y});
      if (ray) require(std::abs(ray->direction.norm() - 1.0) < 1e-9, "a ray has a direction");
    }
  }
}

}  // namespace patinate::fuzz
