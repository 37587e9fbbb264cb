/// \file
/// What must hold of every scan that a reader gives.
#pragma once

#include <string>

#include "tests/fuzz/fuzz_target.h"

namespace patinate::fuzz {

/// Reads the bytes as a scan under this name and aborts where its arrays do not fit together; makes a mesh of it too.
void read_and_check_cloud(const std::string& name, Bytes bytes);

}  // namespace patinate::fuzz
