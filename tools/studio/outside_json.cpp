#include "tools/studio/outside_json.h"

#include <nlohmann/json.hpp>

#include "libcommon/core/error.h"

namespace patinate {

Json parse_outside_json(const std::string& text) {
  constexpr int kMostLevels = 32;
  const auto check_depth = [](int depth, Json::parse_event_t, Json&) {
    if (depth > kMostLevels) throw InvalidInput("the JSON has more than 32 levels");
    return true;
  };
  try {
    return Json::parse(text, check_depth);
  } catch (const nlohmann::json::exception&) {
    throw InvalidInput("this is no JSON");
  }
}

}  // namespace patinate
