#include "transfer/exemplar/lines.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

namespace patinate::transfer {

namespace {

constexpr std::array kReaches_px{2, 4, 8, 16};
constexpr double kLeastContrast = 3.0;                    // L*. Less is noise, or hardly seen.
constexpr double kLowOfHigh = 0.4;                        // Threshold of all lines, as a share of Otsu's.
constexpr double kLeastElongation = 30.0;                 // Length over width: of a network it is the whole length.
constexpr double kLeastElongated = 0.6;                   // Share of what is found that must be lines.
constexpr double kLeastShare = 0.005, kMostShare = 0.25;  // Of the surface: lines are rare.
constexpr int kMaxBins = 400;                             // Of a quarter L*.
constexpr double kEnough = 0.8;                           // Of what the best square finds.

/// What the square fills: how much darker (or brighter) than its surroundings a pixel is. Exact in floats.
cv::Mat filled(const cv::Mat& lightness, int reach, bool dark) {
  cv::Mat smooth;
  const cv::Mat square = cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U);
  cv::morphologyEx(lightness, smooth, dark ? cv::MORPH_CLOSE : cv::MORPH_OPEN, square);
  return dark ? smooth - lightness : lightness - smooth;
}

/// Otsu's of what is filled at all; the low one lies above the noise, which fills every pixel a little.
LineThresholds find_thresholds(const cv::Mat& fill, const ImageU8& mask) {
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

/// What one square finds.
struct FoundLines {
  Lines lines;
  double elongated = 0.0;  ///< Share of what passed the thresholds.
  double mass = 0.0;       ///< Sum of what the square fills on lines.
  double found = 0.0;      ///< As much of them passed the thresholds, lines or not.
  [[nodiscard]] bool are_structure() const {
    return elongated >= kLeastElongated && lines.share >= kLeastShare && found <= kMostShare;
  }
};

/// Keeps the connected pieces above the low threshold that reach the high one and are long.
FoundLines find_lines_of(const cv::Mat& lightness, const ImageU8& mask, int reach, bool dark) {
  FoundLines result;
  Lines& lines = result.lines;
  lines.fill = filled(lightness, reach, dark);
  lines.is_dark = dark;
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
    result.mass += mass[i];
  }
  result.elongated = found > 0.0 ? kept / found : 0.0;
  lines.share = kept / static_cast<double>(std::max<std::int64_t>(1, inside));
  result.found = found / static_cast<double>(std::max<std::int64_t>(1, inside));
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
  return result;
}

}  // namespace

Lines find_lines(const ImageF& lightness, const ImageU8& mask, const RunControl& control) {
  cv::Mat image(lightness.height(), lightness.width(), CV_32F);
  std::copy(lightness.values().begin(), lightness.values().end(), image.ptr<float>());
  std::vector<FoundLines> found;
  double most = 0.0;
  for (bool dark : {true, false}) {
    for (int reach : kReaches_px) {
      control.throw_if_stopped();
      if (4 * reach >= std::min(image.rows, image.cols)) continue;
      found.push_back(find_lines_of(image, mask, reach, dark));
      if (!found.back().are_structure()) found.back().mass = 0.0;
      most = std::max(most, found.back().mass);
    }
  }
  if (most == 0.0) return {};
  const auto best =
      std::find_if(found.begin(), found.end(), [&](const FoundLines& f) { return f.mass >= kEnough * most; });
  return std::move(best->lines);
}

}  // namespace patinate::transfer
