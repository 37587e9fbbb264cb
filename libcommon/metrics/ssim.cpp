#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"
#include "patinate/metrics/difference.h"

namespace patinate {

namespace {

constexpr int kRadius = 5;
constexpr double kSigma = 1.5, kK1 = 0.01, kK2 = 0.03;
using Sums = std::array<double, 6>;  ///< Sums of weight, a, b, a^2, b^2, a b.

std::array<double, 2 * kRadius + 1> window() {
  std::array<double, 2 * kRadius + 1> w{};
  for (int i = -kRadius; i <= kRadius; ++i) w[i + kRadius] = std::exp(-i * i / (2.0 * kSigma * kSigma));
  return w;
}

double ssim_of(const Sums& s, double range) {
  const double n = s[0], ma = s[1] / n, mb = s[2] / n;
  const double va = std::max(0.0, s[3] / n - ma * ma), vb = std::max(0.0, s[4] / n - mb * mb), cov = s[5] / n - ma * mb;
  const double c1 = kK1 * range * kK1 * range, c2 = kK2 * range * kK2 * range;
  return (2.0 * ma * mb + c1) * (2.0 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
}

}  // namespace

ImageF ssim_map(const ImageF& a, const ImageF& b, const ImageU8& mask, double range, const RunControl& control) {
  if (!a.same_size(b) || a.channels() != 1 || b.channels() != 1)
    throw InvalidInput("ssim: two images of one size and one channel are needed");
  if (!mask.empty() && !mask.same_size(a)) throw InvalidInput("ssim: the mask has another size than the images");
  if (!(range > 0.0)) throw InvalidInput("ssim: the range of the values must be > 0");
  static const std::array<double, 2 * kRadius + 1> kWindow = window();
  const int width = a.width(), height = a.height();
  std::vector<Sums> rows(static_cast<std::size_t>(a.num_pixels()));
  parallel_for(height, 8, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y) {
      for (int x = 0; x < width; ++x) {
        Sums s{};
        for (int i = std::max(0, x - kRadius); i <= std::min(width - 1, x + kRadius); ++i) {
          if (!is_inside(mask, i, y)) continue;
          const double w = kWindow[i - x + kRadius];
          const double u = static_cast<double>(a.at(i, y)), v = static_cast<double>(b.at(i, y));
          s[0] += w, s[1] += w * u, s[2] += w * v, s[3] += w * u * u, s[4] += w * v * v, s[5] += w * u * v;
        }
        rows[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = s;
      }
    }
  });
  ImageF out(width, height);
  parallel_for(height, 8, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y) {
      for (int x = 0; x < width; ++x) {
        if (!is_inside(mask, x, y)) continue;
        Sums s{};
        for (int j = std::max(0, y - kRadius); j <= std::min(height - 1, y + kRadius); ++j) {
          const double w = kWindow[j - y + kRadius];
          const Sums& r =
              rows[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
          for (std::size_t k = 0; k < s.size(); ++k) s[k] += w * r[k];
        }
        out.at(x, y) = static_cast<float>(ssim_of(s, range));
      }
    }
  });
  return out;
}

}  // namespace patinate
