#include "transfer/exemplar/lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "transfer/exemplar/matrices.h"

namespace patinate::transfer {

namespace {

/// Half sides of closing squares of 5, 9, 17 and 33 px (docs/algorithms/refinement.md).
constexpr std::array kReaches_px{2, 4, 8, 16};
constexpr double kMinContrast = 3.0;               // L*. Less is noise, or hardly seen.
constexpr double kLowOfHigh = 0.4;                 // Threshold of all lines, as a share of Otsu's.
constexpr double kMinElongation = 30.0;            // Length over width: of a network it is the whole length.
constexpr double kMinElongated = 0.6;              // Share of what is found that must be lines.
constexpr double kMinShare = 0.005;                // Share of the surface.
constexpr double kMaxShare = 0.25, kRare = 0.125;  // More than an eighth must stand out clearly.
constexpr double kDensest = 0.35;                  // Crackle glazes cover 24 to 35 %; what covers more is grain.
constexpr int kMaxBins = 400;                      // Bins of a quarter L*.
constexpr int kSegment = 17, kNumDirections = 12;  // Pixels at the smallest reach; a line is straight as far.
constexpr double kAlong = 2.0;                     // Half of a square around may be lines.
constexpr double kEnough = 0.8;                    // Share of what the best square finds.

/// Depth that the square fills: how much darker (or brighter) than its surroundings a pixel is. Exact in floats.
cv::Mat filled(const cv::Mat& lightness, int reach, bool dark) {
  cv::Mat smooth;
  const cv::Mat square = cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U);
  cv::morphologyEx(lightness, smooth, dark ? cv::MORPH_CLOSE : cv::MORPH_OPEN, square);
  return dark ? smooth - lightness : lightness - smooth;
}

/// Offsets of the pixels of a segment of kSegment pixels through the middle, which comes first. @param direction  Of
/// kNumDirections over half a turn; none of them meets the middle between two pixels, so that rounding is safe.
std::vector<cv::Point> segment(int direction) {
  std::vector<cv::Point> offsets;
  const double angle = 3.14159265358979323846 * direction / kNumDirections;
  const double step = 1.0 / std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
  for (double d = 0.0; d <= kSegment / 2.0; d += step) {
    const cv::Point p(static_cast<int>(std::floor(d * std::cos(angle) + 0.5)),
                      static_cast<int>(std::floor(d * std::sin(angle) + 0.5)));
    offsets.push_back(p);
    if (d > 0.0) offsets.push_back(-p);
  }
  return offsets;
}

/// By how much the mean along the best segment through a pixel exceeds the mean around it: what is filled by a line
/// goes on along it, grain does not. L*, from integers of 1/64. Symmetric at the picture's border.
cv::Mat along_lines(const cv::Mat& fill, const RunControl& control) {
  constexpr int kMargin = kSegment / 2 + 1;  // A segment and its window stay inside the padded picture.
  cv::Mat scaled, padded, sums, best(fill.size(), CV_32S, cv::Scalar(0));
  fill.convertTo(scaled, CV_16S, 64.0);
  cv::copyMakeBorder(scaled, padded, kMargin, kMargin, kMargin, kMargin, cv::BORDER_REFLECT);
  for (int direction = 0; direction < kNumDirections; ++direction) {
    control.throw_if_stopped();
    const std::vector<cv::Point> offsets = segment(direction);
    std::vector<std::int32_t> row(static_cast<std::size_t>(fill.cols));
    for (int y = 0; y < fill.rows; ++y) {
      std::fill(row.begin(), row.end(), 0);
      for (const cv::Point& o : offsets) {
        const std::int16_t* from = padded.ptr<std::int16_t>(y + kMargin + o.y) + kMargin + o.x;
        for (int x = 0; x < fill.cols; ++x) row[x] += from[x];
      }
      std::int32_t* out = best.ptr<std::int32_t>(y);
      const auto count = static_cast<std::int32_t>(offsets.size());
      for (int x = 0; x < fill.cols; ++x) out[x] = std::max(out[x], row[x] / count);
    }
  }
  // Around it: a square as wide as the segment, summed exactly.
  cv::integral(padded, sums, CV_64F);
  cv::Mat result(fill.size(), CV_32F);
  constexpr int kHalf = kSegment / 2, kSide = 2 * kHalf + 1;
  for (int y = 0; y < fill.rows; ++y) {
    for (int x = 0; x < fill.cols; ++x) {
      const int x0 = x + kMargin - kHalf, y0 = y + kMargin - kHalf;
      const double around = (sums.at<double>(y0 + kSide, x0 + kSide) - sums.at<double>(y0, x0 + kSide) -
                             sums.at<double>(y0 + kSide, x0) + sums.at<double>(y0, x0)) /
                            (kSide * kSide);
      result.at<float>(y, x) = static_cast<float>(std::max(0.0, (best.at<std::int32_t>(y, x) - around) / 64.0));
    }
  }
  return result;
}

/// Response of a square, less where it does not go on along a line.
cv::Mat line_response(const cv::Mat& lightness, int reach, bool dark, const RunControl& control) {
  cv::Mat fill = filled(lightness, reach, dark), small = fill, along;
  const int factor = reach / kReaches_px[0];
  if (factor > 1)
    cv::resize(fill, small, cv::Size(std::max(1, fill.cols / factor), std::max(1, fill.rows / factor)), 0, 0,
               cv::INTER_AREA);
  cv::Mat coarse = along_lines(small, control);
  if (factor > 1)
    cv::resize(coarse, along, fill.size(), 0, 0, cv::INTER_NEAREST);
  else
    along = coarse;
  return cv::min(fill, kAlong * along);
}

/// Otsu's of what is filled at all; the low one lies above the noise, which fills every pixel a little.
LineThresholds find_thresholds(const cv::Mat& fill, const ImageU8& mask) {
  std::array<std::int64_t, kMaxBins> counts{};
  std::int64_t total = 0;
  for (int y = 0; y < fill.rows; ++y) {
    for (int x = 0; x < fill.cols; ++x) {
      if (!is_inside(mask, x, y)) continue;
      ++counts[std::clamp(static_cast<int>(fill.at<float>(y, x) * 4.0f), 0, kMaxBins - 1)];
      ++total;
    }
  }
  double sum = 0.0;
  for (int b = 0; b < kMaxBins; ++b) sum += static_cast<double>(counts[b]) * b;
  double below = 0.0, below_sum = 0.0, best = -1.0;
  int high = 0, median = -1;
  for (int b = 0; b + 1 < kMaxBins; ++b) {
    const auto n = static_cast<double>(counts[b]);
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
  return {.low = std::max({kLowOfHigh * high / 4.0, kMinContrast, std::min(noise, high / 4.0)}),
          .high = std::max(high / 4.0, kMinContrast)};
}

/// Lines that one square finds.
struct FoundLines {
  cv::Mat fill, all, strong;
  LineThresholds thresholds;
  bool is_dark = true;
  double share = 0.0;      ///< Share of the pixels inside the mask that are on a line.
  double elongated = 0.0;  ///< Share of what passed the thresholds.
  double mass = 0.0;       ///< Sum of what the square fills on lines.
  double found = 0.0;      ///< Share that passed the thresholds, lines or not.
  [[nodiscard]] bool are_long() const { return elongated >= kMinElongated && share >= kMinShare; }
  [[nodiscard]] bool are_few() const {
    const bool stands_out = thresholds.low < 0.5 * thresholds.high;
    return found <= (stands_out ? kMaxShare : kRare);
  }
};

/// Keeps the connected pieces above the low threshold that reach the high one and are long.
FoundLines find_lines_of(const cv::Mat& lightness, const ImageU8& mask, int reach, bool dark,
                         const RunControl& control) {
  FoundLines lines;
  lines.fill = line_response(lightness, reach, dark, control);
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
    if (is_strong[i] == 0 || area < kMinElongation * width * width) continue;
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
      if (is_kept[label.at<int>(y, x)] == 0) continue;
      lines.all.at<std::uint8_t>(y, x) = 255;
      if (static_cast<double>(lines.fill.at<float>(y, x)) >= lines.thresholds.high)
        lines.strong.at<std::uint8_t>(y, x) = 255;
    }
  }
  return lines;
}

}  // namespace

Lines find_lines(const ImageF& lightness, const ImageU8& mask, const RunControl& control) {
  const cv::Mat image = matrix_of(lightness);
  std::vector<FoundLines> found;
  double most = 0.0, refused = 0.0;
  for (bool dark : {true, false}) {
    for (int reach : kReaches_px) {
      control.throw_if_stopped();
      if (4 * reach >= std::min(image.rows, image.cols)) continue;
      found.push_back(find_lines_of(image, mask, reach, dark, control));
      const FoundLines& last = found.back();
      if (last.are_long() && !last.are_few() && last.share <= kDensest) refused = std::max(refused, last.share);
      if (!last.are_long() || !last.are_few()) found.back().mass = 0.0;
      most = std::max(most, found.back().mass);
    }
  }
  if (most == 0.0) {
    Lines none;
    none.refused_share = refused;
    return none;
  }
  const auto best =
      std::find_if(found.begin(), found.end(), [&](const FoundLines& f) { return f.mass >= kEnough * most; });
  return {.fill = float_image_of(best->fill),
          .all = byte_image_of(best->all),
          .strong = byte_image_of(best->strong),
          .thresholds = best->thresholds,
          .is_dark = best->is_dark,
          .share = best->share};
}

}  // namespace patinate::transfer
