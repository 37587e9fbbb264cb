/// \file
/// A history as the module's functions take it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "patinate/history/history_sampling.h"
#include "patinate/history/history_value.h"

namespace patinate::python {

struct PyHistory {
  std::shared_ptr<const History> value;
};

/// Where it lies; empty of one in memory.
[[nodiscard]] std::filesystem::path folder_of(const PyHistory& history);

/// "blend", "hold" or "nearest". @throws InvalidInput
[[nodiscard]] Between between_from(const std::string& name);
/// "normal", "roughness", ... @throws InvalidInput listing them
[[nodiscard]] MaterialMap material_map_from(const std::string& name);

}  // namespace patinate::python
