#include "capture/thickness/layer_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "libcommon/image/filters.h"

namespace patinate::capture {

namespace {

constexpr float kWeak = 0.5f;         ///< Below it what is not the commonest value is the most.
constexpr float kAsGood = 0.5f;       ///< A second mode that covers this part of the first competes with it.
constexpr double kFewest = 0.001;     ///< Of the layer: fewer pixels with two modes are chance.
constexpr double kExceptions = 0.05;  ///< Pixels that need not fit, of holes and of what lies beside them.
constexpr double kGrowth = 1.5;       ///< From one window tried to the next.
constexpr double kLayerSigmas = 6.0;  ///< A window that is as wide as the layer: three sigmas to either side.
constexpr int kNoiseDistance_px = 4;  ///< Neighbors of which only noise and grain are different.
constexpr double kMadPerSigma = 0.6745 * std::numbers::sqrt2;  ///< Median of |a - b| for two normal numbers.

double median_of(std::vector<float>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

std::int64_t count_inside(const ImageU8& mask) {
  return std::count_if(mask.values().begin(), mask.values().end(), [](std::uint8_t v) { return v != 0; });
}

/// Standard deviation of noise and grain, from differences between neighbors; cracks are too few to matter.
double noise_of(const ImageF& light, const ImageU8& mask) {
  std::vector<float> differences;
  for (int y = 0; y < light.height(); ++y) {
    for (int x = kNoiseDistance_px; x < light.width(); ++x) {
      if (!is_inside(mask, x, y) || !is_inside(mask, x - kNoiseDistance_px, y)) continue;
      differences.push_back(std::abs(light.at(x, y) - light.at(x - kNoiseDistance_px, y)));
    }
  }
  return median_of(differences) / kMadPerSigma;
}

/// Whether two values compete for pixel `i`.
bool has_rival(const ModeFilterResult& result, std::int64_t i) {
  return result.second_share.data()[i] >= kAsGood * result.share.data()[i];
}

/// Pixels whose commonest value covers little of their window in either pass, though no second one competes.
std::int64_t count_weak(const ModeFilterResult& first, const ModeFilterResult& last, const ImageU8& mask) {
  std::int64_t num_weak = 0;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    num_weak +=
        mask.data()[i] != 0 && std::max(first.share.data()[i], last.share.data()[i]) < kWeak && !has_rival(first, i);
  }
  return num_weak;
}

/// Half way between the two values where two compete; NaN when that is nowhere.
double threshold_of(const ModeFilterResult& first, const ImageU8& mask, std::int64_t num_inside, double& two_modes) {
  std::vector<float> middles;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] == 0 || !has_rival(first, i)) continue;
    middles.push_back(0.5f * (first.values.data()[i] + first.second_value.data()[i]));
  }
  two_modes = static_cast<double>(middles.size()) / static_cast<double>(num_inside);
  return two_modes < kFewest ? std::nan("") : median_of(middles);
}

/// Connected places that let more light through than `threshold`, 4 neighbors.
struct BrightPlaces {
  ImageU8 mask;
  std::int64_t num_pixels = 0;
  std::int64_t largest = 0;  ///< Pixels of the largest.
};

BrightPlaces bright_places(const ImageF& values, const ImageU8& mask, double threshold) {
  BrightPlaces found{ImageU8(mask.width(), mask.height())};
  const auto is_new = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < mask.width() && y < mask.height() && mask.at(x, y) != 0 &&
           found.mask.at(x, y) == 0 && static_cast<double>(values.at(x, y)) > threshold;
  };
  std::vector<std::array<int, 2>> open;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (!is_new(x, y)) continue;
      std::int64_t size = 0;
      found.mask.at(x, y) = 255;
      open.push_back({x, y});
      while (!open.empty()) {
        const auto [px, py] = open.back();
        open.pop_back();
        ++size;
        for (const auto& [dx, dy] : {std::array{1, 0}, std::array{-1, 0}, std::array{0, 1}, std::array{0, -1}}) {
          if (!is_new(px + dx, py + dy)) continue;
          found.mask.at(px + dx, py + dy) = 255;
          open.push_back({px + dx, py + dy});
        }
      }
      found.num_pixels += size;
      found.largest = std::max(found.largest, size);
    }
  }
  return found;
}

/// Whether a wider window gives the layer in the holes, and beside them the same as before to within range_sigma, all
/// but 5 % of either: on sloping paint it does not.
bool is_filled_alone(const ImageF& before, const ImageF& wider, const ImageU8& mask, const ImageU8& holes,
                     double threshold, double range_sigma) {
  std::int64_t num_in_holes = 0, num_left = 0, num_beside = 0, num_changed = 0;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] == 0) continue;
    const double value = static_cast<double>(wider.data()[i]);
    const bool is_hole = holes.data()[i] != 0;
    num_in_holes += is_hole;
    num_left += is_hole && value > threshold;
    num_beside += !is_hole;
    num_changed += !is_hole && std::abs(value - static_cast<double>(before.data()[i])) > range_sigma;
  }
  return static_cast<double>(num_left) <= kExceptions * static_cast<double>(num_in_holes) &&
         static_cast<double>(num_changed) <= kExceptions * static_cast<double>(num_beside);
}

/// The smallest window of those tried that fills the holes alone; 0 when none does before it is as wide as the layer.
double window_that_fills(const ImageF& light, const ImageF& before, const ImageU8& mask, const ImageU8& holes,
                         double threshold, const ModeFilterOptions& options, const RunControl& control) {
  const double widest = std::sqrt(static_cast<double>(count_inside(mask))) / kLayerSigmas;
  ModeFilterOptions wider = options;
  for (;;) {
    wider.spatial_sigma_px = std::ceil(wider.spatial_sigma_px * kGrowth);
    if (wider.spatial_sigma_px > widest) return 0.0;
    const ImageF filled = mode_filter(light, mask, wider, control);
    if (is_filled_alone(before, filled, mask, holes, threshold, options.range_sigma)) return wider.spatial_sigma_px;
  }
}

}  // namespace

LayerEvidence layer_evidence(const ImageF& light, const ModeFilterResult& first, const ModeFilterResult& last,
                             const ImageU8& mask, const ModeFilterOptions& options, const RunControl& control) {
  LayerEvidence evidence;
  const std::int64_t num_inside = count_inside(mask);
  std::vector<float> shares;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i)
    if (mask.data()[i] != 0) shares.push_back(last.share.data()[i]);
  evidence.weak_share = static_cast<double>(count_weak(first, last, mask)) / static_cast<double>(num_inside);
  evidence.share = median_of(shares);
  evidence.noise = noise_of(light, mask);
  const double threshold = threshold_of(first, mask, num_inside, evidence.two_modes);
  if (std::isnan(threshold)) return evidence;
  const BrightPlaces holes = bright_places(first.values, mask, threshold);
  if (holes.num_pixels == 0) return evidence;
  evidence.hole_share = static_cast<double>(holes.num_pixels) / static_cast<double>(num_inside);
  evidence.hole_width_px = 2.0 * std::sqrt(static_cast<double>(holes.largest) / std::numbers::pi);
  evidence.hole_light = static_cast<double>(percentiles(first.values, holes.mask, 0.5, 0.5).low);
  evidence.brightest = static_cast<double>(percentiles(light, mask, 0.5, 0.999).high);
  if (evidence.hole_share < kNamedHoleShare) return evidence;
  evidence.filling_sigma_px = window_that_fills(light, first.values, mask, holes.mask, threshold, options, control);
  return evidence;
}

}  // namespace patinate::capture
