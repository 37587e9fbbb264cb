/// \file
/// How different two colours look, and colours from how they look.
#pragma once

#include <array>

namespace patinate {

/// CIEDE2000 difference of two CIELAB colours, k_L = k_C = k_H = 1 [Sharma, Wu, Dalal 2005]. >= 0, symmetric, 0 for equal colours; about 1 is
/// just noticeable side by side. Jumps where hues are opposite (their note 4).
/// @param a,b  L*, a*, b*; finite.
[[nodiscard]] double ciede2000(const std::array<double, 3>& a, const std::array<double, 3>& b);

/// Linear Rec.709 colour of a CIELAB colour under D65: the inverse of lab_from_linear(), not clamped.
[[nodiscard]] std::array<double, 3> linear_from_lab(const std::array<double, 3>& lab);

}  // namespace patinate
