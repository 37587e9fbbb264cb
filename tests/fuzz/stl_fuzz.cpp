#include "tests/fuzz/mesh_checks.h"

PATINATE_FUZZ_TARGET(stl) { patinate::fuzz::read_and_check_mesh("mesh.stl", bytes); }
