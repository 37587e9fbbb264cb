#include "tests/support/mode_filter_reference.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

double gaussian(double x, double sigma) { return std::exp(-0.5 * (x / sigma) * (x / sigma)); }

/// The pixels of a window with their spatial weights.
struct Sample {
  double value = 0.0;
  double weight = 0.0;
};

std::vector<Sample> window_samples(const ImageF& in, const ImageU8& mask, int px, int py, double sigma) {
  std::vector<Sample> samples;
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      samples.push_back({static_cast<double>(in.at(x, y)), gaussian(x - px, sigma) * gaussian(y - py, sigma)});
    }
  }
  return samples;
}

double histogram(const std::vector<Sample>& samples, double value, double sigma) {
  double sum = 0.0, total = 0.0;
  for (const Sample& s : samples) {
    sum += s.weight * gaussian(value - s.value, sigma);
    total += s.weight;
  }
  return total > 0.0 ? sum / total : 0.0;
}

double dominant_mode(const std::vector<Sample>& samples, double sigma) {
  const auto [lowest, highest] = std::minmax_element(
      samples.begin(), samples.end(), [](const Sample& a, const Sample& b) { return a.value < b.value; });
  const double step = sigma / 8.0;
  double best = lowest->value, best_height = -1.0;
  for (double value = lowest->value; value <= highest->value + step; value += step) {
    const double height = histogram(samples, value, sigma);
    if (height > best_height) {
      best_height = height;
      best = value;
    }
  }
  constexpr double kGolden = 0.6180339887498949;
  double a = best - step, b = best + step;
  while (b - a > 1e-7 * sigma) {
    const double left = b - kGolden * (b - a), right = a + kGolden * (b - a);
    (histogram(samples, left, sigma) > histogram(samples, right, sigma) ? b : a) =
        histogram(samples, left, sigma) > histogram(samples, right, sigma) ? right : left;
  }
  return 0.5 * (a + b);
}

double nearest_mode(const std::vector<Sample>& samples, double start, double sigma) {
  double value = start;
  for (int iteration = 0; iteration < 10'000; ++iteration) {
    double sum = 0.0, total = 0.0;
    for (const Sample& s : samples) {
      const double weight = s.weight * gaussian(value - s.value, sigma);
      sum += weight * s.value;
      total += weight;
    }
    const double next = sum / total;
    if (std::abs(next - value) < 1e-4 * sigma) return next;
    value = next;
  }
  return value;
}

template <class Mode>
ImageF filter_each(const ImageF& in, const ImageU8& mask, const ModeFilterOptions& options, const RunControl& control,
                   Mode&& mode) {
  check_ranges(options);
  if (in.channels() != 1) throw InvalidInput("mode_filter: the image has several channels; give one");
  if (!mask.empty() && !in.same_size(mask)) throw InvalidInput("mode_filter: image and mask differ in size");
  bool is_any = false;
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      if (!std::isfinite(in.at(x, y))) throw InvalidInput("mode_filter: a value is not finite; mask it out");
      is_any = true;
    }
  }
  if (!is_any) throw InvalidInput("mode_filter: the mask is empty; it must cover at least one pixel");
  ImageF out(in.width(), in.height());
  parallel_for(in.num_pixels(), 16, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const int x = static_cast<int>(i % in.width()), y = static_cast<int>(i / in.width());
      if (!is_inside(mask, x, y)) continue;
      const auto samples =
          window_samples(in, mask, x, y, options.spatial_sigma_px.value_or(capture::kModeFilterWindow_px));
      out.at(x, y) = static_cast<float>(mode(samples, static_cast<double>(in.at(x, y))));
    }
  });
  return out;
}

}  // namespace

double local_histogram(const ImageF& in, const ImageU8& mask, int x, int y, double value,
                       const ModeFilterOptions& options) {
  return histogram(window_samples(in, mask, x, y, options.spatial_sigma_px.value_or(capture::kModeFilterWindow_px)),
                   value, options.range_sigma);
}

ImageF mode_filter_reference(const ImageF& in, const ImageU8& mask, const ModeFilterOptions& options,
                             const RunControl& control) {
  return filter_each(in, mask, options, control, [&](const std::vector<Sample>& samples, double) {
    return dominant_mode(samples, options.range_sigma);
  });
}

ImageF bilateral_mode_filter(const ImageF& in, const ImageU8& mask, const ModeFilterOptions& options,
                             const RunControl& control) {
  return filter_each(in, mask, options, control, [&](const std::vector<Sample>& samples, double start) {
    return nearest_mode(samples, start, options.range_sigma);
  });
}

}  // namespace patinate::capture
