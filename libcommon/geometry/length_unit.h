/// \file
/// Length units of files. Inside, lengths are mm.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace patinate {

/// In the order of kMmPerLengthUnit.
inline constexpr std::array<std::string_view, 4> kLengthUnitNames{"um", "mm", "cm", "m"};
inline constexpr std::array<double, 4> kMmPerLengthUnit{0.001, 1.0, 10.0, 1000.0};

/// Lengths that one pixel of a surface may have: from less than an atom to a country. Beyond, sizes in pixels and their
/// squares are no numbers.
inline constexpr double kMinTexel_mm = 1e-9, kLargestTexel_mm = 1e9;

/// Nothing for a name that is none of kLengthUnitNames.
[[nodiscard]] constexpr std::optional<double> find_mm_per_unit(std::string_view name) {
  for (std::size_t i = 0; i < kLengthUnitNames.size(); ++i) {
    if (kLengthUnitNames[i] == name) return kMmPerLengthUnit[i];
  }
  return std::nullopt;
}

}  // namespace patinate
