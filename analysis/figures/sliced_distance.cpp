#include "analysis/figures/sliced_distance.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/random.h"

namespace patinate::analysis {

namespace {

constexpr std::uint32_t kPurpose = 0x51;

float projection(const float* lab, const std::array<double, 3>& d) {
  return static_cast<float>(static_cast<double>(lab[0]) * d[0] + static_cast<double>(lab[1]) * d[1] +
                            static_cast<double>(lab[2]) * d[2]);
}

struct Projected {
  float value;
  std::uint32_t texel;
};
std::vector<Projected> projected(const ColorStack& stack, std::size_t time, const std::array<double, 3>& axis) {
  std::vector<Projected> list;
  list.reserve(stack.num_texels());
  for (std::uint32_t i = 0; i < stack.num_texels(); ++i) list.push_back({projection(stack.lab_of(time, i), axis), i});
  std::sort(list.begin(), list.end(), [](const Projected& a, const Projected& b) {
    return a.value < b.value || (a.value == b.value && a.texel < b.texel);
  });
  return list;
}

/// Adds to each texel of `a` the mean square of how far its mass moves; equal values have their mean.
void add_square_moves(const std::vector<Projected>& a, const std::vector<Projected>& b, std::vector<double>& squares) {
  const auto mass_a = static_cast<std::int64_t>(b.size()), mass_b = static_cast<std::int64_t>(a.size());
  std::size_t j = 0;
  std::int64_t left_b = mass_b;
  for (std::size_t first = 0, last = 0; first < a.size(); first = last) {
    double sum = 0.0;
    for (last = first; last < a.size() && a[last].value == a[first].value; ++last) {
      for (std::int64_t left = mass_a; left > 0;) {
        const std::int64_t mass = std::min(left, left_b);
        const double d = static_cast<double>(a[last].value) - static_cast<double>(b[j].value);
        sum += static_cast<double>(mass) * d * d;
        left -= mass;
        left_b -= mass;
        if (left_b == 0 && ++j < b.size()) left_b = mass_b;
      }
    }
    const double mean = sum / (static_cast<double>(mass_a) * static_cast<double>(last - first));
    for (std::size_t i = first; i < last; ++i) squares[a[i].texel] += mean;
  }
}

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
    for (std::size_t axis = 0; axis < sorted_.size(); ++axis)
      sorted_[axis].push_back({projection(lab, sliced_axes()[axis]), block_of[texels[at]]});
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

std::vector<float> sliced_moves(const ColorStack& a, std::size_t time_a, const ColorStack& b, std::size_t time_b) {
  std::vector<double> squares(a.num_texels(), 0.0);
  for (const auto& axis : sliced_axes())
    add_square_moves(projected(a, time_a, axis), projected(b, time_b, axis), squares);
  std::vector<float> moves;
  moves.reserve(squares.size());
  for (const double s : squares)
    moves.push_back(static_cast<float>(std::sqrt(3.0 * s / static_cast<double>(sliced_axes().size()))));
  return moves;
}

}  // namespace patinate::analysis
