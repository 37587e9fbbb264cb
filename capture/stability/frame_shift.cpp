#include "capture/stability/frame_shift.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::capture {

namespace {

constexpr double kDetailSigma = 6.0;     ///< Coarser than this is lighting, not detail.
constexpr int kCoarseSide = 128;         ///< Coarse side of PreparedFrame::light.
constexpr double kClipDeviations = 4.0;  ///< Detail beyond so many deviations is a glint.
constexpr double kPeakSigma = 0.9;       ///< Width of the correlation's peak, px.
constexpr double kWhitening = 0.3;       ///< Frequencies weaker than this share of the mean count less.
constexpr double kLargestShift = 0.25;   ///< Share of each side.
constexpr int kNumParts = 6;             ///< Along each side.
constexpr double kPartTexture = 0.25;    ///< A part with less than this share of the mean texture has no vote.
constexpr double kFollows = 0.97;        ///< Error at s against error at -s, below which a part follows s.
constexpr double kMinAgreement = 0.7;    ///< Share of blocks that agree with one motion.

/// A rectangle that two frames share, by its corner in each.
struct Overlap {
  int x0, y0, x1, y1, width, height;
};

Overlap overlap_of(const ImageF& image, int shift_x, int shift_y) {
  return {std::max(0, -shift_x),
          std::max(0, -shift_y),
          std::max(0, shift_x),
          std::max(0, shift_y),
          image.width() - std::abs(shift_x),
          image.height() - std::abs(shift_y)};
}

std::vector<double> hann_window(int size) {
  std::vector<double> window;
  for (int i = 0; i < size; ++i) window.push_back(0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (i + 0.5) / size));
  return window;
}

/// Spectrum of a windowed rectangle, padded with 0 to a size that transforms fast.
cv::Mat spectrum(const ImageF& image, int x0, int y0, int width, int height) {
  cv::Mat padded = cv::Mat::zeros(cv::getOptimalDFTSize(height), cv::getOptimalDFTSize(width), CV_64F);
  const std::vector<double> across = hann_window(width), down = hann_window(height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      padded.at<double>(y, x) = static_cast<double>(image.at(x0 + x, y0 + y)) * across[x] * down[y];
    }
  }
  cv::Mat result;
  cv::dft(padded, result, cv::DFT_COMPLEX_OUTPUT, height);
  return result;
}

/// Weight of each frequency of a transform of `size` by the peak's width.
std::vector<double> frequency_gaussian(int size) {
  std::vector<double> weights;
  for (int i = 0; i < size; ++i) {
    const double f = 2.0 * std::numbers::pi * kPeakSigma * (i <= size / 2 ? i : i - size) / size;
    weights.push_back(std::exp(-0.5 * f * f));
  }
  return weights;
}

/// Whitened cross-power spectrum with a Gaussian weight; `sum` is the value its transform has at the shift of equal
/// frames.
cv::Mat whitened_product(const cv::Mat& reference, const cv::Mat& frame, double& sum) {
  cv::Mat product;
  cv::mulSpectrums(frame, reference, product, 0, true);
  double mean = 0.0;
  for (int y = 0; y < product.rows; ++y) {
    for (int x = 0; x < product.cols; ++x) mean += cv::norm(product.at<cv::Vec2d>(y, x));
  }
  mean /= static_cast<double>(product.total());
  sum = 0.0;
  const std::vector<double> across = frequency_gaussian(product.cols), down = frequency_gaussian(product.rows);
  for (int y = 0; y < product.rows; ++y) {
    for (int x = 0; x < product.cols; ++x) {
      const double gaussian = across[x] * down[y];
      cv::Vec2d& value = product.at<cv::Vec2d>(y, x);
      const double size = cv::norm(value);
      const double weight = gaussian / (size + kWhitening * mean + 1e-300);
      sum += weight * size;
      value *= weight;
    }
  }
  return product;
}

/// Offset of a maximum from the middle of three values, [-0.5, 0.5].
double peak_offset(double before, double middle, double after) {
  constexpr double kLeast = 1e-6;  // Share of the median light; keeps logarithms finite.
  const double l = std::log(std::max(before, kLeast * middle)), m = std::log(middle),
               r = std::log(std::max(after, kLeast * middle));
  const double curvature = l - 2.0 * m + r;
  return curvature < 0.0 ? std::clamp(0.5 * (l - r) / curvature, -0.5, 0.5) : 0.0;
}

struct Peak {
  double x, y, height;
};

Peak correlation_peak(const ImageF& reference, const ImageF& frame, const Overlap& part, int limit_x, int limit_y) {
  double sum = 0.0;
  const cv::Mat product = whitened_product(spectrum(reference, part.x0, part.y0, part.width, part.height),
                                           spectrum(frame, part.x1, part.y1, part.width, part.height), sum);
  cv::Mat correlation;
  cv::dft(product, correlation, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT);
  const int rows = correlation.rows, cols = correlation.cols;
  const auto at = [&](int x, int y) { return correlation.at<double>((y + rows) % rows, (x + cols) % cols); };
  int best_x = 0, best_y = 0;
  for (int y = -limit_y; y <= limit_y; ++y) {
    for (int x = -limit_x; x <= limit_x; ++x) {
      if (at(x, y) > at(best_x, best_y)) best_x = x, best_y = y;
    }
  }
  const double height = at(best_x, best_y);
  if (!(height > 0.0) || !(sum > 0.0)) return {0.0, 0.0, 0.0};
  return {best_x + peak_offset(at(best_x - 1, best_y), height, at(best_x + 1, best_y)),
          best_y + peak_offset(at(best_x, best_y - 1), height, at(best_x, best_y + 1)), height / sum};
}

double bilinear(const ImageF& image, double x, double y) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const double fx = x - x0, fy = y - y0;
  const auto at = [&](int i, int j) { return static_cast<double>(image.at(i, j)); };
  return (1 - fy) * ((1 - fx) * at(x0, y0) + fx * at(x0 + 1, y0)) +
         fy * ((1 - fx) * at(x0, y0 + 1) + fx * at(x0 + 1, y0 + 1));
}

/// Votes for and against a shift in one part of the picture.
struct PartErrors {
  double texture = 0.0, at_shift = 0.0, at_opposite = 0.0;
  double count = 0.0;
};

PartErrors part_errors(const ImageF& reference, const ImageF& frame, int x_begin, int x_end, int y_begin, int y_end,
                       double sx, double sy) {
  PartErrors errors;
  const int margin_x = static_cast<int>(std::ceil(std::abs(sx))) + 1,
            margin_y = static_cast<int>(std::ceil(std::abs(sy))) + 1;
  for (int y = std::max(y_begin, margin_y); y < std::min(y_end, reference.height() - margin_y); ++y) {
    for (int x = std::max(x_begin, margin_x); x < std::min(x_end, reference.width() - margin_x); ++x) {
      const double value = static_cast<double>(reference.at(x, y));
      const double ahead = bilinear(frame, x + sx, y + sy) - value, back = bilinear(frame, x - sx, y - sy) - value;
      errors.texture += value * value;
      errors.at_shift += ahead * ahead;
      errors.at_opposite += back * back;
      errors.count += 1.0;
    }
  }
  return errors;
}

/// Share of the textured parts that follow the shift; 0 when there are none.
double agreement_of(const ImageF& reference, const ImageF& frame, double sx, double sy) {
  std::vector<PartErrors> parts;
  double texture = 0.0, count = 0.0;
  for (int j = 0; j < kNumParts; ++j) {
    for (int i = 0; i < kNumParts; ++i) {
      const int w = reference.width(), h = reference.height();
      parts.push_back(part_errors(reference, frame, i * w / kNumParts, (i + 1) * w / kNumParts, j * h / kNumParts,
                                  (j + 1) * h / kNumParts, sx, sy));
      texture += parts.back().texture;
      count += parts.back().count;
    }
  }
  double num_voting = 0.0, num_following = 0.0;
  for (const PartErrors& part : parts) {
    if (!(part.count > 0.0) || part.texture / part.count < kPartTexture * texture / count) continue;
    num_voting += 1.0;
    num_following += part.at_shift < kFollows * part.at_opposite ? 1.0 : 0.0;
  }
  return num_voting > 0.0 ? num_following / num_voting : 0.0;
}

}  // namespace

const char* shift_status_text(ShiftStatus status) {
  switch (status) {
    case ShiftStatus::Measured:
      return "measured";
    case ShiftStatus::NotGlobal:
      return "not global";
    default:
      return "no texture";
  }
}

PreparedFrame prepare_frame(const ImageF& color, const RunControl& control) {
  const double reduction = std::min(1.0, static_cast<double>(kPreparedSide) / std::max(color.width(), color.height()));
  const int width = std::max(1, static_cast<int>(std::lround(color.width() * reduction)));
  const int height = std::max(1, static_cast<int>(std::lround(color.height() * reduction)));
  const ImageF small = downscale_area(color, width, height, control);
  ImageF light(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) light.at(x, y) = std::sqrt(std::max(0.0f, luminance(small.pixel(x, y))));
  }
  const ImageF mean = gaussian_blur(light, kDetailSigma, control);
  double sum = 0.0;
  for (std::int64_t i = 0; i < light.num_pixels(); ++i) {
    light.data()[i] -= mean.data()[i];
    sum += static_cast<double>(light.data()[i]) * static_cast<double>(light.data()[i]);
  }
  const float limit = static_cast<float>(kClipDeviations * std::sqrt(sum / static_cast<double>(light.num_pixels())));
  for (float& v : light.values()) v = std::clamp(v, -limit, limit);
  const double coarse = std::min(1.0, static_cast<double>(kCoarseSide) / std::max(width, height));
  const int coarse_w = std::max(1, static_cast<int>(std::lround(width * coarse))),
            coarse_h = std::max(1, static_cast<int>(std::lround(height * coarse)));
  return {std::move(light), downscale_area(small, coarse_w, coarse_h, control),
          static_cast<double>(color.width()) / width, static_cast<double>(color.height()) / height};
}

FrameShift measure_shift(const PreparedFrame& reference, const PreparedFrame& frame) {
  const ImageF& a = reference.detail;
  const ImageF& b = frame.detail;
  if (!a.same_size(b)) throw InvalidInput("shift: the frames differ in size");
  FrameShift shift;
  constexpr int kSmallest = 16;  // px; smaller pictures hold no block.
  const auto has_detail = [](const ImageF& image) {
    constexpr double kLeast = 1e-4;  // Far below one code of 8 bits.
    double sum = 0.0;
    for (float v : image.values()) sum += static_cast<double>(v) * static_cast<double>(v);
    return sum > kLeast * kLeast * static_cast<double>(image.num_pixels());
  };
  if (a.width() < kSmallest || a.height() < kSmallest || !has_detail(a) || !has_detail(b)) return shift;

  const int limit_x = static_cast<int>(kLargestShift * a.width()),
            limit_y = static_cast<int>(kLargestShift * a.height());
  const Peak first = correlation_peak(a, b, overlap_of(a, 0, 0), limit_x, limit_y);
  const int whole_x = static_cast<int>(std::lround(first.x)), whole_y = static_cast<int>(std::lround(first.y));
  Peak peak = first;
  if (whole_x != 0 || whole_y != 0) {
    peak = correlation_peak(a, b, overlap_of(a, whole_x, whole_y), 2, 2);
    peak.x += whole_x;
    peak.y += whole_y;
  }
  shift.agreement = agreement_of(a, b, peak.x, peak.y);
  shift.peak = peak.height;
  shift.x = peak.x * reference.scale_x;
  shift.y = peak.y * reference.scale_y;
  shift.status = shift.agreement >= kMinAgreement ? ShiftStatus::Measured : ShiftStatus::NotGlobal;
  return shift;
}

}  // namespace patinate::capture
