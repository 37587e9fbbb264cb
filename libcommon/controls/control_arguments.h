/// \file
/// Arguments of kinds in the text of a control: `accessibility(scale=3)`, `distance(from=creases, metric=euclidean)`.
/// Each is an option of ControlKindOptions that the kind looks at, by its name or by that without the words of the
/// kind's own: `from` for `distance_from`. `axis` is `up`; a direction may be x, y, z, -x, -y or -z.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "libcommon/controls/control_expression.h"
#include "patinate/controls/control_kinds.h"

namespace patinate {

/// {option, argument} of a kind in their order: {{"distance_from", "from"}, ...}. @param kind  One of
/// control_kind_names().
[[nodiscard]] std::vector<std::pair<std::string, std::string>> control_argument_names(const std::string& kind);

/// Sets what an argument stands for. @param word  Becomes the option's name.
/// @throws ParseError that says what is wrong, without the place.
void set_control_argument(const std::string& kind, std::string& word, const std::string& value,
                          ControlKindOptions& options);

/// Options for a name of an expression: those given, and its arguments.
[[nodiscard]] ControlKindOptions named_options(const ControlName& name, const ControlKindOptions& options);

}  // namespace patinate
