#include "libcommon/geometry/camera_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(camera_xml) {
  const Camera camera = read_camera(fuzz::fuzz_file("camera.xml", bytes));
  fuzz::require(camera.center().allFinite(), "a camera stands somewhere");
}
