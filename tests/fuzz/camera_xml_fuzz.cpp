#include "tests/fuzz/camera_checks.h"

PATINATE_FUZZ_TARGET(camera_xml) { patinate::fuzz::read_and_check_camera("camera.xml", bytes); }
