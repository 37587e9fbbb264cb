/// \file
/// Color stacks made of formulas.
#pragma once

#include <array>
#include <functional>

#include "analysis/figures/color_stack.h"

namespace patinate::testing_support {

/// Every pixel a texel; `lab(x, y, t)` at times 0, 1 / (T - 1), ..., 1 times `span`.
[[nodiscard]] inline analysis::ColorStack make_stack(
    int width, int height, int num_times, double span,
    const std::function<std::array<double, 3>(int x, int y, double time)>& lab) {
  analysis::ColorStack stack;
  stack.width = width;
  stack.height = height;
  for (int i = 0; i < width * height; ++i) stack.texels.push_back(static_cast<std::uint32_t>(i));
  for (int t = 0; t < num_times; ++t) {
    stack.times.push_back(num_times == 1 ? 0.0 : span * t / (num_times - 1));
    for (int i = 0; i < width * height; ++i) {
      for (double v : lab(i % width, i / width, stack.times.back())) stack.lab.push_back(static_cast<float>(v));
    }
  }
  stack.rgb = stack.lab;
  return stack;
}

}  // namespace patinate::testing_support
