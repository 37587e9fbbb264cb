#include "capture/project/progress_control.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image.h"

namespace patinate::capture {

namespace {

/// Sums up, frame by frame, what the deviations of frames do to progress(p) = sum of w_i min(1, |v_i - v_0| / D), to
/// first order: var = sum_i (w_i s_i)^2 / D^2 along v_i - v_0, and what the first frame, which all are compared with,
/// does to all of them at once. To that comes, squared, by how much noise lengthens distances: without any change they
/// are not 0, and that does not average out. Where |v_i - v_0| is beyond D nothing moves. Deviations of different
/// frames are independent; D is taken as known.
class ProgressDeviation {
 public:
  /// @param first,first_variance  The first frame and its variance, H x W x 3, in sRGB codes of [0, 1].
  /// @param aged_change           D; > 0.
  ProgressDeviation(ImageF first, ImageF first_variance, double aged_change);

  /// @param weight  w_i. @param frame,variance  As the first one's.
  void add(double weight, const ImageF& frame, const ImageF& variance);
  /// H x W x 1.
  [[nodiscard]] ImageF result() const;

 private:
  ImageF first_, first_variance_;
  double aged_change_;
  ImageF own_;         ///< Variance from the frames themselves, of one channel.
  ImageF lengthened_;  ///< Sum of the weighted lengths that are noise.
  ImageF shared_;      ///< Sum of the weighted directions, which the first frame's deviation goes along with.
};

ProgressDeviation::ProgressDeviation(ImageF first, ImageF first_variance, double aged_change)
    : first_(std::move(first)),
      first_variance_(std::move(first_variance)),
      aged_change_(aged_change),
      own_(first_.width(), first_.height()),
      lengthened_(first_.width(), first_.height()),
      shared_(first_.width(), first_.height(), 3) {
  if (!first_.same_size(first_variance_)) throw InvalidInput("progress: frames and their deviations differ in size");
}

void ProgressDeviation::add(double weight, const ImageF& frame, const ImageF& variance) {
  if (!frame.same_size(first_) || !variance.same_size(first_))
    throw InvalidInput("progress: frames and their deviations differ in size");
  for (std::int64_t i = 0; i < frame.num_pixels(); ++i) {
    std::array<double, 3> along{};
    double change = 0.0, spread = 0.0, noise = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      along[c] = static_cast<double>(frame.data()[3 * i + c]) - static_cast<double>(first_.data()[3 * i + c]);
      change += along[c] * along[c];
    }
    change = std::sqrt(change);
    if (!(change > 0.0)) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      along[c] /= change;
      const double variance_c =
          static_cast<double>(variance.data()[3 * i + c]) + static_cast<double>(first_variance_.data()[3 * i + c]);
      spread += along[c] * along[c] * variance_c;
      noise += variance_c;
    }
    // The chance that the change lies below D, where progress follows it.
    const double below = spread > 0.0 ? 0.5 * std::erfc((change - aged_change_) / std::sqrt(2.0 * spread))
                                      : static_cast<double>(change < aged_change_);
    const double gain = below * weight / aged_change_;
    lengthened_.data()[i] += static_cast<float>(gain * (change - std::sqrt(std::max(0.0, change * change - noise))));
    for (std::size_t c = 0; c < 3; ++c) {
      own_.data()[i] +=
          static_cast<float>(gain * gain * along[c] * along[c] * static_cast<double>(variance.data()[3 * i + c]));
      shared_.data()[3 * i + c] += static_cast<float>(gain * along[c]);
    }
  }
}

ImageF ProgressDeviation::result() const {
  ImageF out(first_.width(), first_.height());
  for (std::int64_t i = 0; i < out.num_pixels(); ++i) {
    const double lengthened = static_cast<double>(lengthened_.data()[i]);
    double variance = static_cast<double>(own_.data()[i]) + lengthened * lengthened;
    for (std::int64_t c = 3 * i; c < 3 * i + 3; ++c) {
      variance += static_cast<double>(shared_.data()[c]) * static_cast<double>(shared_.data()[c]) *
                  static_cast<double>(first_variance_.data()[c]);
    }
    out.data()[i] = static_cast<float>(std::sqrt(variance));
  }
  return out;
}

constexpr float kMinChange = 0.02f;      ///< Five 8-bit codes: below, it may be the camera.
constexpr float kMinChangeShare = 0.1f;  ///< Share of the 99th percentile.
constexpr double kAgedRank = 0.9;        ///< Among the changing pixels, by the largest change.

/// Brings frames to the size and smoothness at which they are compared.
class Smoother {
 public:
  Smoother(const ImageF& first, const ImageU8& mask, const ProgressOptions& options)
      : width_(first.width()), height_(first.height()), mask_(mask) {
    const double sigma = options.smoothing_px.value_or(std::max(1.5, 0.01 * std::min(width_, height_)));
    const int factor = std::max(1, static_cast<int>(sigma / 1.5));  // Detail finer than the Gaussian is not needed.
    low_width_ = (width_ + factor - 1) / factor;
    low_height_ = (height_ + factor - 1) / factor;
    low_sigma_ = sigma * low_width_ / width_;
    ImageF inside(width_, height_);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) inside.at(x, y) = is_inside(mask, x, y) ? 1.0f : 0.0f;
    }
    coverage_ = downscale_area(inside, low_width_, low_height_);
    low_mask_ = ImageU8(low_width_, low_height_);
    std::transform(coverage_.values().begin(), coverage_.values().end(), low_mask_.values().begin(),
                   [](float c) { return static_cast<std::uint8_t>(c > 0.0f ? 255 : 0); });
  }

  [[nodiscard]] const ImageU8& low_mask() const { return low_mask_; }

  [[nodiscard]] ImageF smooth(ImageF frame, const RunControl& control) const {
    if (frame.width() != width_ || frame.height() != height_ || frame.channels() != 3) {
      throw InvalidInput("progress: the frames differ in size");
    }
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        for (float& v : frame.pixel(x, y)) v = is_inside(mask_, x, y) ? srgb_from_linear(v) : 0.0f;
      }
    }
    ImageF low = downscale_area(frame, low_width_, low_height_, control);
    for (int y = 0; y < low_height_; ++y) {
      for (int x = 0; x < low_width_; ++x) {
        for (float& v : low.pixel(x, y)) v = low_mask_.at(x, y) != 0 ? v / coverage_.at(x, y) : 0.0f;
      }
    }
    return gaussian_blur(low, low_mask_, low_sigma_, control);
  }

  /// Variance of smooth(frame). @param deviation  H x W x 3, linear.
  [[nodiscard]] ImageF smooth_variance(const ImageF& frame, const ImageF& deviation, bool is_shared,
                                       const RunControl& control) const {
    if (!deviation.same_size(frame) || deviation.channels() != 3)
      throw InvalidInput("progress: frames and their deviations differ in size");
    ImageF variance(width_, height_, 3);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        if (!is_inside(mask_, x, y)) continue;
        for (int c = 0; c < 3; ++c) {
          const float v = frame.at(x, y, c), s = std::max(deviation.at(x, y, c), 1e-6f);
          const float code = 0.5f * (srgb_from_linear(v + s) - srgb_from_linear(std::max(0.0f, v - s)));
          variance.at(x, y, c) = deviation.at(x, y, c) > 0.0f ? code * code : 0.0f;
        }
      }
    }
    ImageF low = downscale_area(variance, low_width_, low_height_, control);
    const float pixels = static_cast<float>(width_) / static_cast<float>(low_width_) * static_cast<float>(height_) /
                         static_cast<float>(low_height_);
    for (int y = 0; y < low_height_; ++y) {
      for (int x = 0; x < low_width_; ++x) {
        for (float& v : low.pixel(x, y)) {
          v = low_mask_.at(x, y) != 0 ? v / coverage_.at(x, y) : 0.0f;
          if (!is_shared && low_mask_.at(x, y) != 0) v /= std::max(1.0f, pixels * coverage_.at(x, y));
        }
      }
    }
    // The weights of a Gaussian squared are one of sigma / sqrt 2, of the sum 1 / (4 pi sigma^2).
    low = gaussian_blur(low, low_mask_, low_sigma_ / std::sqrt(2.0), control);
    const double sum = is_shared ? 1.0 : std::min(1.0, 1.0 / (4.0 * std::numbers::pi * low_sigma_ * low_sigma_));
    for (float& v : low.values()) v *= static_cast<float>(sum);
    return low;
  }

  [[nodiscard]] ImageF enlarge(const ImageF& low) const { return resize_bilinear(low, width_, height_); }

 private:
  int width_, height_;
  const ImageU8& mask_;
  int low_width_ = 1, low_height_ = 1;
  double low_sigma_ = 0.0;
  ImageF coverage_;
  ImageU8 low_mask_;
};

float median_of_three(float a, float b, float c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

/// Calls `use(i, d)` with d = change of frame i against the first, for every frame in order.
void for_each_change(int num_frames, const std::function<ImageF(int)>& read_smooth, const RunControl& control,
                     const std::function<void(int, const ImageF&)>& use) {
  const ImageF first = read_smooth(0);
  std::deque<ImageF> window{first, first};  // Frames i - 1, i, i + 1.
  for (int i = 0; i < num_frames; ++i) {
    control.throw_if_stopped();
    if (i + 1 < num_frames) window.push_back(read_smooth(i + 1));
    const bool is_inner = i > 0 && i + 1 < num_frames;
    ImageF change(first.width(), first.height());
    for (int y = 0; y < change.height(); ++y) {
      for (int x = 0; x < change.width(); ++x) {
        float sum = 0.0f;
        for (int c = 0; c < 3; ++c) {
          const float now = window[1].at(x, y, c);
          const float value = is_inner ? median_of_three(window[0].at(x, y, c), now, window[2].at(x, y, c)) : now;
          sum += (value - first.at(x, y, c)) * (value - first.at(x, y, c));
        }
        change.at(x, y) = std::sqrt(sum);
      }
    }
    use(i, change);
    window.pop_front();
    control.report(static_cast<double>(i + 1) / num_frames);
  }
}

/// Trapezoid weights of sum 1.
std::vector<double> time_weights(const std::vector<double>& times) {
  std::vector<double> weights(times.size(), 0.0);
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    if (!(times[i] < times[i + 1])) throw InvalidInput("progress: times must be strictly increasing");
    const double half = 0.5 * (times[i + 1] - times[i]) / (times.back() - times.front());
    weights[i] += half;
    weights[i + 1] += half;
  }
  return weights;
}

ImageF deviation_of(const Smoother& smoother, const std::vector<double>& weights, double aged_change,
                    const std::function<ImageF(int)>& read_frame, const FrameDeviations& deviations,
                    const RunControl& control) {
  const RunControl quiet = control.silent();
  const auto variance_of = [&](int i, const ImageF& frame) {
    return smoother.smooth_variance(frame, deviations.read(i), deviations.is_shared, quiet);
  };
  const ImageF first = read_frame(0);
  ProgressDeviation sum(smoother.smooth(first, quiet), variance_of(0, first), aged_change);
  for (std::size_t i = 1; i < weights.size(); ++i) {
    control.throw_if_stopped();
    const ImageF frame = read_frame(static_cast<int>(i));
    sum.add(weights[i], smoother.smooth(frame, quiet), variance_of(static_cast<int>(i), frame));
    control.report(static_cast<double>(i + 1) / static_cast<double>(weights.size()));
  }
  return smoother.enlarge(sum.result());
}

}  // namespace

void describe(OptionVisitor& v, ProgressOptions& o) {
  v.visit({"progress_sigma", "Gaussian over the frames for the progress map; 1 % of the shorter side when not given",
           "px", between(0, 10000)},
          o.smoothing_px);
}

ProgressMap progress_from_history(const std::vector<double>& times, const std::function<ImageF(int)>& read_frame,
                                  const ImageU8& mask, const ProgressOptions& options, const RunControl& control,
                                  const FrameDeviations& deviations) {
  check_ranges(options);
  if (times.empty()) throw InvalidInput("progress: there are no frames");
  const ImageF first = read_frame(0);
  if (!mask.empty() && !first.same_size(mask)) throw InvalidInput("progress: the mask and the frames differ in size");
  const std::vector<double> weights = time_weights(times);
  const Smoother smoother(first, mask, options);
  const int num_frames = static_cast<int>(times.size());
  const RunControl quiet = control.silent();
  const auto read_smooth = [&](int i) { return smoother.smooth(read_frame(i), quiet); };

  ImageF most(smoother.low_mask().width(), smoother.low_mask().height());
  for_each_change(num_frames, read_smooth, control.part(0.0, deviations.read ? 0.3 : 0.5),
                  [&](int, const ImageF& change) {
                    std::transform(most.values().begin(), most.values().end(), change.values().begin(),
                                   most.values().begin(), [](float a, float b) { return std::max(a, b); });
                  });
  const float threshold =
      std::max(kMinChange, kMinChangeShare * percentiles(most, smoother.low_mask(), 0.99, 0.99).low);
  ImageU8 changing(most.width(), most.height());
  double num_inside = 0, num_changing = 0;
  for (int y = 0; y < most.height(); ++y) {
    for (int x = 0; x < most.width(); ++x) {
      if (smoother.low_mask().at(x, y) == 0) continue;
      ++num_inside;
      if (!(most.at(x, y) > threshold)) continue;
      ++num_changing;
      changing.at(x, y) = 255;
    }
  }
  ProgressMap map{ImageF(first.width(), first.height()), 0.0, 1.0, 0.0, num_changing / num_inside};
  if (num_changing == 0) {
    // Unchanging pixels are 0 for sure: their noise is below what counts as a change.
    if (deviations.read) map.deviation = ImageF(first.width(), first.height());
    control.report(1.0);
    return map;
  }
  map.aged_change = static_cast<double>(percentiles(most, changing, kAgedRank, kAgedRank).low);
  ImageF aged(most.width(), most.height());
  for_each_change(num_frames, read_smooth, control.part(deviations.read ? 0.3 : 0.5, deviations.read ? 0.6 : 1.0),
                  [&](int i, const ImageF& change) {
                    const float weight = static_cast<float>(weights[i]);
                    const float scale = static_cast<float>(1.0 / map.aged_change);
                    std::transform(aged.values().begin(), aged.values().end(), change.values().begin(),
                                   aged.values().begin(),
                                   [&](float sum, float d) { return sum + weight * std::min(1.0f, d * scale); });
                  });
  const Percentiles range = percentiles(aged, changing, 0.01, 0.99);
  map.low = static_cast<double>(range.low);
  map.high = static_cast<double>(range.high);
  map.values = smoother.enlarge(aged);
  if (deviations.read)
    map.deviation = deviation_of(smoother, weights, map.aged_change, read_frame, deviations, control.part(0.6, 1.0));
  return map;
}

ProgressMap progress_from_history(const History& history, const ProgressOptions& options, const RunControl& control) {
  const auto& frames = history.facts().frames;
  const bool has_all = std::all_of(frames.begin(), frames.end(), [](const FrameFacts& f) {
    return std::find(f.extras.begin(), f.extras.end(), "stddev") != f.extras.end();
  });
  FrameDeviations deviations;
  // With scans and lamps, errors come from light and shape, and neighbors share them; with a fixed camera, from noise.
  deviations.is_shared = !history.facts().maps.empty();
  if (has_all) deviations.read = [&](int frame) { return *history.read_frame_extra(frame, "stddev"); };
  return progress_from_history(
      history.times(), [&](int frame) { return history.read_frame(frame); }, history.read_mask(), options, control,
      deviations);
}

}  // namespace patinate::capture
