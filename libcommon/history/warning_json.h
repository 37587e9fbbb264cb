/// \file
/// Warnings of a history as reports and manifests keep them.
#pragma once

#include <vector>

#include "patinate/core/json.h"
#include "patinate/history/history_value.h"

namespace patinate {

/// [{"about", "text", "cure", "share", "photos"}], as in history.json.
[[nodiscard]] Json warnings_json(const std::vector<HistoryWarning>& warnings);

}  // namespace patinate
