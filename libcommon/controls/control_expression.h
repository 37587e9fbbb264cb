/// \file
/// Control maps combined by formula: `0.7*accessibility + 0.3*facing`, `!spray`, `min(facing, "my maps/wet.exr")`.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/controls/control_map.h"

namespace patinate {

/// A map that an expression asks for.
struct ControlName {
  std::string text;  ///< A kind's name, or a path.
  bool is_file = false;
  friend bool operator==(const ControlName&, const ControlName&) = default;
};

/// A parsed expression over control maps.
///
///     sum     = product { ("+" | "-") product }
///     product = factor { ("*" | "/") factor }
///     factor  = ("!" | "-") factor | NUMBER | NAME | FILE | "(" sum ")" | FUNCTION "(" sum { "," sum } ")"
///
/// FUNCTION: min and max of any number; abs(x); pow(x, exponent), of max(0, x); clamp(x, least, greatest);
/// smoothstep(from, to, x): 0 up to `from`, 1 beyond `to`, smooth between, falling when from > to.
/// `!x` is 1 - x. FILE is anything in double quotes, or a word with an extension (`wet.exr`, `maps/wet-2.exr`) or that
/// begins with `/`, `./`, `../` or `~`: put blanks around `/` and `-` where they divide and subtract.
class ControlExpression {
 public:
  /// @param known_names  What a NAME may be.
  /// @throws UsageError with the position (from 1), what was found, and a did-you-mean.
  ControlExpression(std::string_view text, std::span<const std::string> known_names);
  ~ControlExpression();
  ControlExpression(ControlExpression&&) noexcept;
  ControlExpression& operator=(ControlExpression&&) noexcept;

  /// Maps that it asks for, each once, in the order of their appearance.
  [[nodiscard]] const std::vector<ControlName>& names() const { return names_; }

  /// The value at every texel, clamped to [0, 1]; 0 where `coverage` is 0. A map alone keeps its low, high and unit,
  /// `!map` too with low and high exchanged; everything else is "relative" in [0, 1]. Division by 0 gives 0 or 1, by
  /// the sign above.
  /// @param lookup  Called once for each of names().
  /// @throws InvalidInput if a map differs from `coverage` in size; what `lookup` throws.
  [[nodiscard]] ControlMap evaluate(const ImageU8& coverage,
                                    const std::function<ControlMap(const ControlName&)>& lookup) const;

  struct Node;

 private:
  std::vector<ControlName> names_;
  std::unique_ptr<Node> root_;
};

}  // namespace patinate
