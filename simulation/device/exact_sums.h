/// \file
/// Sums that kernels on a device add to.
#pragma once

#include <string_view>

namespace patinate::simulation {

/// The text of exact_sums.cl: sums of 64 bits in two words, which are exact in whatever order they are added to.
extern const std::string_view kExactSums;

}  // namespace patinate::simulation
