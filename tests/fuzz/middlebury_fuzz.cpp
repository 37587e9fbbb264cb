#include "libcommon/geometry/camera_text_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(middlebury) {
  const CameraParameters p = read_middlebury_camera(fuzz::fuzz_file("a_par.txt", bytes), "", 640, 480);
  fuzz::require(p.rotation.allFinite(), "rotations are finite");
}
