#include "capture/unlighting/color_clusters.h"

#include <algorithm>
#include <utility>

namespace patinate::capture {

ColorClusters color_clusters(const std::vector<Vec3>& colors, std::size_t max_count) {
  const std::size_t n = colors.size();
  std::vector<Vec3> centers{colors[n / 2]};
  std::vector<std::size_t> of(n, 0);
  const auto nearest = [&](const Vec3& color) {
    std::size_t best = 0;
    for (std::size_t k = 1; k < centers.size(); ++k)
      if ((color - centers[k]).squaredNorm() < (color - centers[best]).squaredNorm()) best = k;
    return best;
  };
  const auto settle = [&] {
    for (int round = 0; round < 10; ++round) {
      std::vector<Vec3> sums(centers.size(), Vec3::Zero());
      std::vector<double> counts(centers.size(), 0.0);
      for (std::size_t i = 0; i < n; ++i) {
        of[i] = nearest(colors[i]);
        sums[of[i]] += colors[i];
        counts[of[i]] += 1.0;
      }
      for (std::size_t k = 0; k < centers.size(); ++k)
        if (counts[k] > 0.0) centers[k] = sums[k] / counts[k];
    }
  };
  settle();
  while (centers.size() < max_count) {
    // The color at the 98th percentile of distance: the farthest may be an outlier.
    std::vector<std::pair<double, std::size_t>> distances;
    for (std::size_t i = 0; i < n; ++i) distances.emplace_back((colors[i] - centers[of[i]]).norm(), i);
    const auto rank = distances.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(n - 1));
    std::nth_element(distances.begin(), rank, distances.end());
    if (rank->first < 2.0 * kMinColorSpread) break;
    centers.push_back(colors[rank->second]);
    settle();
  }
  return {std::move(centers), std::move(of)};
}

}  // namespace patinate::capture
