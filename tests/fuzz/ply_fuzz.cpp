#include "tests/fuzz/mesh_checks.h"

PATINATE_FUZZ_TARGET(ply) { patinate::fuzz::read_and_check_mesh("mesh.ply", bytes); }
