/// \file
/// A length unit given on the command line.
#pragma once

#include <string>

namespace patinate::app {

/// @param unit  um, mm, cm or m. @throws UsageError
[[nodiscard]] double mm_per_unit(const std::string& unit);

}  // namespace patinate::app
