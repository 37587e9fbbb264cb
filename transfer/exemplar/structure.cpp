#include "transfer/exemplar/structure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "libcommon/core/portable_math.h"
#include "patinate/image/color.h"

namespace patinate::transfer {

namespace {

constexpr std::array kReaches_px{2, 4, 8, 16};
constexpr double kLeastContrast = 3.0;                    // L*. Less is noise, or hardly seen.
constexpr double kLowOfHigh = 0.4;                        // Threshold of all lines, as a share of Otsu's.
constexpr double kLeastElongation = 30.0;                 // Length over width: of a network it is the whole length.
constexpr double kLeastElongated = 0.6;                   // Share of what is found that must be lines.
constexpr double kLeastShare = 0.005, kMostShare = 0.25;  // Of the surface: lines are rare.
constexpr int kMaxBins = 400;                             // Of a quarter L*.

/// L* of a luminance in [0, 1] [CIE 15].
float lightness_of(float luminance) {
  const double y = std::max(0.0, static_cast<double>(luminance));
  return static_cast<float>(y > 216.0 / 24389.0 ? 116.0 * portable_pow(y, 1.0 / 3.0) - 16.0 : y * 24389.0 / 27.0);
}

/// What the square fills: how much darker (or brighter) than its surroundings a pixel is. Exact in floats.
cv::Mat filled(const cv::Mat& lightness, int reach, bool dark) {
  cv::Mat smooth;
  const cv::Mat square = cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U);
  cv::morphologyEx(lightness, smooth, dark ? cv::MORPH_CLOSE : cv::MORPH_OPEN, square);
  return dark ? smooth - lightness : lightness - smooth;
}

struct Thresholds {
  double low = 0.0, high = 0.0;
};

/// Otsu's of what is filled at all; the low one lies above the noise, which fills every pixel a little.
Thresholds find_thresholds(const cv::Mat& fill, const ImageU8& mask) {
  std::array<std::int64_t, kMaxBins> counts{};
  std::int64_t total = 0;
  for (int y = 0; y < fill.rows; ++y) {
    for (int x = 0; x < fill.cols; ++x) {
      if (!is_inside(mask, x, y)) continue;
      ++counts[static_cast<std::size_t>(std::clamp(static_cast<int>(fill.at<float>(y, x) * 4.0f), 0, kMaxBins - 1))];
      ++total;
    }
  }
  double sum = 0.0;
  for (int b = 0; b < kMaxBins; ++b) sum += static_cast<double>(counts[static_cast<std::size_t>(b)]) * b;
  double below = 0.0, below_sum = 0.0, best = -1.0;
  int high = 0, median = -1;
  for (int b = 0; b + 1 < kMaxBins; ++b) {
    const auto n = static_cast<double>(counts[static_cast<std::size_t>(b)]);
    below += n;
    below_sum += n * b;
    if (median < 0 && 2.0 * below >= static_cast<double>(total)) median = b;
    const double above = static_cast<double>(total) - below;
    if (below == 0.0 || above == 0.0) continue;
    const double apart = below_sum / below - (sum - below_sum) / above;
    if (const double between = below * above * apart * apart; between > best) {
      best = between;
      high = b + 1;
    }
  }
  const double noise = 5.0 * (median + 1) / 4.0;
  return {.low = std::max({kLowOfHigh * high / 4.0, kLeastContrast, std::min(noise, high / 4.0)}),
          .high = std::max(high / 4.0, kLeastContrast)};
}

/// Lines among what is filled.
struct Lines {
  cv::Mat fill;
  cv::Mat all, strong;  ///< 0 / 255.
  Thresholds thresholds;
  double elongated = 0.0;  ///< Share of what passed the thresholds.
  double mass = 0.0;       ///< Sum of what the square fills on lines.
  double share = 0.0;      ///< Of the pixels inside the mask.
  double found = 0.0;      ///< As much of them passed the thresholds, lines or not.
  [[nodiscard]] bool are_structure() const {
    return elongated >= kLeastElongated && share >= kLeastShare && found <= kMostShare;
  }
};

/// Keeps the connected pieces above the low threshold that reach the high one and are long.
Lines find_lines(const cv::Mat& lightness, const ImageU8& mask, int reach, bool dark) {
  Lines lines{.fill = filled(lightness, reach, dark), .all = {}, .strong = {}, .thresholds = {}};
  lines.thresholds = find_thresholds(lines.fill, mask);
  cv::Mat above = lines.fill >= lines.thresholds.low;
  std::int64_t inside = 0;
  for (int y = 0; y < above.rows; ++y) {
    for (int x = 0; x < above.cols; ++x) {
      if (is_inside(mask, x, y)) {
        ++inside;
      } else {
        above.at<std::uint8_t>(y, x) = 0;
      }
    }
  }
  cv::Mat label, stats, centers, inner;
  const int count = cv::connectedComponentsWithStats(above, label, stats, centers, 8);
  cv::distanceTransform(above, inner, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  std::vector<double> inner_sum(static_cast<std::size_t>(count), 0.0), mass(static_cast<std::size_t>(count), 0.0);
  std::vector<std::uint8_t> is_strong(static_cast<std::size_t>(count), 0), is_kept(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < above.rows; ++y) {
    for (int x = 0; x < above.cols; ++x) {
      const auto l = static_cast<std::size_t>(label.at<int>(y, x));
      if (l == 0) continue;
      inner_sum[l] += static_cast<double>(inner.at<float>(y, x));
      mass[l] += static_cast<double>(lines.fill.at<float>(y, x));
      if (static_cast<double>(lines.fill.at<float>(y, x)) >= lines.thresholds.high) is_strong[l] = 1;
    }
  }
  double found = 0.0, kept = 0.0;
  for (int l = 1; l < count; ++l) {
    const auto i = static_cast<std::size_t>(l);
    const double area = stats.at<int>(l, cv::CC_STAT_AREA);
    found += area;
    // The mean distance to the outside is a quarter of the width of a band.
    const double width = std::max(1.0, 4.0 * inner_sum[i] / area - 1.0);
    if (is_strong[i] == 0 || area < kLeastElongation * width * width) continue;
    is_kept[i] = 1;
    kept += area;
    lines.mass += mass[i];
  }
  lines.elongated = found > 0.0 ? kept / found : 0.0;
  lines.share = kept / static_cast<double>(std::max<std::int64_t>(1, inside));
  lines.found = found / static_cast<double>(std::max<std::int64_t>(1, inside));
  lines.all = cv::Mat::zeros(above.size(), CV_8U);
  lines.strong = cv::Mat::zeros(above.size(), CV_8U);
  for (int y = 0; y < above.rows; ++y) {
    for (int x = 0; x < above.cols; ++x) {
      if (is_kept[static_cast<std::size_t>(label.at<int>(y, x))] == 0) continue;
      lines.all.at<std::uint8_t>(y, x) = 255;
      if (static_cast<double>(lines.fill.at<float>(y, x)) >= lines.thresholds.high)
        lines.strong.at<std::uint8_t>(y, x) = 255;
    }
  }
  return lines;
}

/// The smallest reach that finds most of what any does, dark or bright.
Lines find_most_lines(const cv::Mat& lightness, const ImageU8& mask, bool& is_dark, const RunControl& control) {
  std::vector<Lines> found;
  double most = 0.0;
  for (bool dark : {true, false}) {
    for (int reach : kReaches_px) {
      control.throw_if_stopped();
      if (4 * reach >= std::min(lightness.rows, lightness.cols)) continue;
      found.push_back(find_lines(lightness, mask, reach, dark));
      if (!found.back().are_structure()) found.back().mass = 0.0;
      most = std::max(most, found.back().mass);
    }
  }
  const std::size_t num_dark = found.size() / 2;
  std::size_t best = 0;
  const auto is_enough = [&](std::size_t i) { return found[i].mass >= 0.8 * most; };
  while (best + 1 < found.size() && !is_enough(best)) ++best;
  is_dark = best < num_dark;
  return most > 0.0 ? std::move(found[best]) : Lines{};
}

cv::Mat distance_to(const cv::Mat& lines) {
  cv::Mat distance;
  cv::distanceTransform(lines == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance;
}

/// The value below which 98 % of the distances inside the mask lie.
double largest_distance(const cv::Mat& distance, const ImageU8& mask) {
  std::vector<float> values;
  for (int y = 0; y < distance.rows; ++y) {
    for (int x = 0; x < distance.cols; ++x) {
      if (is_inside(mask, x, y)) values.push_back(distance.at<float>(y, x));
    }
  }
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 98 / 100);
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

}  // namespace

SourceStructure find_structure(const ImageF& lightness, const ImageU8& mask, const RunControl& control) {
  SourceStructure result;
  cv::Mat image(lightness.height(), lightness.width(), CV_32F);
  std::copy(lightness.values().begin(), lightness.values().end(), image.ptr<float>());
  const Lines lines = find_most_lines(image, mask, result.is_dark, control);
  if (lines.all.empty()) return result;
  result.share = lines.share;
  const cv::Mat to_any = distance_to(lines.all), to_strong = distance_to(lines.strong);
  result.scale_px = std::max(2.0, largest_distance(to_any, mask));
  result.contrast = lines.thresholds.low;
  const double strong_scale_px = std::max(2.0, largest_distance(to_strong, mask));
  result.channels = ImageF(image.cols, image.rows, kStructureSize);
  for (int y = 0; y < image.rows; ++y) {
    control.throw_if_stopped();
    for (int x = 0; x < image.cols; ++x) {
      const auto any = static_cast<double>(to_any.at<float>(y, x)),
                 strong = static_cast<double>(to_strong.at<float>(y, x)),
                 fill = static_cast<double>(lines.fill.at<float>(y, x));
      const auto sureness = [&](double threshold, bool is_near) {
        return is_near ? std::clamp(fill / threshold - 0.3, 0.0, 1.0) : 0.0;
      };
      const std::array<double, kStructureSize> values{
          2.0 * portable_decayed(any / result.scale_px), 2.0 * portable_decayed(strong / strong_scale_px),
          portable_decayed(6.0 * any / result.scale_px), sureness(lines.thresholds.low, any < 2.0),
          sureness(lines.thresholds.high, strong < 2.0)};
      for (int c = 0; c < kStructureSize; ++c)
        result.channels.at(x, y, c) = static_cast<float>(values[static_cast<std::size_t>(c)]);
    }
  }
  return result;
}

SourceStructure find_structure(const History& history, const ImageU8& mask, const RunControl& control) {
  const ImageF frame = history.read_frame(history.num_frames() - 1);
  ImageF lightness(frame.width(), frame.height());
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) lightness.at(x, y) = lightness_of(luminance(frame.pixel(x, y)));
  }
  return find_structure(lightness, mask, control);
}

}  // namespace patinate::transfer
