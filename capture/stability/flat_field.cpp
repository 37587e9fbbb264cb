#include "capture/stability/flat_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "capture/stability/light_polynomial.h"
#include "libcommon/core/median.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::capture {

namespace {

constexpr int kMaxFittedFrames = 32;   ///< See docs/algorithms/flat_field.md.
constexpr double kLargestGain = 50.0;  ///< More would be noise.
constexpr int kFitSide = 128;          ///< Pixels of the longer side at which the fall-off is fitted.

/// Log luminance of a few frames at low resolution; NaN where black or saturated.
std::vector<std::vector<double>> read_logs(int num_frames, const std::function<ImageF(int)>& read_frame, int& width,
                                           int& height, int& low_w, int& low_h, const RunControl& control) {
  const int count = std::min(num_frames, kMaxFittedFrames);
  std::vector<std::vector<double>> logs;
  for (int k = 0; k < count; ++k) {
    control.throw_if_stopped();
    const ImageF frame =
        read_frame(count == 1 ? 0 : static_cast<int>(std::int64_t{k} * (num_frames - 1) / (count - 1)));
    width = frame.width();
    height = frame.height();
    const double factor = std::min(1.0, static_cast<double>(kFitSide) / std::max(width, height));
    low_w = std::max(1, static_cast<int>(std::lround(width * factor)));
    low_h = std::max(1, static_cast<int>(std::lround(height * factor)));
    const ImageF low = downscale_area(frame, low_w, low_h);
    std::vector<double> values;
    for (int y = 0; y < low_h; ++y) {
      for (int x = 0; x < low_w; ++x) {
        const float light = luminance(low.pixel(x, y));
        values.push_back(light > kBlackField && light < kWhiteField ? std::log(static_cast<double>(light))
                                                                    : std::nan(""));
      }
    }
    logs.push_back(std::move(values));
    control.report(0.9 * (k + 1) / count);
  }
  return logs;
}

/// The mean inside over the light, everywhere.
ImageF gain_of(const Eigen::VectorXd& coefficients, int order, int width, int height, const ImageU8& mask,
               const RunControl& control) {
  ImageF gain(width, height);
  double mean = 0.0, num_inside = 0.0;
  std::array<float, 2> range{std::numeric_limits<float>::max(), 0.0f};  // Range of the light inside.
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double light =
          std::exp(coefficients.dot(monomials(2.0 * (x + 0.5) / width - 1.0, 2.0 * (y + 0.5) / height - 1.0, order)));
      gain.at(x, y) = static_cast<float>(std::min(light, 1e30));
      if (!has_whole_pixel(mask, x, y, width, height)) continue;
      mean += light;
      num_inside += 1.0;
      range = {std::min(range[0], gain.at(x, y)), std::max(range[1], gain.at(x, y))};
    }
  }
  if (!(num_inside > 0.0)) throw InvalidInput("flat field: no pixel is wholly inside the mask");
  mean /= num_inside;
  for (float& v : gain.values()) v = bounded_gain(mean, static_cast<double>(std::clamp(v, range[0], range[1])));
  control.report(1.0);
  return gain;
}

}  // namespace

bool has_whole_pixel(const ImageU8& mask, int x, int y, int width, int height) {
  if (mask.empty()) return true;
  const auto first = [](int at, int size, int mask_size) {
    return static_cast<int>(std::int64_t{at} * mask_size / size);
  };
  const auto last = [](int at, int size, int mask_size) {
    return static_cast<int>(((at + 1) * std::int64_t{mask_size} - 1) / size);
  };
  for (int v = first(y, height, mask.height()); v <= last(y, height, mask.height()); ++v) {
    for (int u = first(x, width, mask.width()); u <= last(x, width, mask.width()); ++u)
      if (mask.at(u, v) == 0) return false;
  }
  return true;
}

float bounded_gain(double mean, double light) {
  return static_cast<float>(std::clamp(mean / std::max(light, 1e-30), 1.0 / kLargestGain, kLargestGain));
}

void describe(OptionVisitor& v, FlatFieldOptions& o) {
  v.visit({"flat_field_order", "Degree of the polynomial that stands for the lamp's fall-off, when it is estimated", "",
           between(1, 6)},
          o.order);
  v.visit({"flat_field_smoothing",
           "Standard deviation of the Gaussian that smooths the photograph of a uniform surface, as a share of its "
           "shorter side",
           "", between(0, 0.5)},
          o.smoothing_share);
}

ImageF flat_field_from_image(const ImageF& light, const FlatFieldOptions& options, const RunControl& control) {
  check_ranges(options);
  ImageF gain = gaussian_blur(light, options.smoothing_share * std::min(light.width(), light.height()), control);
  for (int c = 0; c < gain.channels(); ++c) {
    double mean = 0.0;
    for (std::int64_t i = 0; i < gain.num_pixels(); ++i)
      mean += static_cast<double>(gain.data()[i * gain.channels() + c]);
    mean /= static_cast<double>(gain.num_pixels());
    if (!(mean > 0.0)) throw InvalidInput("flat field: the photograph is black");
    for (std::int64_t i = 0; i < gain.num_pixels(); ++i) {
      float& value = gain.data()[i * gain.channels() + c];
      value = bounded_gain(mean, static_cast<double>(value));
    }
  }
  return gain;
}

ImageF estimate_flat_field(int num_frames, const std::function<ImageF(int)>& read_frame, const ImageU8& mask,
                           const FlatFieldOptions& options, const RunControl& control) {
  check_ranges(options);
  if (num_frames < 1) throw InvalidInput("flat field: there are no frames");
  int width = 0, height = 0, low_w = 0, low_h = 0;
  const auto logs = read_logs(num_frames, read_frame, width, height, low_w, low_h, control);
  std::vector<Eigen::VectorXd> terms;
  std::vector<double> values;
  std::size_t num_inside = 0;
  for (int y = 0; y < low_h; ++y) {
    for (int x = 0; x < low_w; ++x) {
      if (!has_whole_pixel(mask, x, y, low_w, low_h)) continue;
      ++num_inside;
      std::vector<double> course;
      for (const auto& log : logs) {
        const double value =
            log[static_cast<std::size_t>(y) * static_cast<std::size_t>(low_w) + static_cast<std::size_t>(x)];
        if (!std::isnan(value)) course.push_back(value);
      }
      if (2 * course.size() <= logs.size()) continue;
      terms.push_back(monomials(2.0 * (x + 0.5) / low_w - 1.0, 2.0 * (y + 0.5) / low_h - 1.0, options.order));
      values.push_back(median(course));
    }
  }
  if (num_inside == 0) throw InvalidInput("flat field: no part of the picture is wholly inside the mask");
  if (2 * values.size() < num_inside) {
    throw InvalidInput(
        "flat field: more than half of the picture is black or saturated; give a photograph of a uniform surface, or a "
        "roi");
  }
  if (values.size() < static_cast<std::size_t>(terms.front().size())) {
    throw InvalidInput(
        "flat field: too little of the picture is inside the mask; give a photograph of a uniform "
        "surface, or a lower --flat-field-order");
  }
  return gain_of(fit_polynomial(terms, values), options.order, width, height, mask, control);
}

void apply_gain(ImageF& image, const ImageF& gain) {
  if (!image.same_size(gain) || (gain.channels() != 1 && gain.channels() != image.channels())) {
    throw InvalidInput("flat field: the gain and the photograph differ in size");
  }
  for (std::int64_t i = 0; i < image.num_pixels(); ++i) {
    for (int c = 0; c < image.channels(); ++c) {
      image.data()[i * image.channels() + c] *= gain.data()[gain.channels() == 1 ? i : i * gain.channels() + c];
    }
  }
}

}  // namespace patinate::capture
