#include "capture/stability/uneven_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "capture/stability/light_polynomial.h"
#include "libcommon/core/median.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::capture {

namespace {

constexpr int kOrder = 4;                     ///< Order as FlatFieldOptions has it.
constexpr int kEvidenceOrder = 2;             ///< Where fewer pixels are compared: a higher degree follows the surface.
constexpr double kLeastUsed = 0.25;           ///< Share of what is inside the mask.
constexpr std::ptrdiff_t kFewestUsed = 60;    ///< Pixels: four for each of the 15 coefficients of the fourth degree.
constexpr double kReplaced = 0.2;             ///< Change of a channel's logarithm that makes a pixel another surface.
constexpr double kMinReplaced = 0.25;         ///< Share of what is inside, for evidence.
constexpr double kSameDetail = 0.5;           ///< Correlation from which on the old surface shines through.
constexpr double kMinDetail = 0.02;           ///< Standard deviation of logarithms: twice a photograph's noise.
constexpr double kStayed = 0.7, kWent = 0.5;  ///< Share of common variance (docs/algorithms/flat_field.md).
constexpr double kUncolored = 0.8;            ///< Red and blue agree (docs/algorithms/flat_field.md).
constexpr double kMinExplained = 0.3;         ///< Share of the variance (docs/algorithms/flat_field.md).

/// Values of the pixels in order; NaN where not known.
using Field = std::vector<double>;
/// Logarithms of red, green, blue and luminance.
using Logs = std::array<Field, 4>;
constexpr std::size_t kRed = 0, kBlue = 2, kLuminance = 3;

Logs logs_of(const ImageF& frame, const ImageU8& mask) {
  Logs logs;
  for (std::int64_t i = 0; i < frame.num_pixels(); ++i) {
    const std::span<const float> pixel(frame.data() + 3 * i, 3);
    const auto [low, high] = std::minmax_element(pixel.begin(), pixel.end());
    const bool is_used = *low > kNearBlack && *high < kNearWhite && (mask.empty() || mask.data()[i] != 0);
    for (std::size_t c = 0; c < logs.size(); ++c) {
      const double light = static_cast<double>(c == kLuminance ? luminance(pixel) : pixel[c]);
      logs[c].push_back(is_used ? std::log(light) : std::nan(""));
    }
  }
  return logs;
}

/// Each pixel's median over frames [begin, end), where more than half of them know it.
Field middle(const std::vector<Logs>& frames, std::size_t channel, std::size_t begin, std::size_t end) {
  Field result;
  for (std::size_t i = 0; i < frames.front()[channel].size(); ++i) {
    std::vector<double> course;
    for (std::size_t k = begin; k < end; ++k) {
      if (!std::isnan(frames[k][channel][i])) course.push_back(frames[k][channel][i]);
    }
    result.push_back(2 * course.size() > end - begin ? median(std::move(course)) : std::nan(""));
  }
  return result;
}

/// The logarithms of all frames, and how many pixels lie inside the mask: shares are of these.
struct LogSeries {
  std::vector<Logs> frames;
  int width = 0;
  std::ptrdiff_t num_inside = 0;

  /// Whether a field knows this share of what is inside, and enough pixels for a fit.
  [[nodiscard]] bool is_known(const Field& field, double least_share) const {
    const auto known = std::count_if(field.begin(), field.end(), [](double v) { return !std::isnan(v); });
    return known >= kFewestUsed && static_cast<double>(known) >= least_share * static_cast<double>(num_inside);
  }
};

struct Split {
  Field slow, detail;  ///< The polynomial, and what it leaves; NaN where the field is.
};

/// Columns and rows of what a field knows.
struct Extent {
  int left = std::numeric_limits<int>::max(), top = left, right = -1, bottom = -1;
};

Extent extent_of(const Field& field, int width) {
  Extent e;
  for (std::size_t i = 0; i < field.size(); ++i) {
    if (std::isnan(field[i])) continue;
    const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
    e = {std::min(e.left, x), std::min(e.top, y), std::max(e.right, x), std::max(e.bottom, y)};
  }
  return e;
}

/// The polynomial's coordinates run from -1 to 1 over what the field knows: its terms would be nearly dependent where
/// that is a small part of the picture.
Split split_field(const Field& field, int width, int order) {
  const Extent e = extent_of(field, width);
  std::vector<Eigen::VectorXd> terms(field.size()), used;
  std::vector<double> values;
  for (std::size_t i = 0; i < field.size(); ++i) {
    if (std::isnan(field[i])) continue;
    const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
    terms[i] = monomials(2.0 * (x - e.left + 0.5) / (e.right - e.left + 1) - 1.0,
                         2.0 * (y - e.top + 0.5) / (e.bottom - e.top + 1) - 1.0, order);
    used.push_back(terms[i]);
    values.push_back(field[i]);
  }
  const Eigen::VectorXd coefficients = fit_polynomial(used, values);
  Split result{Field(field.size(), std::nan("")), Field(field.size(), std::nan(""))};
  for (std::size_t i = 0; i < field.size(); ++i) {
    if (std::isnan(field[i])) continue;
    result.slow[i] = coefficients.dot(terms[i]);
    result.detail[i] = field[i] - result.slow[i];
  }
  return result;
}

/// Variances of two fields and their covariance, where both are known.
struct Spread {
  double a = 0.0, b = 0.0, both = 0.0;

  /// 1 - variance of the difference / sum of the variances: 1 = equal, 0 = unrelated.
  [[nodiscard]] double common() const { return 2.0 * both / std::max(a + b, 1e-12); }
  [[nodiscard]] double correlation() const { return both / std::sqrt(std::max(a * b, 1e-24)); }
};

Spread spread_of(const Field& a, const Field& b) {
  double n = 0.0, sum_a = 0.0, sum_b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i]) || std::isnan(b[i])) continue;
    n += 1.0;
    sum_a += a[i];
    sum_b += b[i];
    aa += a[i] * a[i];
    bb += b[i] * b[i];
    ab += a[i] * b[i];
  }
  if (!(n > 0.0)) return {};
  return {aa / n - sum_a * sum_a / (n * n), bb / n - sum_b * sum_b / (n * n), ab / n - sum_a * sum_b / (n * n)};
}

double field_ratio(const Field& slow) {
  std::vector<double> values;
  std::copy_if(slow.begin(), slow.end(), std::back_inserter(values), [](double v) { return !std::isnan(v); });
  const double last = static_cast<double>(values.size() - 1);
  const double low = value_at_rank(values, static_cast<std::size_t>(kLeftOutEnd * last));
  return std::exp(value_at_rank(values, static_cast<std::size_t>((1.0 - kLeftOutEnd) * last)) - low);
}

/// The first and the last third of the frames where the surface was replaced in between; NaN elsewhere.
struct Replaced {
  Field before, after;
};

Replaced replaced_parts(const std::vector<Logs>& frames) {
  const std::size_t n = frames.size(), third = std::max<std::size_t>(1, n / 3);
  std::array<Field, 4> before, after;
  for (std::size_t c = 0; c < before.size(); ++c) {
    before[c] = middle(frames, c, 0, third);
    after[c] = middle(frames, c, n - third, n);
  }
  Replaced parts{before[kLuminance], after[kLuminance]};
  for (std::size_t i = 0; i < parts.before.size(); ++i) {
    double change = 0.0;
    for (std::size_t c = 0; c < kLuminance; ++c) change = std::max(change, std::abs(after[c][i] - before[c][i]));
    if (!(change > kReplaced)) parts.before[i] = parts.after[i] = std::nan("");
    if (std::isnan(parts.before[i]) || std::isnan(parts.after[i])) parts.before[i] = parts.after[i] = std::nan("");
  }
  return parts;
}

/// Without a surface that was replaced: a fall-off of light has no color, and is more than the picture's own variation.
LightEvidence judge_by_shape(const std::vector<Logs>& frames, const Split& whole, int width) {
  std::vector<double> sizes;
  for (double d : whole.detail) {
    if (!std::isnan(d)) sizes.push_back(std::abs(d));
  }
  const double detail = kSigmaOfMad * median(std::move(sizes)), slow = spread_of(whole.slow, whole.slow).a;
  const double explained = slow / std::max(slow + detail * detail, 1e-12);
  const Split red = split_field(middle(frames, kRed, 0, frames.size()), width, kOrder);
  const Split blue = split_field(middle(frames, kBlue, 0, frames.size()), width, kOrder);
  const bool is_uncolored = spread_of(red.slow, blue.slow).common() >= kUncolored;
  return is_uncolored && explained >= kMinExplained ? LightEvidence::Possible : LightEvidence::None;
}

LightEvidence judge(const LogSeries& series, const Split& whole) {
  const Replaced parts = replaced_parts(series.frames);
  if (series.frames.size() < 2 || !series.is_known(parts.before, kMinReplaced))
    return judge_by_shape(series.frames, whole, series.width);
  const Split before = split_field(parts.before, series.width, kEvidenceOrder),
              after = split_field(parts.after, series.width, kEvidenceOrder);
  const double common = spread_of(before.slow, after.slow).common();
  if (common < kWent) return LightEvidence::None;
  const bool is_new = spread_of(before.detail, after.detail).correlation() <= kSameDetail;
  return is_new && common >= kStayed ? LightEvidence::Clear : LightEvidence::Possible;
}

LogSeries checked_series(const std::vector<ImageF>& frames, const ImageU8& mask) {
  if (frames.empty()) throw InvalidInput("uneven light: there are no frames");
  LogSeries series{.frames = {}, .width = frames.front().width(), .num_inside = frames.front().num_pixels()};
  for (const ImageF& frame : frames) {
    if (!frame.same_size(frames.front()) || (!mask.empty() && !frame.same_size(mask)) || frame.channels() != 3)
      throw InvalidInput("uneven light: the frames differ in size");
    series.frames.push_back(logs_of(frame, mask));
  }
  if (!mask.empty())
    series.num_inside =
        std::count_if(mask.values().begin(), mask.values().end(), [](std::uint8_t v) { return v != 0; });
  return series;
}

}  // namespace

bool is_surface_replaced(const std::vector<ImageF>& frames, const ImageU8& mask) {
  const LogSeries series = checked_series(frames, mask);
  const Replaced parts = replaced_parts(series.frames);
  if (!series.is_known(parts.before, kMinReplaced)) return false;
  const Split before = split_field(parts.before, series.width, kEvidenceOrder),
              after = split_field(parts.after, series.width, kEvidenceOrder);
  const Spread detail = spread_of(before.detail, after.detail);
  // Where there is no detail to be gone, a smooth surface may have become brighter or darker as a whole.
  return std::min(detail.a, detail.b) >= kMinDetail * kMinDetail && detail.correlation() <= kSameDetail;
}

UnevenLight find_uneven_light(const std::vector<ImageF>& frames, const ImageU8& mask) {
  const LogSeries series = checked_series(frames, mask);
  const Field course = middle(series.frames, kLuminance, 0, series.frames.size());
  if (!series.is_known(course, kLeastUsed)) return {};
  const Split whole = split_field(course, series.width, kOrder);
  UnevenLight result{field_ratio(whole.slow), LightEvidence::None};
  if (result.ratio >= kUnevenRatio) result.evidence = judge(series, whole);
  return result;
}

}  // namespace patinate::capture
