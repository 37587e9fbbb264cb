/// \file
/// Smooth random fields for synthetic surfaces.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace patinate::datasets {

/// Weights of the four lattice points around a place of a cubic B-spline. @param f  [0, 1), behind the second.
[[nodiscard]] std::array<double, 4> cubic_weights(double f);

/// 0 below `low`, 1 above `high`, between them once differentiable.
[[nodiscard]] double smooth_step(double low, double high, double x);

/// 0 below `low`, 1 above `high`, between them twice differentiable.
[[nodiscard]] double smoother_step(double low, double high, double x);

/// Cubic B-spline through a lattice of independent uniform values: twice differentiable, mean 0, values in [-1, 1],
/// standard deviation about 0.28. Independent of resolution where cell sizes are given in physical lengths.
class SmoothNoise {
 public:
  /// @param width, height  Extent that will be asked for, [0, width] x [0, height]; > 0.
  /// @param cell_x, cell_y  Lattice spacing; > 0.
  SmoothNoise(std::uint64_t seed, std::uint32_t purpose, double width, double height, double cell_x, double cell_y);

  /// Positions outside the extent are clamped to it.
  [[nodiscard]] double operator()(double x, double y) const;
  /// The values at x = 0, 1, 2, ... but for rounding, at a quarter of the cost of one by one.
  void row(double y, std::span<float> out) const;

 private:
  double cell_x_;
  double cell_y_;
  int columns_;
  int rows_;
  std::vector<float> values_;
};

}  // namespace patinate::datasets
