#include "analysis/evaluation/wanted_share.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace patinate::analysis {

namespace {

constexpr int kBins = static_cast<int>(WantedCounts{}.size());

std::size_t bin_of(float value) {
  const auto bin = static_cast<int>(std::floor(value * static_cast<float>(kBins)));
  return static_cast<std::size_t>(std::clamp(bin, 0, kBins - 1));
}

}  // namespace

WantedCounts count_wanted(const MapPart& part) {
  WantedCounts counts{};
  part.for_each_covered([&](TexelId, std::int64_t i) { ++counts[bin_of(part.control.data()[i])]; });
  return counts;
}

std::optional<double> wanted_share(const ImageU8& feature, const ImageF& control, const ImageU8& mask,
                                   const WantedCounts& wanted) {
  std::array<double, kBins> covered{}, area{};
  for (std::int64_t i = 0; i < feature.num_pixels(); ++i) {
    if (!mask.empty() && mask.data()[i] == 0) continue;
    const std::size_t bin = bin_of(control.data()[i]);
    area[bin] += 1.0;
    covered[bin] += feature.data()[i] != 0 ? 1.0 : 0.0;
  }
  double num_texels = 0.0, sum = 0.0;
  for (int b = 0; b < kBins; ++b) {
    const auto asked = static_cast<double>(wanted[b]);
    if (asked == 0.0) continue;
    num_texels += asked;
    int nearest = -1;
    for (int other = 0; other < kBins; ++other) {
      if (area[other] == 0.0) continue;
      if (nearest < 0 || std::abs(other - b) < std::abs(nearest - b)) nearest = other;
    }
    if (nearest < 0) return std::nullopt;
    const auto n = static_cast<std::size_t>(nearest);
    sum += asked * covered[n] / area[n];
  }
  return num_texels > 0.0 ? std::optional(sum / num_texels) : std::nullopt;
}

}  // namespace patinate::analysis
