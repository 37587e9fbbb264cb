#include "tests/fuzz/mesh_checks.h"

PATINATE_FUZZ_TARGET(obj) { patinate::fuzz::read_and_check_mesh("mesh.obj", bytes); }
