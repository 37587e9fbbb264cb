#include "analysis/figures/sliced_distance.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/random.h"

namespace patinate::analysis {

namespace {

constexpr std::uint32_t kPurpose = 0x51;

}  // namespace

const std::array<std::array<double, 3>, 15>& sliced_axes() {
  static const std::array<std::array<double, 3>, 15> kAxes = [] {
    std::array<std::array<double, 3>, 15> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const double phi = (1.0 + std::sqrt(5.0)) / 2.0;
    const std::array<double, 3> v{phi / 2.0, 0.5, 1.0 / (2.0 * phi)};
    std::size_t n = 3;
    for (std::size_t turn = 0; turn < 3; ++turn) {
      for (int signs = 0; signs < 4; ++signs) {
        std::array<double, 3> a{v[turn % 3], v[(turn + 1) % 3], v[(turn + 2) % 3]};
        if (signs & 1) a[1] = -a[1];
        if (signs & 2) a[2] = -a[2];
        axes[n++] = a;
      }
    }
    return axes;
  }();
  return kAxes;
}

SortedColors::SortedColors(const ColorStack& stack, std::size_t time, std::span<const std::uint32_t> texels,
                           std::span<const std::uint16_t> block_of, std::size_t most, std::uint64_t seed) {
  const std::size_t n = std::min(texels.size(), most);
  for (auto& list : sorted_) list.reserve(n);
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t at = k;
    if (n < texels.size()) {
      const double u = RandomStream(seed, k, kPurpose).uniform();
      at = std::min(static_cast<std::size_t>((static_cast<double>(k) + u) * static_cast<double>(texels.size()) /
                                             static_cast<double>(n)),
                    texels.size() - 1);
    }
    const float* lab = stack.lab_of(time, texels[at]);
    for (std::size_t axis = 0; axis < sorted_.size(); ++axis) {
      const auto& d = sliced_axes()[axis];
      const double p =
          static_cast<double>(lab[0]) * d[0] + static_cast<double>(lab[1]) * d[1] + static_cast<double>(lab[2]) * d[2];
      sorted_[axis].push_back({static_cast<float>(p), block_of[texels[at]]});
    }
  }
  for (auto& list : sorted_) sort_values(list);
}

std::optional<double> sliced_distance(const SortedColors& a, std::span<const int> weights_a, const SortedColors& b,
                                      std::span<const int> weights_b) {
  double sum = 0.0;
  for (std::size_t axis = 0; axis < sliced_axes().size(); ++axis) {
    const std::optional<double> d = quantile_distance(a.along(axis), weights_a, b.along(axis), weights_b, 2);
    if (!d) return std::nullopt;
    sum += *d;
  }
  return std::sqrt(3.0 * sum / static_cast<double>(sliced_axes().size()));
}

}  // namespace patinate::analysis
