#include "analysis/evaluation/wanted_share.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace patinate::analysis {

namespace {

constexpr int kBins = 64;

int bin_of(float value) {
  return std::clamp(static_cast<int>(std::floor(value * static_cast<float>(kBins))), 0, kBins - 1);
}

}  // namespace

std::optional<double> wanted_share(const ImageU8& feature, const ImageF& control, const ImageU8& mask,
                                   const TexelMap& surface, const ImageF& wanted) {
  std::array<double, kBins> covered{}, area{}, asked{};
  for (std::int64_t i = 0; i < feature.num_pixels(); ++i) {
    if (!mask.empty() && mask.data()[i] == 0) continue;
    const auto bin = static_cast<std::size_t>(bin_of(control.data()[i]));
    area[bin] += 1.0;
    covered[bin] += feature.data()[i] != 0 ? 1.0 : 0.0;
  }
  double num_texels = 0.0;
  for (TexelId t = 0; t < surface.num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    asked[static_cast<std::size_t>(bin_of(wanted.data()[t]))] += 1.0;
    num_texels += 1.0;
  }
  double sum = 0.0;
  for (int b = 0; b < kBins; ++b) {
    if (asked[static_cast<std::size_t>(b)] == 0.0) continue;
    int nearest = -1;
    for (int other = 0; other < kBins; ++other) {
      if (area[static_cast<std::size_t>(other)] == 0.0) continue;
      if (nearest < 0 || std::abs(other - b) < std::abs(nearest - b)) nearest = other;
    }
    if (nearest < 0) return std::nullopt;
    const auto n = static_cast<std::size_t>(nearest);
    sum += asked[static_cast<std::size_t>(b)] * covered[n] / area[n];
  }
  return num_texels > 0.0 ? std::optional(sum / num_texels) : std::nullopt;
}

}  // namespace patinate::analysis
