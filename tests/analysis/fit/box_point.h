/// \file
/// Points of the box in which a search looks.
#pragma once

#include <vector>

namespace patinate::testing_support {

using BoxPoint = std::vector<double>;

}  // namespace patinate::testing_support
