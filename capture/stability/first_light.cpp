#include "capture/stability/first_light.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "capture/stability/flat_field.h"
#include "capture/stability/uneven_light.h"
#include "libcommon/core/median.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

/// Shorter sides of the picture over the Gaussian's sigma: scratches of a new plate stay. Chosen on one copper plate.
constexpr double kSidesPerSigma = 40.0;
constexpr int kCompareSide = 128;          ///< Pixels of the longer side where steps are compared.
constexpr int kStepPixels = 3;             ///< 1/40 of it.
constexpr std::size_t kFewestSteps = 200;  ///< A slope of fewer hangs on one stain.

/// A step of log light: of the first photograph, and of a later one.
struct LightStep {
  double first, later;
};

/// The slope through 0 with the least absolute deviations: the median of later / first, weighted by |first|.
double slope_of(const std::vector<LightStep>& steps) {
  std::vector<std::pair<double, double>> slopes;  // with weights
  double sum = 0.0;
  for (const LightStep& step : steps) {
    if (step.first == 0.0) continue;  // Even, or outside the mask.
    slopes.emplace_back(step.later / step.first, std::abs(step.first));
    sum += std::abs(step.first);
  }
  std::sort(slopes.begin(), slopes.end());
  double below = 0.0;
  for (const auto& [slope, weight] : slopes) {
    below += weight;
    if (2.0 * below >= sum) return slope;
  }
  return 1.0;  // The first photograph was even.
}

std::vector<LightStep> steps_between(const ImageF& later, const ImageF& gain, int channel) {
  std::vector<LightStep> steps;
  const auto add = [&](int x, int y, int from_x, int from_y) {
    const float from = later.at(from_x, from_y, channel), to = later.at(x, y, channel);
    if (std::min(from, to) <= kBlackField || std::max(from, to) >= kWhiteField) return;
    const auto log_of = [](float a, float b) { return std::log(static_cast<double>(a) / static_cast<double>(b)); };
    steps.push_back({log_of(gain.at(from_x, from_y, channel), gain.at(x, y, channel)), log_of(to, from)});
  };
  for (int y = 0; y < later.height(); ++y) {
    for (int x = 0; x < later.width(); ++x) {
      if (x >= kStepPixels) add(x, y, x - kStepPixels, y);
      if (y >= kStepPixels) add(x, y, x, y - kStepPixels);
    }
  }
  return steps;
}

void check_sizes(const ImageF& image, const ImageF& gain) {
  if (image.channels() != 3 || gain.channels() != 3 || !image.same_size(gain))
    throw InvalidInput("flat field: the gain and the photograph differ in size");
}

}  // namespace

ImageF first_light_gain(const ImageF& first, const ImageU8& mask, const RunControl& control) {
  ImageF gain = gaussian_blur(first, std::min(first.width(), first.height()) / kSidesPerSigma, control);
  std::vector<bool> is_inside;
  for (int y = 0; y < first.height(); ++y) {
    for (int x = 0; x < first.width(); ++x)
      is_inside.push_back(has_whole_pixel(mask, x, y, first.width(), first.height()));
  }
  for (std::int64_t c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (std::int64_t i = 0; i < gain.num_pixels(); ++i) {
      if (is_inside[i]) values.push_back(gain.data()[3 * i + c]);
    }
    const auto middle = static_cast<double>(median(std::move(values)));
    if (!(middle > 0.0)) throw InvalidInput("flat field: most of the first photograph is black, or outside the mask");
    for (std::int64_t i = 0; i < gain.num_pixels(); ++i) {
      float& value = gain.data()[3 * i + c];
      value = is_inside[i] ? bounded_gain(middle, static_cast<double>(value)) : 1.0f;
    }
  }
  return gain;
}

double light_ratio(const ImageF& gain) {
  double ratio = 1.0;
  for (std::int64_t c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (std::int64_t i = 0; i < gain.num_pixels(); ++i) values.push_back(gain.data()[3 * i + c]);
    const double last = static_cast<double>(values.size() - 1);
    const float dark = value_at_rank(values, static_cast<std::size_t>(kLeftOutEnd * last));
    const float bright = value_at_rank(values, static_cast<std::size_t>((1.0 - kLeftOutEnd) * last));
    ratio = std::max(ratio, static_cast<double>(bright / dark));
  }
  return ratio;
}

std::array<double, 3> remaining_first_light(const ImageF& frame, const ImageF& gain) {
  check_sizes(frame, gain);
  if (light_ratio(gain) < kEvenFirstLight) return {};
  const double factor = std::min(1.0, static_cast<double>(kCompareSide) / std::max(frame.width(), frame.height()));
  const auto scaled = [&](int size) { return std::max(1, static_cast<int>(std::lround(size * factor))); };
  const ImageF later = downscale_area(frame, scaled(frame.width()), scaled(frame.height()));
  const ImageF low = downscale_area(gain, later.width(), later.height());
  std::array<double, 3> shares{1.0, 1.0, 1.0};
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<LightStep> steps = steps_between(later, low, static_cast<int>(c));
    if (steps.size() >= kFewestSteps) shares[c] = std::clamp(slope_of(steps), 0.0, 1.0);
  }
  return shares;
}

void apply_first_light_gain(ImageF& image, const ImageF& gain, const std::array<double, 3>& shares) {
  check_sizes(image, gain);
  for (std::int64_t i = 0; i < 3 * image.num_pixels(); ++i) {
    const double factor = static_cast<double>(gain.data()[i]);
    image.data()[i] *= static_cast<float>(std::pow(factor, shares[i % 3]));
  }
}

}  // namespace patinate::capture
