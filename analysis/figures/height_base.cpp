#include "analysis/figures/height_base.h"

#include <algorithm>

#include "libcommon/geometry/dense_solve.h"

namespace patinate::analysis {

HeightBase height_base_of(const TextureSeries& series) {
  return series.facts().origin == "captured" && series.coordinates().empty() ? HeightBase::Plane : HeightBase::Mean;
}

TakenBase take_base(std::vector<float>& height, const ColorStack& stack, HeightBase kind) {
  TakenBase taken{.kind = kind};
  const std::size_t n = stack.num_texels();
  if (height.empty() || n == 0) return taken;
  const auto place = [&](std::size_t i) {
    const auto width = static_cast<std::uint32_t>(stack.width);
    return Eigen::Vector2d(stack.texels[i] % width, stack.texels[i] / width);
  };
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    middle += place(i) / static_cast<double>(n);
    taken.mean_mm += static_cast<double>(height[i]) / static_cast<double>(n);
  }
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  if (kind == HeightBase::Plane) {
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    Eigen::Vector2d with_height = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector2d d = place(i) - middle;
      spread += d * d.transpose();
      with_height += d * (static_cast<double>(height[i]) - taken.mean_mm);
    }
    // A row of texels has no slope across it.
    slope = shortest_least_squares(Eigen::MatrixXd(spread), Eigen::VectorXd(with_height));
  }
  double low = 0.0, high = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double above = slope.dot(place(i) - middle);
    low = std::min(low, above);
    high = std::max(high, above);
    for (std::size_t at = i; at < height.size(); at += n)
      height[at] = static_cast<float>(static_cast<double>(height[at]) - taken.mean_mm - above);
  }
  taken.tilt_mm = high - low;
  return taken;
}

}  // namespace patinate::analysis
