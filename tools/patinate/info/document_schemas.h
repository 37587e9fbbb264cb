/// \file
/// The JSON Schemas of documents that are described once (libcommon/document).
#pragma once

#include <string>
#include <vector>

#include "patinate/core/json.h"

namespace patinate::cli {

/// "history", "card", ...: as their files in docs/schema are named.
[[nodiscard]] std::vector<std::string> schema_names();
/// @throws InvalidInput unless `name` is one of schema_names().
[[nodiscard]] Json schema_of(const std::string& name);

}  // namespace patinate::cli
