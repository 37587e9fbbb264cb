#include "capture/stability/light_change.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/median.h"

namespace patinate::capture {

namespace {

using Ratio = std::array<double, 3>;

constexpr std::array<double, 4> kWidths{0.04, 0.08, 0.16, 0.32};  ///< Noise of codes and of resampling is the first.
constexpr double kEnoughPlaces = 0.25;                            ///< Share of the places that a window must hold.
constexpr std::size_t kMaxCandidates = 400;
constexpr int kCenteringRounds = 8;     ///< Of centering on the places that share the gain.
constexpr double kUnchangedVote = 0.5;  ///< Of the commonest gain's share.

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

}  // namespace patinate::capture
