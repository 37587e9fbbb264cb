/// \file
/// The middle of some values, values by their rank, and what robust estimates make of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace patinate {

inline constexpr double kSigmaOfMad = 1.4826;  ///< Normal errors: standard deviation over median absolute deviation.
inline constexpr double kTukeyLimit =
    4.685;  ///< Limit of the biweight, in standard deviations: 95 % efficient for them.

/// The value that `rank` others come before in order; 0 = the smallest. Leaves the values in another order.
/// @param rank  Below the number of values. None is NaN.
template <class T>
[[nodiscard]] T value_at_rank(std::vector<T>& values, std::size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The middle value: of an even number the upper one of the two, of none 0. Hand over what is no longer needed.
/// @param values  None is NaN.
template <class T>
[[nodiscard]] T median(std::vector<T> values) {
  return values.empty() ? T{} : value_at_rank(values, values.size() / 2);
}

}  // namespace patinate
