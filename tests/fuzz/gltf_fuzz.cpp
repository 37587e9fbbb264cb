#include "tests/fuzz/mesh_checks.h"

PATINATE_FUZZ_TARGET(gltf) { patinate::fuzz::read_and_check_mesh("mesh.gltf", bytes); }
