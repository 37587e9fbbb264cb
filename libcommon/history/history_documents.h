/// \file
/// What files of histories say, as JSON.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "libcommon/document/document.h"
#include "patinate/core/json.h"
#include "patinate/history/history_value.h"

namespace patinate {

inline constexpr std::array<std::string_view, 5> kTimeUnitNames{"s", "min", "h", "d", "a"};

void describe(DocumentVisitor& v, HistoryWarning& warning);
/// [{"about", "text", "cure", "share", "photos"}], as in history.json.
[[nodiscard]] Json warnings_json(const std::vector<HistoryWarning>& warnings);

/// The JSON Schemas of history.json and card.json.
[[nodiscard]] Json history_schema();
[[nodiscard]] Json history_card_schema();

}  // namespace patinate
