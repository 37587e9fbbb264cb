#include "tests/fuzz/cloud_checks.h"

PATINATE_FUZZ_TARGET(pcd) { patinate::fuzz::read_and_check_cloud("scan.pcd", bytes); }
