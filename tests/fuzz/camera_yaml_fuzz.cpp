#include "tests/fuzz/camera_checks.h"

PATINATE_FUZZ_TARGET(camera_yaml) { patinate::fuzz::read_and_check_camera("camera.yml", bytes); }
