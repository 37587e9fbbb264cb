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

using Ratio = std::array<double, 3>;

constexpr std::array<double, 4> kWidths{0.04, 0.08, 0.16, 0.32};  ///< Noise of codes and of resampling is the first.
constexpr double kEnoughPlaces = 0.25;                            ///< Share of the places that a window must hold.
constexpr std::size_t kMaxCandidates = 400;                       ///< Ratios that are tried as the gain, evenly picked.
constexpr int kCenteringRounds = 8;     ///< Rounds of centering on the places that share the gain.
constexpr double kUnchangedVote = 0.5;  ///< Share of the commonest gain's share.

bool is_shared(const Ratio& ratio, const Ratio& gain, double width) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::abs(ratio[c] - gain[c]) > width) return false;
  }
  return true;
}

double share_of(const std::vector<Ratio>& ratios, const Ratio& gain, double width) {
  const auto sharing =
      std::count_if(ratios.begin(), ratios.end(), [&](const Ratio& r) { return is_shared(r, gain, width); });
  return static_cast<double>(sharing) / static_cast<double>(ratios.size());
}

double size_of(const Ratio& gain) {
  double size = 0.0;
  for (double g : gain) size = std::max(size, std::abs(g));
  return size;
}

/// At most `most`, evenly spread over the picture.
std::vector<Ratio> some_of(const std::vector<Ratio>& ratios, std::size_t most) {
  const std::size_t step = (ratios.size() + most - 1) / most;
  std::vector<Ratio> some;
  for (std::size_t i = 0; i < ratios.size(); i += std::max<std::size_t>(1, step)) some.push_back(ratios[i]);
  return some;
}

/// Moves a gain to the middle of the places that share it.
Ratio centered(const std::vector<Ratio>& ratios, Ratio gain, double width) {
  for (int round = 0; round < kCenteringRounds; ++round) {
    std::array<std::vector<double>, 3> sharing;
    for (const Ratio& r : ratios) {
      if (!is_shared(r, gain, width)) continue;
      for (std::size_t c = 0; c < 3; ++c) sharing[c].push_back(r[c]);
    }
    if (sharing[0].empty()) break;
    Ratio next{};
    for (std::size_t c = 0; c < 3; ++c) next[c] = median(std::move(sharing[c]));
    if (next == gain) break;
    gain = next;
  }
  return gain;
}

/// The gain that the most places share to within `width`, 1 before others. @param share  Becomes their share.
Ratio commonest_gain(const std::vector<Ratio>& ratios, double width, double& share) {
  Ratio best{};
  const double unchanged = share_of(ratios, best, width);
  share = unchanged;
  for (const Ratio& candidate : some_of(ratios, kMaxCandidates)) {
    const double now = share_of(ratios, candidate, width);
    if (now <= share) continue;
    share = now;
    best = candidate;
  }
  if (size_of(best) > 2.0 * width && unchanged >= kUnchangedVote * share) {
    share = unchanged;
    best = {};
  }
  return best;
}

constexpr float kBlackPixel = 0.004f;  ///< Linear; one code of 8 bits is a tenth of it and more.
constexpr float kWhitePixel = 0.96f;   ///< Linear value; brighter places may be clipped.

constexpr float kDarkPlace = 0.01f;  ///< Linear; below, a code more or less is a large ratio.
constexpr int kPlace = 4;            ///< Side of a place in pixels of the coarse light: noise and grain average out.

/// A pixel of the reference and the frame's that lies on it.
struct Match {
  int x = 0, y = 0;  ///< Place in the reference.
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

double LightChange::size() const { return size_of(log_gain); }

bool LightChange::is_sure() const {
  if (!(width > 0.0)) return false;
  return size() <= 2.0 * kWidths.front() ? width <= kWidths.front() : share >= kSharedByMost;
}

LightChange find_light_change(const std::vector<Ratio>& log_ratios) {
  if (log_ratios.empty()) return {};
  LightChange change;
  for (double width : kWidths) {
    change.width = width;
    change.log_gain = commonest_gain(log_ratios, width, change.share);
    if (change.share >= kEnoughPlaces) break;
  }
  change.log_gain = centered(log_ratios, change.log_gain, change.width);
  change.share = share_of(log_ratios, change.log_gain, std::max(change.width, 0.5 * change.size()));
  return change;
}

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
    constexpr std::size_t kMinShare = 20;  // One in so many.
    if (kMinShare * ratios.size() >= matches.size()) change.log_gain[c] = median(std::move(ratios));
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
