/// \file
/// JSON pointers into a scene file: what they point to, and what a reader calls it.
#pragma once

#include <string>
#include <vector>

#include "patinate/core/json.h"

namespace patinate::app {

/// Value that a pointer points to; nullptr when there is none.
[[nodiscard]] Json* found_at(Json& root, const std::string& pointer);

/// Pointers to all numbers below `json` but those in `left_out`. @param pointer  Of `json` itself: "".
void collect_numbers(const Json& json, const std::string& pointer, const std::vector<std::string>& left_out,
                     std::vector<std::string>& out);

/// A did-you-mean, or the pointers that begin most like the wrong one; "" without any.
[[nodiscard]] std::string nearest_pointers(const std::string& pointer, const std::vector<std::string>& all);

/// The scene's own words for a number: "emitter rain: carries water", "rule patina: rate", "appearance of patina: color
/// red". The pointer where the scene has no name for what the number belongs to.
[[nodiscard]] std::string words_of(const Json& root, const std::string& pointer);

/// The unit of a number: "per h" of a rule's rate in a scene that counts hours, "per contact" of an exchange rate,
/// "layers" of an amount (1 is a full layer). "" for what has none, or none that is told here.
[[nodiscard]] std::string unit_of(const Json& root, const std::string& pointer);

}  // namespace patinate::app
