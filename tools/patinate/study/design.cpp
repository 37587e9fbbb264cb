#include "tools/patinate/study/design.h"

#include <numeric>
#include <utility>

#include "libcommon/core/random.h"

namespace patinate::cli {

namespace {

constexpr std::uint32_t kOrder = 0x57d1, kPlace = 0x57d2;  // Purposes of random streams.

}  // namespace

std::vector<std::vector<std::size_t>> grid_design(const std::vector<std::size_t>& num_levels) {
  std::vector<std::vector<std::size_t>> points{{}};
  for (const std::size_t count : num_levels) {
    std::vector<std::vector<std::size_t>> longer;
    for (const auto& point : points) {
      for (std::size_t level = 0; level < count; ++level) {
        longer.push_back(point);
        longer.back().push_back(level);
      }
    }
    points = std::move(longer);
  }
  return points;
}

std::vector<std::vector<double>> latin_hypercube(std::size_t num_samples, std::size_t num_factors, std::uint64_t seed) {
  std::vector<std::vector<double>> points(num_samples, std::vector<double>(num_factors));
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

}  // namespace patinate::cli
