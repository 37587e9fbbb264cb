/// \file
/// Control maps combined by formula: `0.7*accessibility + 0.3*facing`, `!spray`, `min(facing, "my maps/wet.exr")`.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/core/expression.h"
#include "patinate/controls/control_map.h"

namespace patinate {

/// A map that an expression asks for: a kind's name, or a path.
using ControlName = ExpressionName;

/// A parsed expression over control maps; libcommon/core/expression.h says what it may be.
class ControlExpression {
 public:
  /// @param known_names  What a NAME may be.
  /// A name that is a kind of control_kinds() may have arguments (control_arguments.h).
  /// @throws ParseError with the position (from 1), what was found, and a did-you-mean.
  ControlExpression(std::string_view text, std::span<const std::string> known_names);

  /// Maps that it asks for, each once, in the order of their appearance.
  [[nodiscard]] const std::vector<ControlName>& names() const { return expression_.names; }

  /// The one map that it is, unless it is a formula. It lives as long as this.
  [[nodiscard]] const ControlName* alone() const;

  /// The value at every texel, clamped to [0, 1]; 0 where `coverage` is 0. A map alone keeps its low, high and unit,
  /// `!map` too with low and high exchanged; everything else is "relative" in [0, 1]. Division by 0 gives 0 or 1, by
  /// the sign above.
  /// @param lookup  Called once for each of names().
  /// @throws InvalidInput if a map differs from `coverage` in size; what `lookup` throws.
  [[nodiscard]] ControlMap evaluate(const ImageU8& coverage,
                                    const std::function<ControlMap(const ControlName&)>& lookup) const;

 private:
  Expression expression_;
};

}  // namespace patinate
