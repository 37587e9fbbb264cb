/// \file
/// What must hold of every camera that a file gives.
#pragma once

#include <string>

#include "tests/fuzz/fuzz_target.h"

namespace patinate::fuzz {

/// Reads it, and looks along the rays of its corners, which must end however strange the lens is.
void read_and_check_camera(const std::string& name, Bytes bytes);

}  // namespace patinate::fuzz
