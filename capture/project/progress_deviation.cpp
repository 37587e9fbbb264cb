#include "capture/project/progress_deviation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "patinate/core/error.h"

namespace patinate::capture {

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

}  // namespace patinate::capture
