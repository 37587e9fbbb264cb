#include "libcommon/history/material_range.h"

#include <algorithm>

#include "libcommon/core/text.h"

namespace patinate {

std::optional<std::string> find_material_problem(const std::string& name, const ImageF& values) {
  if (name != "metalness" && name != "tint") return std::nullopt;
  const auto all = values.values();
  const auto wrong = std::find_if(all.begin(), all.end(), [](float v) { return !(v >= 0.0f && v <= 1.0f); });
  if (wrong == all.end()) return std::nullopt;
  return "holds " + number_text(static_cast<double>(*wrong)) + "; a " + name + " is within [0, 1]";
}

}  // namespace patinate
