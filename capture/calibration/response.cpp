#include "capture/calibration/response.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "libcommon/core/text.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr int kNumCodes = 256;  ///< Codes of 8 bits.

double hat(int code) { return code <= 127 ? code + 1.0 : 256.0 - code; }

void check_photos(const std::vector<ImageU8>& photos, const std::vector<double>& exposures) {
  if (photos.size() < 2) throw InvalidInput("a response needs at least two photographs");
  if (photos.size() != exposures.size()) throw InvalidInput("every photograph needs an exposure");
  double low = exposures[0], high = exposures[0];
  for (const double e : exposures) {
    if (!(e > 0) || !std::isfinite(e)) throw InvalidInput("exposures must be > 0");
    low = std::min(low, e), high = std::max(high, e);
  }
  if (!(high > 1.05 * low))
    throw InvalidInput("the exposures are all alike; expected a series, e.g. 1/60, 1/30, 1/15 s");
  for (const ImageU8& photo : photos) {
    if (photo.empty()) throw InvalidInput("a photograph is empty");
    if (!photo.same_size(photos[0]) || photo.channels() != photos[0].channels()) {
      throw InvalidInput("the photographs differ in size: " + size_text(photo.width(), photo.height()) + " and " +
                         size_text(photos[0].width(), photos[0].height()));
    }
  }
}

/// Values that change over the series, evenly from the darkest to the brightest, so that every code has its share.
std::vector<std::size_t> chosen_values(const std::vector<ImageU8>& photos, int count) {
  std::vector<std::pair<int, std::size_t>> candidates;
  const std::size_t size = photos[0].values().size();
  const std::size_t step = std::max<std::size_t>(1, size / 200'000);
  for (std::size_t i = 0; i < size; i += step) {
    int low = 255, high = 0, sum = 0;
    for (const ImageU8& photo : photos) {
      const int code = photo.values()[i];
      low = std::min(low, code), high = std::max(high, code), sum += code;
    }
    if (high - low >= 4) candidates.emplace_back(sum, i);
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<std::size_t> chosen;
  for (int k = 0; k < count && !candidates.empty(); ++k) {
    const double span = candidates.back().first - candidates.front().first;
    const int wanted = candidates.front().first + static_cast<int>(std::lround(span * (k + 0.5) / count));
    const auto at = std::lower_bound(candidates.begin(), candidates.end(), std::pair<int, std::size_t>(wanted, 0));
    const std::size_t index = at == candidates.end() ? candidates.back().second : at->second;
    if (chosen.empty() || chosen.back() != index) chosen.push_back(index);
  }
  return chosen;
}

double rms_against(const ResponseCurve& curve, const Response& response) {
  // Both scaled to meet in the least squares, since a series has no absolute scale; the ends, which few pixels fix,
  // weigh less.
  double ab = 0.0, bb = 0.0, aa = 0.0, weights = 0.0;
  for (int code = curve.low_code; code <= curve.high_code; ++code) {
    const double a = curve.linear[code],
                 b = static_cast<double>(response.linear_from_code(static_cast<float>(code) / 255.0f));
    const double w = hat(code);
    ab += w * a * b, bb += w * b * b, aa += w * a * a, weights += w;
  }
  return bb > 0 ? std::sqrt(std::max(0.0, aa - ab * ab / bb) / weights) : std::numeric_limits<double>::infinity();
}

void find_closest(ResponseCurve& curve) {
  curve.closest = {.kind = Response::Kind::Srgb};
  curve.closest_rms = rms_against(curve, curve.closest);
  const auto consider = [&](const Response& response, double advantage) {
    const double rms = rms_against(curve, response);
    if (rms < advantage * curve.closest_rms) curve.closest = response, curve.closest_rms = rms;
  };
  consider({.kind = Response::Kind::Linear}, 1.0);
  double low = 0.3, high = 4.0;
  for (int i = 0; i < 60; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    const bool is_lower = rms_against(curve, {.kind = Response::Kind::Gamma, .gamma = a}) <
                          rms_against(curve, {.kind = Response::Kind::Gamma, .gamma = b});
    (is_lower ? high : low) = is_lower ? b : a;
  }
  // A free exponent fits a little better than the curve that is meant.
  consider({.kind = Response::Kind::Gamma, .gamma = 0.5 * (low + high)}, 0.7);
}

}  // namespace

void describe(OptionVisitor& v, ResponseOptions& o) {
  v.visit({"smoothness", "weight of the response curve's second derivative", "", above(0)}, o.smoothness);
  v.visit({"num_pixels", "pixels that are compared", "", between(20, 2000)}, o.num_pixels);
}

ResponseCurve recover_response(const std::vector<ImageU8>& photos, const std::vector<double>& exposures,
                               const ResponseOptions& options) {
  check_ranges(options);
  check_photos(photos, exposures);
  const std::vector<std::size_t> chosen = chosen_values(photos, options.num_pixels);
  if (chosen.size() < 10)
    throw InvalidInput(
        "the photographs do not change with the exposure; expected some that are neither black nor white");
  // Unknowns: log linear of each code, then log exposure of each pixel.
  const auto n = static_cast<Eigen::Index>(kNumCodes + chosen.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  std::array<double, kNumCodes> seen{};
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const auto pixel = static_cast<Eigen::Index>(kNumCodes + i);
    for (std::size_t k = 0; k < photos.size(); ++k) {
      const int code = photos[k].values()[chosen[i]];
      if (code == 0 || code == 255) continue;  // Black and white codes stand for a range.
      const double w2 = hat(code) * hat(code) / (128.0 * 128.0), t = std::log(exposures[k]);
      seen[code] += 1.0;
      normal(code, code) += w2, normal(pixel, pixel) += w2;
      normal(code, pixel) -= w2, normal(pixel, code) -= w2;
      right[code] += w2 * t, right[pixel] -= w2 * t;
    }
    normal(pixel, pixel) += 1e-12;
  }
  normal(128, 128) += 1.0;  // log linear of code 128 is 0; the scale is free.
  for (int code = 1; code + 1 < kNumCodes; ++code) {
    const double w2 = options.smoothness * hat(code) * hat(code) / (128.0 * 128.0);
    const double d[3] = {1.0, -2.0, 1.0};
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) normal(code - 1 + a, code - 1 + b) += w2 * d[a] * d[b];
    }
  }
  const Eigen::VectorXd g = solve_ldlt(normal, right);
  ResponseCurve curve;
  curve.low_code = 255, curve.high_code = 0;
  for (int code = 0; code < kNumCodes; ++code) {
    if (seen[code] > 0)
      curve.low_code = std::min(curve.low_code, code), curve.high_code = std::max(curve.high_code, code);
  }
  if (!g.allFinite() || curve.high_code <= curve.low_code)
    throw InvalidInput("the exposure series determines no response");
  for (int code = 0; code < kNumCodes; ++code) curve.linear[code] = std::exp(g[code] - g[kNumCodes - 1]);
  bool is_rising = true;
  for (std::size_t code = 1; code < kNumCodes; ++code) {
    if (static_cast<int>(code) > curve.low_code && static_cast<int>(code) <= curve.high_code)
      is_rising = is_rising && curve.linear[code] > curve.linear[code - 1];
    curve.linear[code] = std::max(curve.linear[code], curve.linear[code - 1]);
  }
  curve.linear[0] = 0.0;
  find_closest(curve);
  // Codes between the lowest and the highest observed one; fewer do not show the curve.
  constexpr int kMinCovered = 150;
  curve.status = is_rising && curve.high_code - curve.low_code >= kMinCovered ? ResponseStatus::Converged
                                                                              : ResponseStatus::Undetermined;
  return curve;
}

}  // namespace patinate::capture
