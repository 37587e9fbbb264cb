#include "libcommon/core/latin_hypercube.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "libcommon/core/random.h"

namespace patinate {

namespace {

constexpr std::uint32_t kOrder = 0x57d1, kPlace = 0x57d2, kTry = 0x57d3;  // Purposes of random streams.

using Points = std::vector<std::vector<double>>;

/// Squared distance of the nearest two.
double least_distance(const Points& points) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      double sum = 0.0;
      for (std::size_t f = 0; f < points[i].size(); ++f)
        sum += (points[i][f] - points[j][f]) * (points[i][f] - points[j][f]);
      least = std::min(least, sum);
    }
  }
  return least;
}

}  // namespace

Points latin_hypercube(std::size_t num_samples, std::size_t num_factors, std::uint64_t seed) {
  Points points(num_samples, std::vector<double>(num_factors));
  for (std::size_t f = 0; f < num_factors; ++f) {
    std::vector<std::size_t> slices(num_samples);
    std::iota(slices.begin(), slices.end(), std::size_t{0});
    RandomStream order(seed, f, kOrder), place(seed, f, kPlace);
    for (std::size_t i = num_samples; i > 1; --i)
      std::swap(slices[i - 1], slices[order.below(static_cast<std::uint32_t>(i))]);
    for (std::size_t i = 0; i < num_samples; ++i)
      points[i][f] = (static_cast<double>(slices[i]) + place.uniform()) / static_cast<double>(num_samples);
  }
  return points;
}

Points spread_latin_hypercube(std::size_t num_samples, std::size_t num_factors, std::uint64_t seed, int num_tries) {
  Points best;
  double farthest = -1.0;
  RandomStream seeds(seed, 0, kTry);
  for (int k = 0; k < num_tries; ++k) {
    Points points = latin_hypercube(num_samples, num_factors, seeds.next_u32());
    const double distance = least_distance(points);
    if (!(distance > farthest)) continue;
    farthest = distance;
    best = std::move(points);
  }
  return best;
}

}  // namespace patinate
