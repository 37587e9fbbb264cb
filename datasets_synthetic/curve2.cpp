#include "datasets_synthetic/curve2.h"

#include <algorithm>
#include <cmath>

namespace patinate::datasets {

namespace {

// Barry and Goldman's pyramid for the piece from p1 to p2.
Vec2 catmull_rom(const Vec2& p0, const Vec2& p1, const Vec2& p2, const Vec2& p3, double f) {
  const double t1 = std::sqrt((p1 - p0).norm()), t2 = t1 + std::sqrt((p2 - p1).norm()),
               t3 = t2 + std::sqrt((p3 - p2).norm());
  const double t = t1 + f * (t2 - t1);
  const Vec2 a1 = (t1 - t) / t1 * p0 + t / t1 * p1;
  const Vec2 a2 = (t2 - t) / (t2 - t1) * p1 + (t - t1) / (t2 - t1) * p2;
  const Vec2 a3 = (t3 - t) / (t3 - t2) * p2 + (t - t2) / (t3 - t2) * p3;
  const Vec2 b1 = (t2 - t) / t2 * a1 + t / t2 * a2;
  const Vec2 b2 = (t3 - t) / (t3 - t1) * a2 + (t - t1) / (t3 - t1) * a3;
  return (t2 - t) / (t2 - t1) * b1 + (t - t1) / (t2 - t1) * b2;
}

}  // namespace

Curve2::Curve2(const std::vector<Vec2>& points) {
  const std::size_t n = points.size();
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const Vec2 before = i > 0 ? points[i - 1] : Vec2(2.0 * points[0] - points[1]);
    const Vec2 after = i + 2 < n ? points[i + 2] : Vec2(2.0 * points[n - 1] - points[n - 2]);
    for (std::size_t k = 0; k < kSteps; ++k) {
      samples_.push_back(catmull_rom(before, points[i], points[i + 1], after, static_cast<double>(k) / kSteps));
    }
  }
  samples_.push_back(points.back());
  lengths_.push_back(0.0);
  for (std::size_t i = 1; i < samples_.size(); ++i)
    lengths_.push_back(lengths_.back() + (samples_[i] - samples_[i - 1]).norm());
}

Vec2 Curve2::at(double s) const {
  const auto next = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, s);
  const std::size_t i = next - lengths_.begin();
  const double f = std::clamp((s - lengths_[i - 1]) / (lengths_[i] - lengths_[i - 1]), 0.0, 1.0);
  return (1.0 - f) * samples_[i - 1] + f * samples_[i];
}

Vec2 Curve2::tangent(double s) const {
  const double h = length() / (2.0 * static_cast<double>(samples_.size()));
  return (at(std::min(length(), s + h)) - at(std::max(0.0, s - h))).normalized();
}

}  // namespace patinate::datasets
