#include "libcommon/image/filters.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr double kCutSigmas = 4.0;
constexpr std::int64_t kRowsPerChunk = 16;

/// Weights 0..radius of a Gaussian that is 1 at 0.
std::vector<float> half_kernel(double sigma_px) {
  if (!(sigma_px >= 0) || !(sigma_px <= 1e5)) {
    throw InvalidInput("sigma_px: " + number_text(sigma_px) + " is out of range; use [0, 100000]");
  }
  const int radius = static_cast<int>(std::ceil(kCutSigmas * sigma_px));
  std::vector<float> weights(static_cast<std::size_t>(radius) + 1);
  weights[0] = 1.0f;
  for (int i = 1; i <= radius; ++i) {
    weights[i] = static_cast<float>(std::exp(-0.5 * (i / sigma_px) * (i / sigma_px)));
  }
  return weights;
}

/// Sums of weighted neighbors in one direction, not normalized.
/// `step` values apart along the direction, `length` samples, this one is number `at`.
void accumulate(const float* center, std::ptrdiff_t step, int at, int length, const std::vector<float>& weights,
                std::size_t num_values, float* out) {
  const int radius = static_cast<int>(weights.size()) - 1;
  const int first = std::max(-radius, -at), last = std::min(radius, length - 1 - at);
  for (int k = first; k <= last; ++k) {
    const float weight = weights[std::abs(k)];
    const float* source = center + k * step;
    for (std::size_t i = 0; i < num_values; ++i) out[i] += weight * source[i];
  }
}

/// Unnormalized separable sum.
ImageF blur_sum(const ImageF& in, const std::vector<float>& weights, const RunControl& control) {
  const int width = in.width(), height = in.height(), channels = in.channels();
  const std::size_t row_size = static_cast<std::size_t>(width) * static_cast<std::size_t>(channels);
  ImageF vertical(width, height, channels), out(width, height, channels);
  parallel_for(height, kRowsPerChunk, control.part(0.0, 0.5), [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      accumulate(in.row(y).data(), static_cast<std::ptrdiff_t>(row_size), y, height, weights, row_size,
                 vertical.row(y).data());
    }
  });
  // Along the row, all pixels far enough from the ends share their taps: sum shifted copies of the row.
  const int radius = static_cast<int>(weights.size()) - 1;
  parallel_for(height, kRowsPerChunk, control.part(0.5, 1.0), [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      const float* source = vertical.row(y).data();
      float* target = out.row(y).data();
      for (int k = -std::min(radius, width - 1); k <= std::min(radius, width - 1); ++k) {
        const float weight = weights[std::abs(k)];
        const int first = std::max(0, -k) * channels, last = std::min(width, width - k) * channels;
        const std::ptrdiff_t shift = std::ptrdiff_t{k} * channels;
        for (int i = first; i < last; ++i) target[i] += weight * source[i + shift];
      }
    }
  });
  return out;
}

/// For every position, the sum of the weights that fall inside [0, length).
std::vector<float> weight_sums(int length, const std::vector<float>& weights) {
  const std::vector<float> ones(static_cast<std::size_t>(length), 1.0f);
  std::vector<float> sums(static_cast<std::size_t>(length), 0.0f);
  for (int i = 0; i < length; ++i) {
    const std::size_t k = i;
    accumulate(&ones[k], 1, i, length, weights, 1, &sums[k]);
  }
  return sums;
}

struct Interval {
  int first = 0;
  std::vector<float> weights;
};

/// Source samples covered by every one of `to` equal parts of `from` samples, with weights of sum 1.
std::vector<Interval> area_intervals(int from, int to) {
  std::vector<Interval> intervals;
  for (int i = 0; i < to; ++i) {
    const double begin = static_cast<double>(i) * from / to, end = static_cast<double>(i + 1) * from / to;
    Interval interval{static_cast<int>(begin), {}};
    for (int k = interval.first; k < from && k < end; ++k) {
      const double covered = std::min(end, k + 1.0) - std::max(begin, static_cast<double>(k));
      if (covered > 1e-9) interval.weights.push_back(static_cast<float>(covered / (end - begin)));
    }
    intervals.push_back(std::move(interval));
  }
  return intervals;
}

std::vector<Interval> bilinear_intervals(int from, int to) {
  std::vector<Interval> intervals;
  for (int i = 0; i < to; ++i) {
    const double x = std::clamp((i + 0.5) * from / to - 0.5, 0.0, from - 1.0);
    const int first = static_cast<int>(x);
    const float fraction = static_cast<float>(x - first);
    if (fraction > 0.0f) {
      intervals.push_back({first, {1.0f - fraction, fraction}});
    } else {
      intervals.push_back({first, {1.0f}});
    }
  }
  return intervals;
}

ImageF resample(const ImageF& in, const std::vector<Interval>& columns, const std::vector<Interval>& rows,
                const RunControl& control) {
  const int channels = in.channels();
  ImageF out(static_cast<int>(columns.size()), static_cast<int>(rows.size()), channels);
  parallel_for(out.height(), kRowsPerChunk, control, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> row(static_cast<std::size_t>(in.width()) * static_cast<std::size_t>(channels));
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      std::fill(row.begin(), row.end(), 0.0f);
      const Interval& interval = rows[y];
      for (std::size_t k = 0; k < interval.weights.size(); ++k) {
        const auto source = in.row(interval.first + static_cast<int>(k));
        for (std::size_t i = 0; i < row.size(); ++i) row[i] += interval.weights[k] * source[i];
      }
      for (int x = 0; x < out.width(); ++x) {
        const Interval& column = columns[x];
        for (int c = 0; c < channels; ++c) {
          float sum = 0.0f;
          for (std::size_t k = 0; k < column.weights.size(); ++k) {
            const std::size_t at = (static_cast<std::size_t>(column.first) + k) * static_cast<std::size_t>(channels);
            sum += column.weights[k] * row[at + static_cast<std::size_t>(c)];
          }
          out.at(x, y, c) = sum;
        }
      }
    }
  });
  return out;
}

}  // namespace

ImageF gaussian_blur(const ImageF& in, double sigma_px, const RunControl& control) {
  const std::vector<float> weights = half_kernel(sigma_px);
  if (weights.size() == 1 || in.empty()) return in;
  ImageF out = blur_sum(in, weights, control);
  const std::vector<float> across = weight_sums(in.width(), weights), down = weight_sums(in.height(), weights);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const float total = across[x] * down[y];
      for (float& v : out.pixel(x, y)) v /= total;
    }
  }
  return out;
}

ImageF gaussian_blur(const ImageF& in, const ImageU8& mask, double sigma_px, const RunControl& control) {
  if (mask.empty()) return gaussian_blur(in, sigma_px, control);
  if (!in.same_size(mask)) {
    throw InvalidInput("gaussian_blur: the image is " + size_text(in.width(), in.height()) + ", the mask " +
                       size_text(mask.width(), mask.height()) + "; sizes must agree");
  }
  const std::vector<float> weights = half_kernel(sigma_px);
  ImageF inside(in.width(), in.height(), in.channels() + 1);
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      if (mask.at(x, y) == 0) continue;
      for (int c = 0; c < in.channels(); ++c) inside.at(x, y, c) = in.at(x, y, c);
      inside.at(x, y, in.channels()) = 1.0f;
    }
  }
  const ImageF sums = blur_sum(inside, weights, control);
  ImageF out(in.width(), in.height(), in.channels());
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      const float total = sums.at(x, y, in.channels());
      if (!(total > 0.0f)) continue;
      for (int c = 0; c < in.channels(); ++c) out.at(x, y, c) = sums.at(x, y, c) / total;
    }
  }
  return out;
}

ImageF downscale_area(const ImageF& in, int width, int height, const RunControl& control) {
  if (width < 1 || height < 1 || width > in.width() || height > in.height()) {
    throw InvalidInput("downscale_area: cannot make " + size_text(width, height) + " from " +
                       size_text(in.width(), in.height()) + "; use a size of at least 1 that is not larger");
  }
  if (width == in.width() && height == in.height()) return in;
  return resample(in, area_intervals(in.width(), width), area_intervals(in.height(), height), control);
}

ImageF resize_bilinear(const ImageF& in, int width, int height, const RunControl& control) {
  if (width < 1 || height < 1 || in.empty()) {
    throw InvalidInput("resize_bilinear: cannot make " + size_text(width, height) + " from " +
                       size_text(in.width(), in.height()) + "; use sizes of at least 1");
  }
  return resample(in, bilinear_intervals(in.width(), width), bilinear_intervals(in.height(), height), control);
}

template <class T>
Image<T> crop(const Image<T>& in, int x, int y, int width, int height) {
  if (x < 0 || y < 0 || width < 1 || height < 1 || width > in.width() - x || height > in.height() - y) {
    throw InvalidInput("crop: " + size_text(width, height) + " at (" + std::to_string(x) + ", " + std::to_string(y) +
                       ") is not inside " + size_text(in.width(), in.height()));
  }
  Image<T> out(width, height, in.channels());
  for (int row = 0; row < height; ++row) {
    const auto source = in.row(y + row).subspan(static_cast<std::size_t>(x) * static_cast<std::size_t>(in.channels()));
    std::copy_n(source.begin(), out.row(row).size(), out.row(row).begin());
  }
  return out;
}

Percentiles percentiles(const ImageF& in, const ImageU8& mask, double low, double high) {
  if (in.channels() != 1 || (!mask.empty() && !in.same_size(mask)) || !(low >= 0 && low <= high && high <= 1)) {
    throw InvalidInput("percentiles: give one channel, a mask of its size, and ranks 0 <= low <= high <= 1");
  }
  std::vector<float> values;
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      if (is_inside(mask, x, y)) values.push_back(in.at(x, y));
    }
  }
  if (values.empty()) throw InvalidInput("percentiles: the mask is empty; it must cover at least one pixel");
  const auto value_of_rank = [&](double rank) {
    const auto at =
        values.begin() + static_cast<std::ptrdiff_t>(std::lround(rank * static_cast<double>(values.size() - 1)));
    std::nth_element(values.begin(), at, values.end());
    return *at;
  };
  const float low_value = value_of_rank(low);
  return {low_value, value_of_rank(high)};
}

template ImageF crop(const ImageF&, int, int, int, int);
template ImageU8 crop(const ImageU8&, int, int, int, int);

}  // namespace patinate
