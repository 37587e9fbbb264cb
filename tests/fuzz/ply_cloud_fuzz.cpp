#include "tests/fuzz/cloud_checks.h"

PATINATE_FUZZ_TARGET(ply_cloud) { patinate::fuzz::read_and_check_cloud("scan.ply", bytes); }
