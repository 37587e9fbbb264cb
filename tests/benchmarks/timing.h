/// \file
/// Wall-clock medians for benchmarks.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>

namespace patinate::benchmarks {

[[nodiscard]] inline double seconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

[[nodiscard]] inline double median_of_five(const std::function<void()>& work) {
  std::array<double, 5> times{};
  for (double& t : times) t = seconds(work);
  std::sort(times.begin(), times.end());
  return times[2];
}

}  // namespace patinate::benchmarks
