#include "capture/stability/frame_change.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libcommon/core/median.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::capture {

namespace {

constexpr float kNearBlack = 0.004f;  ///< Linear; one code of 8 bits is a tenth of it and more.
constexpr float kNearWhite = 0.96f;

}  // namespace

FrameChange measure_change(const PreparedFrame& reference, const PreparedFrame& frame,
                           const Eigen::Affine2d& frame_from_reference) {
  const ImageF& a = reference.light;
  const ImageF& b = frame.light;
  if (!a.same_size(b)) throw InvalidInput("change: the frames differ in size");
  const double step_x = reference.scale_x * reference.detail.width() / a.width();  // Pixels of the photograph.
  const double step_y = reference.scale_y * reference.detail.height() / a.height();
  struct Match {
    std::span<const float> before, after;
  };
  std::vector<Match> matches;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const Eigen::Vector2d p =
          frame_from_reference * Eigen::Vector2d((x + 0.5) * step_x - 0.5, (y + 0.5) * step_y - 0.5);
      const double u = std::floor((p.x() + 0.5) / step_x), v = std::floor((p.y() + 0.5) / step_y);
      if (!(u >= 0.0) || !(v >= 0.0) || !(u < b.width()) || !(v < b.height())) continue;
      matches.push_back({a.pixel(x, y), b.pixel(static_cast<int>(u), static_cast<int>(v))});
    }
  }
  FrameChange change;
  if (matches.empty()) return change;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> ratios;
    for (const Match& m : matches) {
      if (m.before[c] < kNearBlack || m.after[c] < kNearBlack || m.before[c] > kNearWhite || m.after[c] > kNearWhite)
        continue;
      ratios.push_back(std::log(static_cast<double>(m.after[c]) / static_cast<double>(m.before[c])));
    }
    constexpr std::size_t kLeastShare = 20;  // One in so many.
    if (kLeastShare * ratios.size() >= matches.size()) change.log_gain[c] = median(std::move(ratios));
  }
  for (const Match& m : matches) {
    double squares = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      const float expected = std::min(1.0f, m.before[c] * static_cast<float>(std::exp(change.log_gain[c])));
      const double d = static_cast<double>(srgb_from_linear(std::min(1.0f, m.after[c])) - srgb_from_linear(expected));
      squares += d * d;
    }
    change.surface += std::sqrt(squares / 3.0);
  }
  change.surface /= static_cast<double>(matches.size());
  return change;
}

}  // namespace patinate::capture
