/// \file
/// Texels by a control: how color and rate of change depend on it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "patinate/analysis/texture_series.h"

namespace patinate::analysis {

/// How classes of two sides are made to correspond.
enum class ClassRule {
  Physical,  ///< Equal steps of the physical value, over what both sides have of it.
  Rank,      ///< Equal shares of the texels: the values are not comparable.
};

/// A control that both sides have.
struct SharedControl {
  std::string name_a = {};
  std::string name_b = {};
  ClassRule rule = ClassRule::Rank;
  double low = 0.0;  ///< Physical; of Physical rule only.
  double high = 1.0;
  std::string unit = {};
  std::string note = {};       ///< Why by rank; "" for Physical.
  std::string undefined = {};  ///< Why they cannot be compared at all; "" = they can.
};
/// Controls of equal name; if there is none and each side has just one, those two.
[[nodiscard]] std::vector<SharedControl> shared_controls(const HistoryFacts& a, const HistoryFacts& b);

/// The class of every texel, -1 = none (outside the common range).
/// @param values  In [0, 1], normalized by [low, high]. @param num_classes  >= 1.
[[nodiscard]] std::vector<int> control_classes(const std::vector<float>& values, const ControlFacts& control,
                                               const SharedControl& shared, int num_classes);

}  // namespace patinate::analysis
