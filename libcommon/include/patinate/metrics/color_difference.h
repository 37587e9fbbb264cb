/// \file
/// How different two colors look, and colors from how they look.
#pragma once

#include <array>

namespace patinate {

/// CIEDE2000 difference of two CIELAB colors, k_L = k_C = k_H = 1 [Sharma, Wu, Dalal 2005]. >= 0, symmetric, 0 for
/// equal colors; about 1 is just noticeable side by side. Jumps where hues are opposite (their note 4).
/// @param a,b  L*, a*, b*; finite.
[[nodiscard]] double ciede2000(const std::array<double, 3>& a, const std::array<double, 3>& b);

/// Linear Rec.709 color of a CIELAB color under D65: the inverse of lab_from_linear(), not clamped.
[[nodiscard]] std::array<double, 3> linear_from_lab(const std::array<double, 3>& lab);

}  // namespace patinate
