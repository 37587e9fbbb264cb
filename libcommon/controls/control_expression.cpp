#include "libcommon/controls/control_expression.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libcommon/controls/control_arguments.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

using Node = ExpressionNode;
using Kind = Node::Kind;

/// Power of max(0, x): a map's values never are negative; 0 to a power below 0 is huge.
double power(double x, double exponent) {
  const double value = std::pow(std::max(0.0, x), exponent);
  return std::isfinite(value) ? value : kExpressionHuge;
}

/// 0 up to `from`, 1 beyond `to`, 3t^2 - 2t^3 between; a step when they are equal, falling when from > to.
double smoothstep(double from, double to, double x) {
  if (from == to) return x < from ? 0.0 : 1.0;
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

double value_of(const Node& node, const std::vector<ControlMap>& maps, std::size_t texel) {
  const auto operand = [&](std::size_t i) { return value_of(*node.operands[i], maps, texel); };
  double value = 0.0;
  switch (node.kind) {
    case Kind::Number:
      return node.number;
    case Kind::Name:
      return static_cast<double>(maps[node.name].values.values()[texel]);
    case Kind::Add:
      value = operand(0) + operand(1);
      break;
    case Kind::Subtract:
      value = operand(0) - operand(1);
      break;
    case Kind::Multiply:
      value = operand(0) * operand(1);
      break;
    case Kind::Divide: {
      const double above = operand(0), below = operand(1);
      value = below != 0.0 ? above / below : (above > 0.0 ? kExpressionHuge : above < 0.0 ? -kExpressionHuge : 0.0);
      break;
    }
    case Kind::Negate:
      return -operand(0);
    case Kind::Invert:
      value = 1.0 - operand(0);
      break;
    case Kind::Min:
    case Kind::Max:
      value = operand(0);
      for (std::size_t i = 1; i < node.operands.size(); ++i) {
        value = node.kind == Kind::Min ? std::min(value, operand(i)) : std::max(value, operand(i));
      }
      return value;
    case Kind::Abs:
      return std::abs(operand(0));
    case Kind::Pow:
      value = power(operand(0), operand(1));
      break;
    case Kind::Clamp:
      return std::max(operand(1), std::min(operand(0), operand(2)));
    case Kind::Smoothstep:
      return smoothstep(operand(0), operand(1), operand(2));
  }
  return std::clamp(value, -kExpressionHuge, kExpressionHuge);
}

void check_control_argument(const std::string& name, std::string& word, const std::string& value) {
  ControlKindOptions options;
  set_control_argument(name, word, value, options);
}

}  // namespace

ControlExpression::ControlExpression(std::string_view text, std::span<const std::string> known_names)
    : expression_(parse_expression(text, {.names = known_names, .check_argument = check_control_argument})) {}

const ControlName* ControlExpression::alone() const {
  return expression_.root->kind == Kind::Name ? &names()[expression_.root->name] : nullptr;
}

ControlMap ControlExpression::evaluate(const ImageU8& coverage,
                                       const std::function<ControlMap(const ControlName&)>& lookup) const {
  std::vector<ControlMap> maps;
  for (const ControlName& name : names()) {
    maps.push_back(lookup(name));
    const ImageF& values = maps.back().values;
    if (!values.same_size(coverage) || values.channels() != 1) {
      throw InvalidInput("control `" + name.text + "`: its map is " + std::to_string(values.width()) + " x " +
                         std::to_string(values.height()) + "; the atlas is " + std::to_string(coverage.width()) +
                         " x " + std::to_string(coverage.height()));
    }
  }
  ControlMap out{ImageF(coverage.width(), coverage.height()), 0.0, 1.0, "relative", {}};
  for (const ControlMap& map : maps) out.notes.insert(out.notes.end(), map.notes.begin(), map.notes.end());
  for (std::size_t i = 0; i < coverage.values().size(); ++i) {
    if (coverage.values()[i] == 0) continue;
    const double value = value_of(*expression_.root, maps, i);
    out.values.values()[i] = value > 0.0 ? static_cast<float>(std::min(value, 1.0)) : 0.0F;
  }
  const bool is_inverted = expression_.root->kind == Kind::Invert;
  const Node& inner = is_inverted ? *expression_.root->operands[0] : *expression_.root;
  if (inner.kind == Kind::Name) {
    const ControlMap& map = maps[inner.name];
    out.low = is_inverted ? map.high : map.low;
    out.high = is_inverted ? map.low : map.high;
    out.unit = map.unit;
  }
  return out;
}

}  // namespace patinate
