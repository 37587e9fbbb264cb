#include "libcommon/metrics/color_curves.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libcommon/core/median.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

ChannelSummary summarize(std::vector<double> values) {
  ChannelSummary s;
  double sum = 0.0;
  for (double v : values) sum += v;
  s.mean = sum / static_cast<double>(values.size());
  const auto percentile = [&](double share) {
    const double rank = std::ceil(share * static_cast<double>(values.size()));
    return value_at_rank(values, static_cast<std::size_t>(std::max(rank, 1.0)) - 1);
  };
  s.p05 = percentile(0.05);
  s.p50 = percentile(0.50);
  s.p95 = percentile(0.95);
  return s;
}

}  // namespace

std::array<double, 3> lab_from_linear(double red, double green, double blue) {
  const double r = std::max(red, 0.0), g = std::max(green, 0.0), b = std::max(blue, 0.0);
  // Rows of the Rec.709 matrix divided by their sums, so that white is exactly L* = 100, a* = b* = 0.
  constexpr double kXyz[3][3] = {
      {0.4124564, 0.3575761, 0.1804375}, {0.2126729, 0.7151522, 0.0721750}, {0.0193339, 0.1191920, 0.9503041}};
  const auto f = [](double t) { return t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0; };
  double v[3];
  for (int i = 0; i < 3; ++i) {
    v[i] = f((kXyz[i][0] * r + kXyz[i][1] * g + kXyz[i][2] * b) / (kXyz[i][0] + kXyz[i][1] + kXyz[i][2]));
  }
  return {116.0 * v[1] - 16.0, 500.0 * (v[0] - v[1]), 200.0 * (v[1] - v[2])};
}

ColorSummary summarize_color(const ImageF& image, std::span<const std::uint32_t> pixels) {
  if (image.channels() != 3) throw InvalidInput("color curves: an image of 3 channels is needed");
  ColorSummary summary;
  summary.num_pixels = static_cast<std::int64_t>(pixels.size());
  if (pixels.empty()) return summary;
  std::array<std::vector<double>, 6> values;
  for (auto& channel : values) channel.reserve(pixels.size());
  for (std::uint32_t pixel : pixels) {
    if (pixel >= image.num_pixels()) throw InvalidInput("color curves: a pixel lies outside the image");
    const float* rgb = image.data() + 3 * std::size_t{pixel};
    const auto lab =
        lab_from_linear(static_cast<double>(rgb[0]), static_cast<double>(rgb[1]), static_cast<double>(rgb[2]));
    for (std::size_t c = 0; c < 3; ++c) {
      values[c].push_back(static_cast<double>(rgb[c]));
      values[c + 3].push_back(lab[c]);
    }
  }
  for (std::size_t c = 0; c < 6; ++c) summary.channels[c] = summarize(std::move(values[c]));
  return summary;
}

double delta_e(const ColorSummary& a, const ColorSummary& b) {
  double sum = 0.0;
  for (std::size_t c = 3; c < 6; ++c) {
    const double d = a.channels[c].mean - b.channels[c].mean;
    sum += d * d;
  }
  return std::sqrt(sum);
}

}  // namespace patinate
