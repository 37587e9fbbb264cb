#include "libcommon/history/material_range.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"

namespace patinate {

namespace {

/// A mean of normals is shorter than they are; none is longer than 1 but for rounding.
constexpr float kMinNormal = 0.5f, kLargestNormal = 1.05f;

std::string holds(float value, const std::string& rule) {
  return "holds " + number_text(static_cast<double>(value)) + "; " + rule;
}

std::optional<std::string> find_normal_problem(const ImageF& values) {
  bool is_any_known = false;
  const auto all = values.values();
  for (std::size_t i = 0; i + 2 < all.size(); i += 3) {
    const float length = std::sqrt(all[i] * all[i] + all[i + 1] * all[i + 1] + all[i + 2] * all[i + 2]);
    if (length == 0.0f) continue;
    is_any_known = true;
    if (!(length >= kMinNormal && length <= kLargestNormal))
      return "holds a normal of length " + short_number_text(static_cast<double>(length)) +
             "; normals have length 1, or 0 where none is known";
  }
  if (is_any_known) return std::nullopt;
  return "all normals have length 0, so that none is known; leave the map out";
}

}  // namespace

std::optional<std::string> find_material_problem(const std::string& name, const ImageF& values) {
  if (name == "normal") return find_normal_problem(values);
  const auto all = values.values();
  if (name == "specular") {
    for (std::size_t i = 0; i + 1 < all.size(); i += 2) {
      if (!(all[i] >= 0.0f)) return holds(all[i], "a strength of the highlight is not below 0");
      if (!(all[i + 1] >= 0.0f && all[i + 1] <= 1.0f)) return holds(all[i + 1], "a roughness is within [0, 1]");
    }
    return std::nullopt;
  }
  if (name != "metalness" && name != "tint") return std::nullopt;
  const auto wrong = std::find_if(all.begin(), all.end(), [](float v) { return !(v >= 0.0f && v <= 1.0f); });
  if (wrong == all.end()) return std::nullopt;
  return holds(*wrong, "a " + name + " is within [0, 1]");
}

}  // namespace patinate
