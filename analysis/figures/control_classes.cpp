#include "analysis/figures/control_classes.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace {

std::string range_text(const ControlFacts& c) {
  return short_number_text(c.low) + " to " + short_number_text(c.high) + (c.unit.empty() ? "" : " " + c.unit);
}

SharedControl matched(const ControlFacts& a, const ControlFacts& b) {
  SharedControl s{.name_a = a.name, .name_b = b.name, .unit = a.unit};
  if (!(a.high > a.low) || !(b.high > b.low)) {
    s.undefined = "the control is constant in " + std::string(a.high > a.low ? "B" : "A");
    return s;
  }
  const double low = std::max(a.low, b.low), high = std::min(a.high, b.high),
               shorter = std::min(a.high - a.low, b.high - b.low);
  if (a.unit != b.unit) {
    s.note = "by rank: the units differ (" + (a.unit.empty() ? "none" : a.unit) + ", " +
             (b.unit.empty() ? "none" : b.unit) + ")";
  } else if (a.unit == "relative") {
    s.note = "by rank: only ratios of the values mean something";
  } else if (high - low < 0.25 * shorter) {
    s.note = "by rank: the ranges hardly overlap (" + range_text(a) + "; " + range_text(b) + ")";
  } else {
    s.rule = ClassRule::Physical;
    s.low = low;
    s.high = high;
  }
  return s;
}

}  // namespace

std::vector<SharedControl> shared_controls(const HistoryFacts& a, const HistoryFacts& b) {
  std::vector<SharedControl> shared;
  for (const ControlFacts& ca : a.controls) {
    for (const ControlFacts& cb : b.controls) {
      if (ca.name == cb.name) shared.push_back(matched(ca, cb));
    }
  }
  if (shared.empty() && a.controls.size() == 1 && b.controls.size() == 1)
    shared.push_back(matched(a.controls[0], b.controls[0]));
  return shared;
}

std::vector<int> control_classes(const std::vector<float>& values, const ControlFacts& control,
                                 const SharedControl& shared, int num_classes) {
  std::vector<int> classes(values.size(), -1);
  if (shared.rule == ClassRule::Physical) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double x = (control.low + static_cast<double>(values[i]) * (control.high - control.low) - shared.low) /
                       (shared.high - shared.low);
      if (x >= 0.0 && x <= 1.0) classes[i] = std::min(static_cast<int>(x * num_classes), num_classes - 1);
    }
    return classes;
  }
  std::vector<float> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < values.size(); ++i) {  // Equal values share a class: the one of their middle rank.
    const auto range = std::equal_range(sorted.begin(), sorted.end(), values[i]);
    const double rank =
        (static_cast<double>(range.first - sorted.begin()) + static_cast<double>(range.second - sorted.begin())) / 2.0;
    classes[i] = std::min(static_cast<int>(rank * num_classes / static_cast<double>(values.size())), num_classes - 1);
  }
  return classes;
}

}  // namespace patinate::analysis
