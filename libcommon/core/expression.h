/// \file
/// Formulas over named values: what control maps and the drivers of rules are written in.
///
///     sum     = product { ("+" | "-") product }
///     product = factor { ("*" | "/") factor }
///     factor  = ("!" | "-") factor | NUMBER | NAME [ARGUMENTS] | FILE | "(" sum ")" | FUNCTION "(" sum { "," sum } ")"
///     ARGUMENTS = "(" WORD "=" VALUE { "," WORD "=" VALUE } ")"
///
/// FUNCTION: min and max of any number; abs(x); pow(x, exponent), of max(0, x); clamp(x, least, greatest);
/// smoothstep(from, to, x): 0 up to `from`, 1 beyond `to`, smooth between, falling when from > to. `!x` is 1 - x. A
/// NAME is letters, digits and _; where there are no files, it may have parts with a point between: `below.metal`.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace patinate {

/// Values of expressions are kept within +-kExpressionHuge, so that none becomes infinite or NaN.
inline constexpr double kExpressionHuge = 1e30;

/// Name that an expression asks for.
struct ExpressionName {
  std::string text;  ///< A name, or a path.
  bool is_file = false;
  /// Arguments of a name: {{"scale", "3"}}, by the names that check_argument gives them.
  std::vector<std::pair<std::string, std::string>> arguments = {};
  friend bool operator==(const ExpressionName&, const ExpressionName&) = default;
};

struct ExpressionNode {
  enum class Kind {
    Number,
    Name,
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    Invert,
    Min,
    Max,
    Abs,
    Pow,
    Clamp,
    Smoothstep
  };
  Kind kind = Kind::Number;
  double number = 0.0;
  std::size_t name = 0;  ///< Into Expression::names.
  std::vector<std::unique_ptr<ExpressionNode>> operands;
};

struct Expression {
  std::vector<ExpressionName> names;  ///< Each once, in the order of their appearance.
  std::unique_ptr<ExpressionNode> root;
};

/// Syntax of an expression, and the words of messages about it.
struct ExpressionSyntax {
  std::string subject = "control";     ///< "control `0.5*acess`: position 5: ...".
  std::string name = "control";        ///< "unknown control `acess`".
  std::span<const std::string> names;  ///< Permitted names.
  /// Whether FILE is allowed: anything in double quotes, or a word with an extension (`wet.exr`, `maps/wet-2.exr`) or
  /// that begins with
  /// `/`, `./`, `../` or `~`: blanks around `/` and `-` then say that they divide and subtract.
  bool has_files = true;
  /// Looks at an argument of a name, and may give its word another spelling; empty: names have none. A VALUE stands in
  /// double quotes, or ends before `)` or before `, WORD=`. @throws ParseError saying what is wrong with it.
  std::function<void(const std::string& name, std::string& word, const std::string& value)> check_argument = {};
};

/// @throws ParseError with the position (from 1), what was found, and a did-you-mean.
[[nodiscard]] Expression parse_expression(std::string_view text, const ExpressionSyntax& syntax);

}  // namespace patinate
