#include "tests/simulation/tracing/landing_counts.h"

#include <Eigen/Geometry>
#include <cmath>

namespace patinate::testing_support {

namespace {
constexpr double kUpper = 0.5;  // cosine: flow enters at more than 30 degrees from the edge
constexpr int kSamples = 200;   // along a side, for the zones' areas
}  // namespace

LandingCounts::LandingCounts(const Mesh& mesh, double band_mm, bool is_front, const Vec3& down) : band_(band_mm) {
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    Item item;
    const Vec3 across = area_vector(mesh, t);
    const double area = across.norm();
    const Vec3 normal = (is_front ? 1.0 : -1.0) / area * across;
    const Vec3 flow = (down - down.dot(normal) * normal).normalized();
    double perimeter = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Triangle& c = mesh.triangles[t];
      const auto p = [&](std::size_t i) { return mesh.positions[c[i % 3]]; };
      const Vec3 edge = p(k + 2) - p(k + 1);
      item.height[k] = area / edge.norm();
      perimeter += edge.norm();
      const Vec3 inward = (p(k) - p(k + 1) - (p(k) - p(k + 1)).dot(edge) / edge.squaredNorm() * edge).normalized();
      item.is_upper[k] = inward.dot(flow) > kUpper;
    }
    item.counts = area / perimeter > 2.5 * band_;  // of the inscribed circle
    items_.push_back(item);
    if (!item.counts) continue;
    int count = 0;
    for (int i = 0; i < kSamples; ++i) {
      for (int j = 0; i + j < kSamples; ++j, ++count)
        items_.back().share[static_cast<std::size_t>(zone_of(t, (i + 1.0 / 3) / kSamples, (j + 1.0 / 3) / kSamples))] +=
            1.0;
    }
    for (double& s : items_.back().share) s /= count;
  }
}

Zone LandingCounts::zone_of(int triangle, double b1, double b2) const {
  const Item& item = items_[triangle];
  const std::array<double, 3> distance{(1.0 - b1 - b2) * item.height[0], b1 * item.height[1], b2 * item.height[2]};
  std::size_t nearest = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (distance[k] < distance[nearest]) nearest = k;
  }
  if (distance[nearest] > 2.0 * band_) return Zone::Middle;
  if (distance[nearest] > band_) return Zone::Between;
  return item.is_upper[nearest] ? Zone::Below : Zone::Beside;
}

void LandingCounts::add(int triangle, double b1, double b2) {
  Item& item = items_[triangle];
  if (item.counts) ++item.hits[static_cast<std::size_t>(zone_of(triangle, b1, b2))];
}

LandingCounts::Ratio LandingCounts::over_middle(Zone zone, const std::vector<bool>& is_wanted) const {
  const auto z = static_cast<std::size_t>(zone), m = static_cast<std::size_t>(Zone::Middle);
  double hits = 0.0, hits_in_middle = 0.0, expected = 0.0, expected_in_middle = 0.0;
  for (std::size_t t = 0; t < items_.size(); ++t) {
    const Item& item = items_[t];
    if (!item.counts || (!is_wanted.empty() && !is_wanted[t])) continue;
    double all = 0.0;
    for (const std::int64_t n : item.hits) all += static_cast<double>(n);
    hits += static_cast<double>(item.hits[z]);
    hits_in_middle += static_cast<double>(item.hits[m]);
    expected += all * item.share[z];
    expected_in_middle += all * item.share[m];
  }
  if (!(expected > 0.0 && hits_in_middle > 0.0)) return {};
  const double value = hits / expected / (hits_in_middle / expected_in_middle);
  return {.value = value, .deviation = value * std::sqrt(1.0 / expected + 1.0 / hits_in_middle), .expected = expected};
}

}  // namespace patinate::testing_support
