/// \file
/// A history as the module's functions take it.
#pragma once

#include <memory>
#include <string>

#include "patinate/history/history_sampling.h"
#include "patinate/history/history_value.h"

namespace patinate::python {

struct PyHistory {
  std::shared_ptr<const History> value;
};

/// "blend", "hold" or "nearest". @throws InvalidInput
[[nodiscard]] Between between_from(const std::string& name);

}  // namespace patinate::python
