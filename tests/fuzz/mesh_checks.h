/// \file
/// What every mesh that was read must keep to.
#pragma once

#include <string>

#include "tests/fuzz/fuzz_target.h"

namespace patinate::fuzz {

/// Reads the bytes as a file of this name; the mesh must be sound, and survive being written as OBJ and read again.
void read_and_check_mesh(const std::string& name, Bytes bytes);

}  // namespace patinate::fuzz
