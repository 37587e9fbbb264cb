#include "capture/stability/frame_change.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "libcommon/core/median.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::capture {

namespace {

constexpr float kBlackPixel = 0.004f;  ///< Linear; one code of 8 bits is a tenth of it and more.
constexpr float kWhitePixel = 0.96f;

constexpr float kDarkPlace = 0.01f;  ///< Linear; below, a code more or less is a large ratio.
constexpr int kPlace = 4;            ///< Side of a place in pixels of the coarse light: noise and grain average out.

/// A pixel of the reference and the frame's that lies on it.
struct Match {
  int x = 0, y = 0;  ///< Of the reference.
  std::span<const float> before, after;
};

/// Logarithms of the ratios of places, where at least half of a place can be compared.
std::vector<std::array<double, 3>> place_ratios(const std::vector<Match>& matches, int width, int height) {
  struct Sum {
    std::array<double, 3> before{}, after{};
    int count = 0;
  };
  const int columns = (width + kPlace - 1) / kPlace, rows = (height + kPlace - 1) / kPlace;
  std::vector<Sum> places(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const auto is_usable = [](float v) { return v >= kDarkPlace && v <= kWhitePixel; };
  for (const Match& m : matches) {
    if (!std::all_of(m.before.begin(), m.before.end(), is_usable)) continue;
    if (!std::all_of(m.after.begin(), m.after.end(), is_usable)) continue;
    Sum& sum = places[m.y / kPlace * columns + m.x / kPlace];
    for (std::size_t c = 0; c < 3; ++c) {
      sum.before[c] += static_cast<double>(m.before[c]);
      sum.after[c] += static_cast<double>(m.after[c]);
    }
    ++sum.count;
  }
  std::vector<std::array<double, 3>> ratios;
  for (const Sum& sum : places) {
    if (2 * sum.count < kPlace * kPlace) continue;
    ratios.push_back({});
    for (std::size_t c = 0; c < 3; ++c) ratios.back()[c] = std::log(sum.after[c] / sum.before[c]);
  }
  return ratios;
}

}  // namespace

FrameChange measure_change(const PreparedFrame& reference, const PreparedFrame& frame,
                           const Eigen::Affine2d& frame_from_reference) {
  const ImageF& a = reference.light;
  const ImageF& b = frame.light;
  if (!a.same_size(b)) throw InvalidInput("change: the frames differ in size");
  const double step_x = reference.scale_x * reference.detail.width() / a.width();  // Pixels of the photograph.
  const double step_y = reference.scale_y * reference.detail.height() / a.height();
  std::vector<Match> matches;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const Eigen::Vector2d p =
          frame_from_reference * Eigen::Vector2d((x + 0.5) * step_x - 0.5, (y + 0.5) * step_y - 0.5);
      const double u = std::floor((p.x() + 0.5) / step_x), v = std::floor((p.y() + 0.5) / step_y);
      if (!(u >= 0.0) || !(v >= 0.0) || !(u < b.width()) || !(v < b.height())) continue;
      matches.push_back({x, y, a.pixel(x, y), b.pixel(static_cast<int>(u), static_cast<int>(v))});
    }
  }
  FrameChange change;
  if (matches.empty()) return change;
  change.light = find_light_change(place_ratios(matches, a.width(), a.height()));
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> ratios;
    for (const Match& m : matches) {
      if (m.before[c] < kBlackPixel || m.after[c] < kBlackPixel || m.before[c] > kWhitePixel ||
          m.after[c] > kWhitePixel)
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
