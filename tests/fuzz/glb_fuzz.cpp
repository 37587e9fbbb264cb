#include "tests/fuzz/mesh_checks.h"

PATINATE_FUZZ_TARGET(glb) { patinate::fuzz::read_and_check_mesh("mesh.glb", bytes); }
