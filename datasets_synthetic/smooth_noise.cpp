#include "datasets_synthetic/smooth_noise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/random.h"

namespace patinate::datasets {

std::array<double, 4> cubic_weights(double f) {
  const double g = 1.0 - f;
  return {g * g * g / 6.0, (3.0 * f * f * f - 6.0 * f * f + 4.0) / 6.0, (3.0 * g * g * g - 6.0 * g * g + 4.0) / 6.0,
          f * f * f / 6.0};
}

double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

double smoother_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

SmoothNoise::SmoothNoise(std::uint64_t seed, std::uint32_t purpose, double width, double height, double cell_x,
                         double cell_y)
    : cell_x_(cell_x),
      cell_y_(cell_y),
      columns_(static_cast<int>(std::floor(width / cell_x)) + 5),
      rows_(static_cast<int>(std::floor(height / cell_y)) + 5) {
  values_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (std::size_t i = 0; i < values_.size(); ++i) {
    values_[i] = static_cast<float>(2.0 * RandomStream(seed, i, purpose).uniform() - 1.0);
  }
}

void SmoothNoise::row(double y, std::span<float> out) const {
  const double v = std::clamp(y / cell_y_, 0.0, static_cast<double>(rows_ - 4) - 1e-9);
  const int j = static_cast<int>(v);
  const std::array<double, 4> wy = cubic_weights(v - j);
  std::vector<double> line(static_cast<std::size_t>(columns_), 0.0);
  for (int b = 0; b < 4; ++b) {
    const float* row = &values_[static_cast<std::size_t>(j + b) * static_cast<std::size_t>(columns_)];
    for (std::size_t i = 0; i < line.size(); ++i) line[i] += wy[b] * static_cast<double>(row[i]);
  }
  for (std::size_t x = 0; x < out.size(); ++x) {
    const double u = std::min(static_cast<double>(x) / cell_x_, static_cast<double>(columns_ - 4) - 1e-9);
    const auto i = static_cast<std::size_t>(u);
    const std::array<double, 4> wx = cubic_weights(u - static_cast<double>(i));
    double sum = 0.0;
    for (std::size_t a = 0; a < 4; ++a) sum += wx[a] * line[i + a];
    out[x] = static_cast<float>(sum);
  }
}

double SmoothNoise::operator()(double x, double y) const {
  const double u = std::clamp(x / cell_x_, 0.0, static_cast<double>(columns_ - 4) - 1e-9);
  const double v = std::clamp(y / cell_y_, 0.0, static_cast<double>(rows_ - 4) - 1e-9);
  const int i = static_cast<int>(u);
  const int j = static_cast<int>(v);
  const std::array<double, 4> wx = cubic_weights(u - i);
  const std::array<double, 4> wy = cubic_weights(v - j);
  double sum = 0.0;
  for (int b = 0; b < 4; ++b) {
    const float* row =
        &values_[static_cast<std::size_t>(j + b) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(i)];
    double line = 0.0;
    for (int a = 0; a < 4; ++a) line += wx[a] * static_cast<double>(row[a]);
    sum += wy[b] * line;
  }
  return sum;
}

}  // namespace patinate::datasets
