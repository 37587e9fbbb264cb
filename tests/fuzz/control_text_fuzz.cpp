#include <cmath>
#include <string>
#include <vector>

#include "libcommon/controls/control_expression.h"
#include "libcommon/core/text.h"
#include "patinate/transfer/control_matching.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

namespace {

void evaluate(const std::string& text) {
  static const std::vector<std::string> names{"accessibility", "facing"};
  const ControlExpression expression(text, names);
  ImageU8 coverage(3, 1);
  coverage.at(0, 0) = coverage.at(1, 0) = 255;
  const ControlMap map = expression.evaluate(coverage, [](const ControlName&) {
    ControlMap m;
    m.values = ImageF(3, 1);
    m.values.at(0, 0) = 0.25f;
    m.values.at(1, 0) = 1.0f;
    return m;
  });
  for (int x = 0; x < 3; ++x)
    fuzz::require(map.values.at(x, 0) >= 0.0f && map.values.at(x, 0) <= 1.0f, "values lie in [0, 1]");
}

}  // namespace

PATINATE_FUZZ_TARGET(control_text) {
  const std::string text(fuzz::text_of(bytes));
  if (const auto number = parse_number(text)) fuzz::require(std::isfinite(*number), "numbers are finite");
  std::string destination = text;
  try {
    const transfer::ControlSpec spec = transfer::parse_control_spec(text);
    fuzz::require(spec.weight > 0.0, "weights are positive");
    destination = spec.destination;
  } catch (const Error&) {
    // No spec; it may still be an expression.
  }
  evaluate(destination);
}
