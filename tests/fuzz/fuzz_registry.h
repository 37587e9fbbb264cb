/// \file
/// The targets that are linked into this program.
#pragma once

#include <map>
#include <string>

#include "tests/fuzz/fuzz_target.h"

namespace patinate::fuzz {

[[nodiscard]] std::map<std::string, Target>& registry();

}  // namespace patinate::fuzz
