#include "analysis/explanation/surface_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "libcommon/core/parallel.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kMaxPlaces = 2000;  ///< Whose pairs are looked at.
constexpr double kForgotten = 0.1;        ///< Correlation of places that no longer know of each other.
constexpr std::uint64_t kMinPairs = 200;  ///< Least pairs of a step; steps with fewer are not looked at.

using Steps = std::array<double, kNumDistanceSteps>;

/// Every so many-th of a list, with mean 0 and variance 1.
std::vector<double> standardized(const std::vector<double>& values, std::size_t step) {
  std::vector<double> chosen;
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < values.size(); i += step) {
    chosen.push_back(values[i]);
    sum += values[i], squares += values[i] * values[i];
  }
  const auto n = static_cast<double>(chosen.size());
  const double variance = squares / n - (sum / n) * (sum / n);
  for (double& v : chosen) v = variance > 0.0 ? (v - sum / n) / std::sqrt(variance) : 0.0;
  return chosen;
}

/// Sums over pairs.
struct PairSums {
  std::array<std::uint64_t, kNumDistanceSteps> count{};
  std::vector<Steps> products;
};

double greatest_distance_mm(std::span<const Vec3> positions_mm) {
  Vec3 low = positions_mm.front(), high = low;
  for (const Vec3& p : positions_mm) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return (high - low).norm();
}

}  // namespace

BlockGrid SurfaceBlocks::grid(std::size_t num_samples) const {
  BlockGrid grid{.columns = static_cast<int>(members.size()), .rows = 1};
  grid.block_of.resize(num_samples);
  for (std::size_t b = 0; b < members.size(); ++b) {
    grid.used.push_back(static_cast<std::uint16_t>(b));
    for (const std::uint32_t i : members[b]) grid.block_of[i] = static_cast<std::uint16_t>(b);
  }
  return grid;
}

SurfaceBlocks make_surface_blocks(std::span<const Vec3> positions_mm, int count, double area_mm2) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : positions_mm) middle += p / static_cast<double>(positions_mm.size());
  std::vector<double> distance(positions_mm.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> block(positions_mm.size(), 0);
  std::size_t center = 0;  // The first: what is farthest from the middle.
  for (std::size_t i = 0; i < positions_mm.size(); ++i) {
    if ((positions_mm[i] - middle).squaredNorm() > (positions_mm[center] - middle).squaredNorm()) center = i;
  }
  SurfaceBlocks blocks;
  for (int b = 0; b < count; ++b) {
    std::size_t farthest = 0;
    for (std::size_t i = 0; i < positions_mm.size(); ++i) {
      const double d = (positions_mm[i] - positions_mm[center]).squaredNorm();
      if (d < distance[i]) distance[i] = d, block[i] = static_cast<std::size_t>(b);
      if (distance[i] > distance[farthest]) farthest = i;
    }
    center = farthest;
  }
  blocks.members.resize(count);
  for (std::size_t i = 0; i < block.size(); ++i) blocks.members[block[i]].push_back(static_cast<std::uint32_t>(i));
  std::erase_if(blocks.members, [](const auto& list) { return list.empty(); });
  blocks.edge_mm = std::sqrt(area_mm2 / static_cast<double>(blocks.members.size()));
  return blocks;
}

int suited_block_count(double range_mm, double area_mm2) {
  const double edge = kRangesInBlock * range_mm;
  const double count = edge > 0.0 ? area_mm2 / (edge * edge) : kMaxBlocks;
  return static_cast<int>(std::clamp(count, double{kMinBlocks}, double{kMaxBlocks}));
}

double Correlograms::range_mm(std::size_t list) const {
  for (std::size_t k = 0; k < kNumDistanceSteps / 2; ++k) {
    if (num_pairs[k] >= kMinPairs && mean[list][k] < kForgotten) return (static_cast<double>(k) + 0.5) * step_mm;
  }
  return 0.5 * static_cast<double>(kNumDistanceSteps) * step_mm;
}

double Correlograms::chance_variance(std::size_t a, std::size_t b, std::size_t num_samples) const {
  double sum = 0.0, pairs = 0.0;
  for (std::size_t k = 0; k < kNumDistanceSteps; ++k) {
    const auto count = static_cast<double>(num_pairs[k]);
    sum += count * mean[a][k] * mean[b][k];
    pairs += count;
  }
  return std::max(0.0, pairs > 0.0 ? sum / pairs : 0.0) + 1.0 / static_cast<double>(num_samples);
}

Correlograms correlograms(std::span<const Vec3> positions_mm, const std::vector<std::vector<double>>& lists,
                          const RunControl& control) {
  const std::size_t step = std::max<std::size_t>(1, (positions_mm.size() + kMaxPlaces - 1) / kMaxPlaces);
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < positions_mm.size(); i += step) places.push_back(positions_mm[i]);
  std::vector<std::vector<double>> values;
  for (const auto& list : lists) values.push_back(standardized(list, step));
  const double longest = greatest_distance_mm(places);
  const double per_mm = longest > 0.0 ? static_cast<double>(kNumDistanceSteps) / longest : 0.0;
  const auto pairs_of = [&](std::int64_t begin, std::int64_t end) {
    PairSums part{.count = {}, .products = std::vector<Steps>(lists.size())};
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      for (std::size_t j = i + 1; j < places.size(); ++j) {
        const double d = (places[i] - places[j]).norm();
        const std::size_t k = std::min(kNumDistanceSteps - 1, static_cast<std::size_t>(d * per_mm));
        ++part.count[k];
        for (std::size_t l = 0; l < values.size(); ++l) part.products[l][k] += values[l][i] * values[l][j];
      }
    }
    return part;
  };
  const auto together = [](PairSums a, const PairSums& b) {
    for (std::size_t k = 0; k < kNumDistanceSteps; ++k) {
      a.count[k] += b.count[k];
      for (std::size_t l = 0; l < a.products.size(); ++l) a.products[l][k] += b.products[l][k];
    }
    return a;
  };
  const PairSums all =
      parallel_reduce(static_cast<std::int64_t>(places.size()), 50, control,
                      PairSums{.count = {}, .products = std::vector<Steps>(lists.size())}, pairs_of, together);
  Correlograms out{.step_mm = longest / static_cast<double>(kNumDistanceSteps),
                   .num_pairs = all.count,
                   .mean = all.products,
                   .num_places = places.size()};
  for (Steps& list : out.mean) {
    for (std::size_t k = 0; k < kNumDistanceSteps; ++k)
      list[k] = all.count[k] > 0 ? list[k] / static_cast<double>(all.count[k]) : 0.0;
  }
  return out;
}

}  // namespace patinate::analysis
