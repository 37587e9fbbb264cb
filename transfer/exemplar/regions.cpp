#include "transfer/exemplar/regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "libcommon/core/portable_math.h"
#include "libcommon/geometry/dense_solve.h"
#include "transfer/exemplar/matrices.h"

namespace patinate::transfer {

namespace {

constexpr std::array kRadii_px{1, 2, 4};  ///< Smoothing that is tried, the finest first.
/// Share of the variance that the class means explain; a normal distribution has 2 / pi = 0.64.
constexpr double kMinSeparation = 0.8;
/// Range of values around the border, as a share of the difference of the means.
constexpr double kMinSharpness = 0.9;
/// The rarer class covers at least a twentieth (docs/algorithms/refinement.md).
constexpr double kMinRegionShare = 0.05;
constexpr double kMinWidth_px = 8.0;        // A neighborhood sees seven.
constexpr double kMinRegionContrast = 6.0;  // Twice what is hardly seen.
constexpr int kBins = 512;                  ///< Bins of the histogram that is split in two.

/// About as evenly spaced as lightness, [0, 100].
double encoded(float linear) {
  return 100.0 * portable_pow(std::clamp(static_cast<double>(linear), 0.0, 1.0), 1.0 / 2.4);
}

/// Colors along the axis on which they vary most.
cv::Mat principal_value(const ImageF& colors, const ImageU8& mask, const RunControl& control) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double count = 0.0;
  cv::Mat color(colors.height(), colors.width(), CV_32FC3);
  for (int y = 0; y < colors.height(); ++y) {
    control.throw_if_stopped();
    for (int x = 0; x < colors.width(); ++x) {
      const auto pixel = colors.pixel(x, y);
      const Eigen::Vector3d v(encoded(pixel[0]), encoded(pixel[1]), encoded(pixel[2]));
      color.at<cv::Vec3f>(y, x) = {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
      if (!is_inside(mask, x, y)) continue;
      sum += v;
      squares += v * v.transpose();
      count += 1.0;
    }
  }
  if (count == 0.0) return {};
  const Eigen::Vector3d mean = sum / count;
  const SymmetricEigen<Eigen::Matrix3d> solver =
      symmetric_eigen(Eigen::Matrix3d(squares / count - mean * mean.transpose()));
  Eigen::Vector3d axis = solver.vectors.col(2);
  if (axis.sum() < 0.0) axis = -axis;  // Brighter is more.
  axis /= std::sqrt(3.0);              // From black to white it is 100.
  cv::Mat value(color.size(), CV_32F);
  for (int y = 0; y < value.rows; ++y) {
    for (int x = 0; x < value.cols; ++x) {
      const cv::Vec3f& c = color.at<cv::Vec3f>(y, x);
      value.at<float>(y, x) =
          static_cast<float>(axis[0] * static_cast<double>(c[0]) + axis[1] * static_cast<double>(c[1]) +
                             axis[2] * static_cast<double>(c[2]));
    }
  }
  return value;
}

/// Otsu's threshold over the pixels inside, and what it separates.
void separate(const cv::Mat& value, const ImageU8& mask, Regions& regions) {
  double low = 0.0, high = 0.0;
  cv::minMaxLoc(value, &low, &high);
  if (!(high - low >= kMinRegionContrast)) return;
  std::array<double, kBins> counts{};
  double total = 0.0, sum = 0.0, squares = 0.0;
  const double per_bin = (high - low) / kBins;
  for (int y = 0; y < value.rows; ++y) {
    for (int x = 0; x < value.cols; ++x) {
      if (!is_inside(mask, x, y)) continue;
      const double v = static_cast<double>(value.at<float>(y, x)) - low;
      const int bin = std::clamp(static_cast<int>(v / per_bin), 0, kBins - 1);
      counts[bin] += 1.0;
      total += 1.0;
      sum += bin + 0.5;
      squares += (bin + 0.5) * (bin + 0.5);
    }
  }
  if (total == 0.0) return;
  const double variance = squares / total - (sum / total) * (sum / total);
  double below = 0.0, below_sum = 0.0, best = 0.0;
  for (int b = 0; b + 1 < kBins; ++b) {
    below += counts[b];
    below_sum += counts[b] * (b + 0.5);
    const double above = total - below;
    if (below == 0.0 || above == 0.0) continue;
    const double apart = (sum - below_sum) / above - below_sum / below;
    const double between = below * above * apart * apart / (total * total);
    if (between <= best) continue;
    best = between;
    regions.threshold = low + (b + 1) * per_bin;
    regions.contrast = apart * per_bin;
    regions.share = std::min(below, above) / total;
  }
  regions.separation = variance > 0.0 ? best / variance : 0.0;
}

/// Twice the area of the rarer class over its border.
double width_of(const cv::Mat& is_second, const ImageU8& mask, double share) {
  double border = 0.0, total = 0.0;
  for (int y = 0; y < is_second.rows; ++y) {
    for (int x = 0; x < is_second.cols; ++x) {
      if (!is_inside(mask, x, y)) continue;
      total += 1.0;
      const std::uint8_t here = is_second.at<std::uint8_t>(y, x);
      if (x + 1 < is_second.cols && is_inside(mask, x + 1, y)) border += here != is_second.at<std::uint8_t>(y, x + 1);
      if (y + 1 < is_second.rows && is_inside(mask, x, y + 1)) border += here != is_second.at<std::uint8_t>(y + 1, x);
    }
  }
  // Steps of the grid are 4 / pi as long as what they follow.
  constexpr double kGrid = 0.7853981633974483;
  return border > 0.0 ? 2.0 * share * total / (kGrid * border) : 0.0;
}

/// How far values range within four pixels of the border, in contrasts: about 1 for materials that meet, little for a
/// gradient.
double sharpness_of(const cv::Mat& value, const cv::Mat& is_second, double contrast, const ImageU8& mask) {
  cv::Mat most, least, inner;
  const cv::Mat square = cv::Mat::ones(9, 9, CV_8U);
  cv::dilate(value, most, square);
  cv::erode(value, least, square);
  cv::erode(is_second, inner, cv::Mat::ones(3, 3, CV_8U));
  double sum = 0.0, count = 0.0;
  for (int y = 0; y < inner.rows; ++y) {
    for (int x = 0; x < inner.cols; ++x) {
      if (!is_inside(mask, x, y) || is_second.at<std::uint8_t>(y, x) == inner.at<std::uint8_t>(y, x)) continue;
      sum += static_cast<double>(most.at<float>(y, x)) - static_cast<double>(least.at<float>(y, x));
      count += 1.0;
    }
  }
  return count > 0.0 ? sum / count / contrast : 0.0;
}

}  // namespace

Regions find_regions(const ImageF& colors, const ImageU8& mask, const RunControl& control) {
  const cv::Mat value = principal_value(colors, mask, control);
  for (int radius : kRadii_px) {
    control.throw_if_stopped();
    if (value.empty() || 8 * radius >= std::min(value.rows, value.cols)) break;
    Regions regions;
    cv::Mat smooth;
    cv::blur(value, smooth, cv::Size(2 * radius + 1, 2 * radius + 1), cv::Point(-1, -1), cv::BORDER_REFLECT);
    separate(smooth, mask, regions);
    if (regions.separation < kMinSeparation || regions.share < kMinRegionShare || regions.contrast < kMinRegionContrast)
      continue;
    const cv::Mat is_second = smooth >= regions.threshold;
    regions.width_px = width_of(is_second, mask, regions.share);
    if (regions.width_px < kMinWidth_px || sharpness_of(smooth, is_second, regions.contrast, mask) < kMinSharpness)
      continue;
    regions.is_second = byte_image_of(is_second);
    regions.value = float_image_of(smooth);
    return regions;
  }
  return {};
}

}  // namespace patinate::transfer
