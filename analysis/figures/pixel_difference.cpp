#include "analysis/figures/pixel_difference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/metrics/difference.h"

namespace patinate::analysis {

namespace {

double percentile(std::vector<float> values, double share) {
  const double rank = std::max(1.0, std::ceil(share * static_cast<double>(values.size())));
  return static_cast<double>(value_at_rank(values, static_cast<std::size_t>(rank) - 1));
}

PixelDifference difference_at(const ColorStack& a, const ColorStack& b, std::size_t time, const ImageU8& mask) {
  const auto n = static_cast<double>(a.num_texels());
  PixelDifference d;
  const std::vector<float> colors = ciede2000_at(a, time, b, time);
  for (float v : colors) d.ciede2000_mean += static_cast<double>(v) / n;
  d.ciede2000_median = percentile(colors, 0.5);
  d.ciede2000_p95 = percentile(colors, 0.95);
  const std::span<const float> ra = a.rgb_at(time), rb = b.rgb_at(time);
  for (std::size_t i = 0; i < ra.size(); ++i)
    d.absolute += std::abs(static_cast<double>(ra[i]) - static_cast<double>(rb[i])) / (3.0 * n);
  const ImageF ssim = ssim_map(a.lab_image(time, 0), b.lab_image(time, 0), mask, 100.0, on_this_thread());
  d.ssim = 0.0;
  for (std::uint32_t t : a.texels) d.ssim += static_cast<double>(ssim.data()[t]) / n;
  return d;
}

}  // namespace

std::vector<float> ciede2000_at(const ColorStack& a, std::size_t time_a, const ColorStack& b, std::size_t time_b) {
  if (a.texels != b.texels) throw InvalidInput("pixel difference: the two sides show different texels");
  if (time_a >= a.num_times() || time_b >= b.num_times()) throw InvalidInput("pixel difference: there is no such time");
  std::vector<float> out(a.num_texels());
  const auto color = [](const float* lab) {
    return std::array<double, 3>{static_cast<double>(lab[0]), static_cast<double>(lab[1]), static_cast<double>(lab[2])};
  };
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = static_cast<float>(ciede2000(color(a.lab_of(time_a, i)), color(b.lab_of(time_b, i))));
  return out;
}

std::vector<PixelDifference> pixel_differences(const ColorStack& a, const ColorStack& b, const RunControl& control) {
  if (a.texels != b.texels || a.num_times() != b.num_times())
    throw InvalidInput("pixel difference: the same texels and as many times are needed on both sides");
  std::vector<PixelDifference> out(a.num_times());
  const ImageU8 mask = a.mask();
  parallel_for(static_cast<std::int64_t>(out.size()), 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t)
      out[t] = difference_at(a, b, t, mask);
  });
  return out;
}

std::optional<StatedNoise> stated_noise(const ColorStack& a, const ColorStack& b, std::uint64_t seed,
                                        const RunControl& control) {
  if (a.texels != b.texels || a.num_times() != b.num_times())
    throw InvalidInput("stated noise: the same texels and as many times are needed on both sides");
  if (a.deviation.empty() && b.deviation.empty()) return std::nullopt;
  constexpr double kBeyond = 11.345;  // 99 % of chi-square with three degrees of freedom.
  const std::size_t n = a.num_texels();
  std::vector<StatedNoise> of_times(a.num_times());
  parallel_for(static_cast<std::int64_t>(of_times.size()), 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      RandomStream random(seed, t);
      for (std::size_t i = 0; i < n; ++i) {
        std::array<double, 3> color{}, drawn{};
        double chi2 = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
          const std::size_t at = 3 * (t * n + i) + c;
          const double s = std::hypot(a.deviation.empty() ? 0.0 : static_cast<double>(a.deviation[at]),
                                      b.deviation.empty() ? 0.0 : static_cast<double>(b.deviation[at]));
          const double difference = static_cast<double>(a.rgb[at]) - static_cast<double>(b.rgb[at]);
          color[c] = static_cast<double>(a.rgb[at]);
          drawn[c] = color[c] + s * random.normal();
          if (s > 0.0)
            chi2 += difference * difference / (s * s);
          else if (difference != 0.0)
            chi2 = std::numeric_limits<double>::infinity();
        }
        of_times[t].ciede2000 +=
            ciede2000(lab_from_linear(color[0], color[1], color[2]), lab_from_linear(drawn[0], drawn[1], drawn[2])) /
            static_cast<double>(n);
        of_times[t].beyond_share += chi2 > kBeyond ? 1.0 / static_cast<double>(n) : 0.0;
      }
    }
  });
  StatedNoise mean;
  for (const StatedNoise& one : of_times) {
    mean.ciede2000 += one.ciede2000 / static_cast<double>(of_times.size());
    mean.beyond_share += one.beyond_share / static_cast<double>(of_times.size());
  }
  return mean;
}

}  // namespace patinate::analysis
