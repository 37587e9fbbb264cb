/// \file
/// For C++: place_kernel.inl; devices read the same text.
#pragma once

#include "libcommon/core/kernel_language.h"

namespace patinate::simulation::place_types {
using namespace kernel_types;
#include "simulation/atlas/place_kernel.inl"
}  // namespace patinate::simulation::place_types
