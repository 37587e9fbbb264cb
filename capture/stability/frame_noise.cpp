#include "capture/stability/frame_noise.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "libcommon/core/median.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr double kPool_px = 1.0;  ///< Gaussian that smooths the estimate over neighbors.
constexpr double kSlow_px = 4.0;  ///< Slower changes over the picture are aging that bends in time.
constexpr double kJump = 6.0;     ///< Medians of the size: four standard deviations.
/// Standard deviation that white noise keeps without its slow part: 1 - 1 / (pi s^2) + 1 / (4 pi s^2) is its square.
constexpr double kFastPart = 0.9925;
/// Mean of sqrt(|x|) of a normal number of unit variance: 2^(1/4) Gamma(3/4) / sqrt(pi).
constexpr double kRootMean = 0.82217;
constexpr std::size_t kNumBins = 16;  ///< Number of bins of color, equally filled, for the course of the noise.

/// How much of the noise of three frames a frame's distance from the line between its neighbors has.
double distance_spread(double before, double now, double after) {
  const double b = (now - before) / (after - before), a = 1.0 - b;
  return std::sqrt(1.0 + a * a + b * b);
}

/// Removes jumps, so that a crack that opens does not become its neighbors' course.
ImageF without_jumps(ImageF rest) {
  std::vector<float> sizes(rest.values().begin(), rest.values().end());
  for (float& v : sizes) v = std::abs(v);
  const float most = static_cast<float>(kJump) * median(std::move(sizes));
  for (float& v : rest.values()) v = std::clamp(v, -most, most);
  return rest;
}

/// sum += sqrt(|what is left of now - line without its slow course over the picture|) / spread.
void add_roots(const ImageF& before, const ImageF& now, const ImageF& after, double share_after, double spread,
               ImageF& sum) {
  ImageF rest = now;
  for (std::int64_t i = 0; i < 3 * now.num_pixels(); ++i) {
    const double line = (1.0 - share_after) * static_cast<double>(before.data()[i]) +
                        share_after * static_cast<double>(after.data()[i]);
    rest.data()[i] = static_cast<float>(static_cast<double>(now.data()[i]) - line);
  }
  const ImageF slow = gaussian_blur(without_jumps(rest), kSlow_px);
  for (std::int64_t i = 0; i < 3 * now.num_pixels(); ++i) {
    const double noise = static_cast<double>(rest.data()[i] - slow.data()[i]);
    sum.data()[i] += static_cast<float>(std::sqrt(std::abs(noise) / (kFastPart * spread)));
  }
}

/// Median of 5 x 5 pixels, so that a crack's own do not count, then a Gaussian.
ImageF pooled(const ImageF& sum) {
  cv::Mat values(sum.height(), sum.width(), CV_32FC3);
  std::copy(sum.values().begin(), sum.values().end(), values.ptr<float>());
  std::array<cv::Mat, 3> channels;
  cv::split(values, channels.data());
  for (cv::Mat& channel : channels) cv::medianBlur(channel, channel, 5);
  cv::merge(channels.data(), channels.size(), values);
  ImageF result = sum;
  std::copy_n(values.ptr<float>(), 3 * sum.num_pixels(), result.data());
  return gaussian_blur(result, kPool_px);
}

/// offset + slope * color through the medians of bins, both at least 0.
void fit_course(const SeriesNoise& noise, std::size_t channel, double& offset, double& slope) {
  std::vector<std::pair<float, float>> pairs;  // Color, variance.
  for (std::int64_t i = 0; i < noise.level.num_pixels(); ++i) {
    const std::int64_t k = 3 * i + static_cast<std::int64_t>(channel);
    pairs.emplace_back(noise.mean.data()[k], noise.level.data()[k] * noise.level.data()[k]);
  }
  std::sort(pairs.begin(), pairs.end());
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t bin = 0; bin < kNumBins; ++bin) {
    const std::size_t begin = bin * pairs.size() / kNumBins, end = (bin + 1) * pairs.size() / kNumBins;
    if (begin == end) continue;
    std::vector<float> colors, variances;
    for (std::size_t k = begin; k < end; ++k) colors.push_back(pairs[k].first), variances.push_back(pairs[k].second);
    const double x = static_cast<double>(median(std::move(colors))),
                 y = static_cast<double>(median(std::move(variances)));
    n += 1.0, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const double spread = sxx - sx * sx / n;
  slope = spread > 1e-12 ? std::max(0.0, (sxy - sx * sy / n) / spread) : 0.0;
  offset = (sy - slope * sx) / n;
  if (offset >= 0.0) return;
  offset = 0.0;
  slope = sxx > 0.0 ? std::max(0.0, sxy / sxx) : 0.0;
}

}  // namespace

ImageF SeriesNoise::deviation_of(const ImageF& frame) const {
  if (!frame.same_size(level) || frame.channels() != 3) throw InvalidInput("noise: the frames differ in size");
  ImageF result = level;
  for (std::int64_t i = 0; i < 3 * result.num_pixels(); ++i) {
    const std::size_t c = i % 3;
    const auto variance = [&](float color) { return offset[c] + slope[c] * std::max(0.0, static_cast<double>(color)); };
    const double there = variance(mean.data()[i]);
    if (there > 0.0) result.data()[i] *= static_cast<float>(std::sqrt(variance(frame.data()[i]) / there));
  }
  return result;
}

SeriesNoise estimate_noise(const std::vector<double>& times, const std::function<ImageF(int)>& read_frame,
                           const RunControl& control) {
  const int n = static_cast<int>(times.size());
  if (n < kMinForNoise) throw InvalidInput("noise: five frames or more tell it from aging");
  ImageF before = read_frame(0), now = read_frame(1);
  SeriesNoise noise{.level = ImageF(now.width(), now.height(), 3), .mean = before};
  const auto add_to_mean = [&](const ImageF& frame) {
    if (!frame.same_size(noise.mean) || frame.channels() != 3) throw InvalidInput("noise: the frames differ in size");
    std::transform(frame.values().begin(), frame.values().end(), noise.mean.values().begin(),
                   noise.mean.values().begin(), std::plus<>());
  };
  add_to_mean(now);
  for (int i = 1; i + 1 < n; ++i) {
    control.throw_if_stopped();
    ImageF after = read_frame(i + 1);
    add_to_mean(after);
    const auto t = [&](int k) { return times[k]; };
    add_roots(before, now, after, (t(i) - t(i - 1)) / (t(i + 1) - t(i - 1)), distance_spread(t(i - 1), t(i), t(i + 1)),
              noise.level);
    before = std::move(now);
    now = std::move(after);
    control.report(static_cast<double>(i) / n);
  }
  for (float& v : noise.mean.values()) v /= static_cast<float>(n);
  noise.level = pooled(noise.level);
  for (float& v : noise.level.values()) {
    const double root = static_cast<double>(v) / ((n - 2) * kRootMean);
    v = static_cast<float>(root * root);
  }
  for (std::size_t c = 0; c < 3; ++c) fit_course(noise, c, noise.offset[c], noise.slope[c]);
  control.report(1.0);
  return noise;
}

}  // namespace patinate::capture
